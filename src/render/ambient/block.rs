//! What a block of nodes receives.

use super::super::light::Light;
use super::super::shading::incoming;
use super::lattice::{BlockKey, SIDE, Scale};
use super::{Ask, HALF_WEIGHT_M};
use glam::{DVec2, DVec3};
use satseed_scene::{Bands, Brdf, Ray};
use satseed_tracer::{Hit, Origin, Tracer};

/// Directions over the whole sphere; a node uses those before its own surface.
const DIRECTIONS: u32 = 64;
/// The same for leaves.
const DIRECTIONS_OF_LEAVES: u32 = 32;
/// Least cosine between a surface and the axis of its lattice: who asks there has at least 1 / sqrt(3).
const LEAST_LEAN: f64 = 0.4;
/// Least cosine between a node's surface and a direction that it uses.
const LEAST_COSINE: f64 = 0.02;

/// The directions that nodes look in.
#[derive(Debug)]
pub(super) struct Dome {
    surface: Set,
    foliage: Set,
}

impl Dome {
    pub(super) fn new(light: &Light) -> Self {
        Self { surface: Set::new(light, DIRECTIONS), foliage: Set::new(light, DIRECTIONS_OF_LEAVES) }
    }

    fn of(&self, scale: Scale) -> &Set {
        match scale {
            Scale::Surface => &self.surface,
            Scale::Foliage => &self.foliage,
        }
    }
}

/// Directions of one number.
#[derive(Debug)]
struct Set {
    directions: Vec<DVec3>,
    /// Solid angle of a direction, sr, so that open flat ground receives exactly the sky's irradiance.
    solid_angle: Bands,
}

impl Set {
    /// A spherical Fibonacci set (Swinbank and Purser 2006).
    fn new(light: &Light, count: u32) -> Self {
        const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
        let directions: Vec<DVec3> = (0..count)
            .map(|k| {
                let z = 1.0 - f64::from(2 * k + 1) / f64::from(count);
                let radius = (1.0 - z * z).sqrt();
                let (s, c) = libm::sincos(f64::from(k) * GOLDEN_ANGLE);
                DVec3::new(radius * c, radius * s, z).normalize()
            })
            .collect();
        let mut open = Bands::ZERO;
        for d in directions.iter().filter(|d| d.z > LEAST_COSINE) {
            open += light.sky_radiance(*d) * d.z as f32;
        }
        let mut solid_angle = light.sky_irradiance;
        for (angle, open) in solid_angle.0.iter_mut().zip(open.0) {
            *angle /= open;
        }
        Self { directions, solid_angle }
    }
}

/// What arrives at one surface point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    point_m: [f32; 3],
    normal: [f32; 3],
    /// Vector irradiance: its product with a normal is the irradiance there, W / (m^2 um), axis by axis.
    vector: [Bands; 3],
}

impl Node {
    fn at(hit: &Hit) -> Self {
        Self {
            point_m: hit.point.as_vec3().to_array(),
            normal: hit.normal.as_vec3().to_array(),
            vector: [Bands::ZERO; 3],
        }
    }

    /// Irradiance on a surface with this normal.
    pub(super) fn irradiance(&self, normal: DVec3) -> Bands {
        let n = normal.as_vec3();
        let mut sum = self.vector[0] * n.x + self.vector[1] * n.y + self.vector[2] * n.z;
        for band in &mut sum.0 {
            *band = band.max(0.0);
        }
        sum
    }

    /// How well the node stands for a point of another surface nearby, 0..1: it should lie in that one's plane and face
    /// its way.
    pub(super) fn fit(&self, ask: &Ask) -> f64 {
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let facing = double(self.normal).dot(ask.geometric).max(0.0);
        let off = (double(self.point_m) - ask.point_m).dot(ask.geometric) / HALF_WEIGHT_M;
        facing * facing / (1.0 + off * off)
    }
}

/// The nodes of one block.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) nodes: Vec<Node>,
    pub(super) places: Places,
}

/// For each place of a block the number of its node; beyond the last where no surface is.
pub(super) type Places = [u8; NODES];

/// Places of a block.
pub(super) const NODES: usize = (SIDE * SIDE) as usize;
const NONE: u8 = u8::MAX;

impl Block {
    /// Works out all nodes of a block.
    pub(super) fn new(tracer: &Tracer, light: &Light, dome: &Dome, key: BlockKey) -> Self {
        let (outward, dome) = (key.face.direction(), dome.of(key.scale));
        let mut places = [NONE; NODES];
        let (mut nodes, mut starts) = (Vec::new(), Vec::new());
        for (place, number) in places.iter_mut().enumerate() {
            let line = Ray { origin: key.entry_m(place), direction: -outward };
            let Some(hit) = tracer.closest(&line, key.scale.slab_m()) else { continue };
            let leaf = is_leaf(tracer, &hit);
            // A line that begins inside something solid meets it from within: no light there.
            if !leaf && (is_back(&hit, line.direction) || hit.normal.dot(outward) < LEAST_LEAN) {
                continue;
            }
            *number = nodes.len() as u8;
            nodes.push(Node::at(&hit));
            // Leaves lie in every direction: a node among them stands for what comes from one side.
            starts.push((Origin::on(&hit), if leaf { outward } else { hit.normal }));
        }
        let (mut asked, mut rays) = (Vec::new(), Vec::new());
        for (k, direction) in dome.directions.iter().enumerate() {
            asked.clear();
            rays.clear();
            for (i, (start, normal)) in starts.iter().enumerate() {
                if direction.dot(*normal) > LEAST_COSINE {
                    asked.push(i);
                    rays.push((*start, *direction));
                }
            }
            if rays.is_empty() {
                continue;
            }
            // Over the directions, points spread over the sun's disc (Roberts 2018).
            let square = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3) * (k as f64 + 0.5);
            let square = square - DVec2::new(libm::floor(square.x), libm::floor(square.y));
            let d = direction.as_vec3();
            for (i, radiance) in asked.iter().zip(incoming(tracer, light, &rays, |_| square)) {
                let arriving = radiance * dome.solid_angle;
                let vector = &mut nodes[*i].vector;
                vector[0] += arriving * d.x;
                vector[1] += arriving * d.y;
                vector[2] += arriving * d.z;
            }
        }
        Self { nodes, places }
    }

    /// The node of a place, where there is one.
    pub(super) fn node(&self, place: usize) -> Option<&Node> {
        self.nodes.get(usize::from(self.places[place]))
    }
}

fn is_leaf(tracer: &Tracer, hit: &Hit) -> bool {
    matches!(tracer.scene().material(hit.instance, hit.triangle).brdf, Brdf::Leaf { .. })
}

/// Whether a ray of this direction met the side that the triangle's winding turns away.
fn is_back(hit: &Hit, direction: DVec3) -> bool {
    let [a, b, c] = hit.corners;
    (b - a).cross(c - a).dot(direction) > 0.0
}
