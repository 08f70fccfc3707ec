//! Materials: reflectance as data over [`Field`]s.

use crate::bands::Bands;
use crate::field::{Coordinate, Field, Look, SurfacePoint};
use crate::raster::MaterialRaster;
use glam::DVec3;

/// Semantic class of a surface; the number is the value in `class.png`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Class {
    /// Nothing was hit.
    None = 0,
    /// Bare or paved ground that is none of the others.
    Ground = 1,
    /// Carriageway.
    Road = 2,
    /// Roof and what stands on it.
    Roof = 3,
    /// Wall.
    Facade = 4,
    /// Bridge deck and piers.
    Bridge = 5,
    /// Grass, shrubs, hedges.
    LowVegetation = 6,
    /// Tree.
    Tree = 7,
    /// Water surface.
    Water = 8,
    /// Road or rail vehicle.
    Vehicle = 9,
    /// Boat.
    Boat = 10,
    /// Crop.
    Crop = 11,
    /// Rock.
    Rock = 12,
    /// Sand.
    Sand = 13,
    /// Poles, fences, cranes and other structures.
    OtherStructure = 14,
}

/// How a surface scatters light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Brdf {
    /// Rough diffuse (Oren-Nayar 1994) with facet slope deviation `roughness_rad`; 0 is Lambert.
    Diffuse {
        /// Standard deviation of facet slopes, radians, 0..0.7.
        roughness_rad: f32,
    },
    /// A thin diffuse sheet lit from both sides.
    Leaf {
        /// Transmittance; with the albedo at most 1 in each band.
        transmission: Bands,
    },
    /// A smooth dielectric coat over a diffuse base: glass, car paint, solar panels, still water.
    Coated {
        /// Refractive index of the coat, 1.2..2.
        index: f32,
    },
    /// Water with waves too small to see: it mirrors the sky as still water does, and the sun in facets.
    Water {
        /// Mean square slope of those waves, both axes together, 0.002..0.1 (Cox and Munk 1954: 0.003 + 0.00512 times the wind in
        /// m/s, of all waves).
        slope_variance: f32,
    },
}

impl Brdf {
    /// Refractive index of water.
    pub const WATER_INDEX: f32 = 1.34;

    /// The refractive index of a surface that mirrors.
    pub fn mirror_index(self) -> Option<f32> {
        match self {
            Self::Coated { index } => Some(index),
            Self::Water { .. } => Some(Self::WATER_INDEX),
            Self::Diffuse { .. } | Self::Leaf { .. } => None,
        }
    }
}

/// Where one layer changes the colour below it.
#[derive(Clone, Debug)]
pub enum Layer {
    /// Towards a colour, by an amount 0..1.
    Mix {
        /// The colour, reflectance.
        color: Bands,
        /// How much of it, clamped to 0..1.
        amount: Field,
    },
    /// Brighter or darker: times `1 + amount`, not below 0.
    Brightness {
        /// Relative change.
        amount: Field,
    },
    /// Each band by its own part of an amount: times `1 + tint * amount`.
    Tint {
        /// Relative change in each band at amount 1.
        tint: Bands,
        /// How much.
        amount: Field,
    },
    /// Towards the colour of a stack of beds at a stratigraphic height.
    Strata {
        /// The stack.
        beds: Beds,
        /// Stratigraphic height, m.
        height: Field,
        /// How much of it, clamped to 0..1.
        amount: Field,
    },
    /// Towards one of several colours, drawn by one of the instance's numbers.
    Choice {
        /// The colours; equal shares of -1..1.
        colors: Vec<Bands>,
        /// Which of the instance's numbers.
        variation: u8,
    },
}

/// A stack of coloured beds over height.
#[derive(Clone, Debug, PartialEq)]
pub struct Beds {
    /// Upper border of each bed, ascending, m.
    tops_m: Vec<f32>,
    colors: Vec<Bands>,
    /// Integral of the colour from the first bed's top's height zero up to each top.
    integral: Vec<[f64; 4]>,
}

impl Beds {
    /// A stack from the lowest bed up: the top's height, m, ascending, and the reflectance. The first reaches down and
    /// the last up without end.
    pub fn new(beds: &[(f32, Bands)]) -> Self {
        assert!(!beds.is_empty(), "a stack needs a bed");
        let tops_m: Vec<f32> = beds.iter().map(|b| b.0).collect();
        let colors: Vec<Bands> = beds.iter().map(|b| b.1).collect();
        let mut integral = vec![[0.0; 4]];
        for i in 1..beds.len() {
            let thick = f64::from(tops_m[i] - tops_m[i - 1]);
            let last = integral[i - 1];
            integral.push(core::array::from_fn(|b| last[b] + thick * f64::from(colors[i].0[b])));
        }
        Self { tops_m, colors, integral }
    }

    fn index(&self, z: f64) -> usize {
        self.tops_m.partition_point(|t| f64::from(*t) < z).min(self.colors.len() - 1)
    }

    fn integral_to(&self, z: f64) -> [f64; 4] {
        let i = self.index(z);
        let from = f64::from(if i == 0 { self.tops_m[0] } else { self.tops_m[i - 1] });
        let base = if i == 0 { [0.0; 4] } else { self.integral[i - 1] };
        core::array::from_fn(|b| base[b] + (z - from) * f64::from(self.colors[i].0[b]))
    }

    /// Mean colour of heights `z ± width / 2`.
    pub fn mean(&self, z_m: f64, width_m: f64) -> Bands {
        if width_m < 1e-4 {
            return self.colors[self.index(z_m)];
        }
        let low = self.integral_to(z_m - width_m / 2.0);
        let high = self.integral_to(z_m + width_m / 2.0);
        Bands(core::array::from_fn(|b| ((high[b] - low[b]) / width_m) as f32))
    }
}

/// Relief too fine for triangles: it turns the shading normal and nothing else.
#[derive(Clone, Debug)]
pub struct Bump {
    /// Height field; its unit is `amplitude_m`.
    pub field: Field,
    /// Height of field value 1, m.
    pub amplitude_m: f32,
}

/// A surface: what it is, its reflectance, and how it scatters.
#[derive(Clone, Debug)]
pub struct Material {
    /// For people and object tables.
    pub name: String,
    /// Semantic class of its triangles.
    pub class: Class,
    /// Reflectance before the layers.
    pub base: Bands,
    /// Applied in order.
    pub layers: Vec<Layer>,
    /// Scattering.
    pub brdf: Brdf,
    /// Fine relief.
    pub bump: Option<Bump>,
}

/// A material at one point: what the renderer needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shade {
    /// Diffuse reflectance, 0..0.95 in every band.
    pub albedo: Bands,
    /// Scattering.
    pub brdf: Brdf,
    /// Unit shading normal, world frame, on the viewer's side.
    pub normal: DVec3,
}

/// No natural surface reflects more; above it inter-reflection would not die out.
const MAX_ALBEDO: f32 = 0.95;

impl Material {
    /// A plain diffuse surface, to which layers can be added.
    pub fn diffuse(name: &str, class: Class, base: Bands) -> Self {
        Self {
            name: name.to_owned(),
            class,
            base,
            layers: Vec::new(),
            brdf: Brdf::Diffuse { roughness_rad: 0.0 },
            bump: None,
        }
    }

    /// With one more layer.
    #[must_use]
    pub fn with(mut self, layer: Layer) -> Self {
        self.layers.push(layer);
        self
    }

    /// With a facet roughness, radians.
    #[must_use]
    pub fn rough(mut self, roughness_rad: f32) -> Self {
        self.brdf = Brdf::Diffuse { roughness_rad };
        self
    }

    /// With fine relief.
    #[must_use]
    pub fn bumpy(mut self, field: Field, amplitude_m: f32) -> Self {
        self.bump = Some(Bump { field, amplitude_m });
        self
    }

    /// The material's reflectance and normal at a point, means over its footprint.
    pub fn shade(&self, p: &SurfacePoint, rasters: &[MaterialRaster]) -> Shade {
        let mut look = Look::new(p, rasters);
        let mut albedo = self.base;
        for layer in &self.layers {
            albedo = layer.apply(albedo, &mut look);
        }
        Shade {
            albedo: albedo.map(|v| v.clamp(0.0, MAX_ALBEDO)),
            brdf: self.brdf,
            normal: self.bump.as_ref().map_or(p.normal, |bump| bump.normal(p, rasters)),
        }
    }
}

impl Layer {
    fn apply<'a>(&'a self, below: Bands, look: &mut Look<'a>) -> Bands {
        match self {
            Self::Mix { color, amount } => below.lerp(*color, amount.at(look).mean.clamp(0.0, 1.0)),
            Self::Brightness { amount } => below * (1.0 + amount.at(look).mean).max(0.0),
            Self::Tint { tint, amount } => {
                let k = amount.at(look).mean;
                Bands(core::array::from_fn(|b| below.0[b] * (1.0 + tint.0[b] * k).max(0.0)))
            }
            Self::Strata { beds, height, amount } => {
                let share = amount.at(look).mean.clamp(0.0, 1.0);
                if share == 0.0 {
                    return below;
                }
                let z = height.at(look);
                let p = look.point;
                let horizontal = (1.0 - p.normal.z * p.normal.z).max(0.0).sqrt();
                let width_m = p.footprint_m * horizontal.max(0.02) + 2.0 * f64::from(z.variance.sqrt());
                below.lerp(beds.mean(f64::from(z.mean), width_m), share)
            }
            Self::Choice { colors, variation } => {
                let unit = (look.point.variation[*variation as usize] * 0.5 + 0.5).clamp(0.0, 0.999_99);
                colors[(unit * colors.len() as f32) as usize]
            }
        }
    }
}

impl Bump {
    /// The normal of the surface raised by the field: from its slope over the plan where that is known, else by
    /// differences in the tangent plane.
    fn normal(&self, p: &SurfacePoint, rasters: &[MaterialRaster]) -> DVec3 {
        if self.field.is_hidden(p.footprint_m) {
            return p.normal;
        }
        let amplitude_m = f64::from(self.amplitude_m);
        if let Some([x, y]) = self.field.slope(p) {
            let gradient = DVec3::new(x, y, 0.0) * amplitude_m;
            return (p.normal - gradient + p.normal * gradient.dot(p.normal)).normalize();
        }
        let step = (p.footprint_m * 0.5).max(0.02);
        let (t, b) = p.normal.any_orthonormal_pair();
        let height = |d: DVec3| {
            let shifted =
                SurfacePoint { world_m: p.world_m + d, object_m: p.object_m + d, uv_m: p.uv_m + d.truncate(), ..*p };
            f64::from(self.field.evaluate(&shifted, rasters).mean)
        };
        let k = amplitude_m / step;
        // One sided, from half a step behind: three evaluations, and no bias.
        let start = (t + b) * (-0.5 * step);
        let here = height(start);
        let slope_t = (height(start + t * step) - here) * k;
        let slope_b = (height(start + b * step) - here) * k;
        (p.normal - t * slope_t - b * slope_b).normalize()
    }
}

/// The stratigraphic height of a flat-lying stack: the world's height.
impl Default for Field {
    fn default() -> Self {
        Self::Along(Coordinate::HEIGHT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn point(z: f64, normal: DVec3) -> SurfacePoint {
        SurfacePoint {
            world_m: DVec3::new(1.0, 2.0, z),
            object_m: DVec3::new(1.0, 2.0, z),
            uv_m: DVec2::ZERO,
            normal,
            footprint_m: 0.3,
            variation: [0.0; 4],
        }
    }

    #[test]
    fn beds_average_by_thickness() {
        let beds = Beds::new(&[(0.0, Bands::grey(0.1)), (1.0, Bands::grey(0.5)), (9.0, Bands::grey(0.3))]);
        assert_eq!(beds.mean(-4.0, 0.0), Bands::grey(0.1));
        assert_eq!(beds.mean(0.5, 0.0), Bands::grey(0.5));
        assert_eq!(beds.mean(40.0, 0.0), Bands::grey(0.3));
        let mean = beds.mean(0.5, 2.0).0[0];
        assert!((mean - (0.5 * 0.1 + 1.0 * 0.5 + 0.5 * 0.3) / 2.0).abs() < 1e-6, "{mean}");
    }

    #[test]
    fn layers_act_in_order_and_albedo_stays_physical() {
        let m = Material::diffuse("m", Class::Ground, Bands::grey(0.5))
            .with(Layer::Mix { color: Bands::grey(0.9), amount: Field::Constant(0.5) })
            .with(Layer::Brightness { amount: Field::Constant(5.0) });
        assert_eq!(m.shade(&point(0.0, DVec3::Z), &[]).albedo, Bands::grey(MAX_ALBEDO));
    }

    #[test]
    fn bump_of_a_ramp_is_its_normal() {
        let m = Material::diffuse("m", Class::Ground, Bands::grey(0.5))
            .bumpy(Field::Along(Coordinate { space: crate::Space::World, axis: 0 }), 0.5);
        let n = m.shade(&point(0.0, DVec3::Z), &[]).normal;
        let expected = DVec3::new(-0.5, 0.0, 1.0).normalize();
        assert!((n - expected).length() < 1e-6, "{n}");
    }
}
