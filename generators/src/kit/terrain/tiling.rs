//! Square tiles around the pivot, in full detail within a radius and coarse in a ring beyond it.

use super::tin::{Grain, Layout};
use glam::{DAffine3, DVec2, DVec3};
use satseed_scene::{Instance, Mesh, Scene};

/// Tiles of a scene.
#[derive(Clone, Debug)]
pub struct Tiling {
    /// All tiles.
    pub layout: Layout,
    /// Half the side of the square that holds all tiles of full detail, m.
    pub window_half_m: f64,
}

impl Tiling {
    /// Tiles of side `tile_m` that reach `ring_m` beyond the radius of full detail. `grain` says how finely a tile
    /// follows the ground, by the distance of its nearest point from the pivot, m.
    pub fn new(tile_m: f64, radius_m: f64, ring_m: f64, grain: impl Fn(f64) -> Grain) -> Self {
        let half = |reach: f64| libm::ceil(reach / tile_m);
        let tiles = (2.0 * half(radius_m + ring_m)) as usize;
        let origin_m = DVec2::splat(-half(radius_m + ring_m) * tile_m);
        let grains = (0..tiles * tiles)
            .map(|t| {
                let low = origin_m + DVec2::new((t % tiles) as f64, (t / tiles) as f64) * tile_m;
                grain(DVec2::ZERO.clamp(low, low + tile_m).length())
            })
            .collect();
        let layout = Layout { origin_m, tile_m, columns: tiles, rows: tiles, grains };
        Self { layout, window_half_m: half(radius_m) * tile_m }
    }

    /// Half the side of the square of all tiles, m.
    pub fn scene_half_m(&self) -> f64 {
        -self.layout.origin_m.x
    }
}

/// Places finished tiles as object 0 with material set 0.
pub fn place_terrain(scene: &mut Scene, tiles: Vec<Mesh>) {
    for mesh in tiles {
        scene.instances.push(Instance {
            mesh: scene.meshes.len() as u32,
            world_from_object: DAffine3::IDENTITY,
            object: 0,
            material_set: 0,
            variation: [0.0; 4],
        });
        scene.meshes.push(mesh);
    }
}

/// The unit normal of a ground with an eastward and northward slope, as a mesh holds it.
pub fn normal_of_slope(slope: DVec2) -> [f32; 3] {
    DVec3::new(-slope.x, -slope.y, 1.0).normalize().as_vec3().to_array()
}
