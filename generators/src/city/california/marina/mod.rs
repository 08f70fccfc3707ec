//! A marina: basins full of floating docks between moles, a channel, and banks with apartments, restaurants and beaches.

mod banks;
pub(super) mod berths;
pub(super) mod boats;
pub(super) mod docks;
pub(super) mod harbour;
mod parcels;

use super::assemble::Assembly;
use super::land::Land;
use super::layout::Grid;
use super::lot::Content;
use super::{DETAIL_MARGIN_M, Params, RING_M};
use crate::coast;
use berths::{Afloat, Moored};
use boats::{Boat, INDIVIDUALS};
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Class, MaterialRaster, Mesh, Raster, SeedPath};

/// Everything of a harbour that is neither ground nor stands on it.
#[derive(Clone, Debug, Default)]
pub(super) struct Marina {
    pub(super) docks: Vec<Moored>,
    pub(super) boats: Vec<Afloat>,
    /// Timber piers: name, foot on the shore and direction, world; length and half width, m.
    pub(super) piers: Vec<(String, DVec2, DVec2, [f64; 2])>,
}

/// Distance of posts of the raster of depths, m.
const CELL_M: f64 = 2.0;

/// Decides the harbour of a land that has one.
pub(super) fn plan(params: &Params, grid: &Grid, land: &Land, city: &SeedPath) -> (Vec<(String, Content)>, Marina) {
    let (mut parts, mut marina) = (Vec::new(), Marina::default());
    let Some(harbour) = land.harbour() else { return (parts, marina) };
    let (reach, detail) = (params.radius_m + RING_M, params.radius_m + DETAIL_MARGIN_M);
    for cell in &harbour.cells {
        let nearest =
            DVec2::ZERO.clamp(DVec2::new(cell.x[0], harbour.streets[0]), DVec2::new(cell.x[1], harbour.streets[1]));
        if let Some(water) = banks::water(cell, land) {
            parts.push((format!("harbour/water/{}", cell.k), water));
        }
        if nearest.length() > reach {
            continue;
        }
        parts.extend(banks::plan(params, cell, harbour, grid, land, city));
        parts.extend(parcels::plan(params, cell, harbour, land, city, reach));
        let fleet = berths::fleet(cell, harbour, land, params.vehicles, city);
        marina.docks.extend(fleet.docks.into_iter().filter(|d| d.at.length() < reach));
        marina.boats.extend(fleet.boats.into_iter().filter(|b| b.at.length() < detail));
        marina.piers.extend(banks::pier(cell, harbour, land, city));
    }
    (parts, marina)
}

/// The raster that the water's material reads: its depth.
fn depths(land: &Land, half_m: f64) -> Option<MaterialRaster> {
    let harbour = land.harbour()?;
    let n = (2.0 * half_m / CELL_M) as usize + 1;
    let shape = Raster::filled(DVec2::splat(-half_m), CELL_M, n, n, ());
    let rows: Vec<Vec<[u8; MaterialRaster::CHANNELS]>> = (0..n)
        .into_par_iter()
        .map(|j| {
            let post = |i| {
                let mut post = [0; MaterialRaster::CHANNELS];
                let depth = harbour.depth_m(land.turned_back(shape.position(i, j)));
                post[0] = (coast::coded_depth(depth) * 255.0 + 0.5) as u8;
                post
            };
            (0..n).map(post).collect()
        })
        .collect();
    Some(MaterialRaster::new(Raster {
        origin_m: shape.origin_m,
        cell_m: CELL_M,
        width: n,
        height: n,
        data: rows.concat(),
    }))
}

/// Adds what floats, and the raster of depths.
pub(super) fn assemble(a: &mut Assembly<'_>, land: &Land, marina: &Marina, reach_m: f64) {
    let Some(raster) = depths(land, reach_m) else { return };
    a.scene.rasters.push(raster);
    let water = |p: DVec2| p.extend(harbour::WATER_M);
    let key = a.city.child("boat kind");
    let kinds: Vec<(Boat, u64)> = Boat::ALL.iter().flat_map(|b| (0..INDIVIDUALS).map(|n| (*b, n))).collect();
    let meshes: Vec<Mesh> =
        kinds.par_iter().enumerate().map(|(k, (boat, n))| boat.mesh(*n, &mut key.index(k as u64).rng())).collect();
    let first = a.scene.meshes.len() as u32;
    a.scene.meshes.extend(meshes);
    for b in &marina.boats {
        let key = a.city.child(&b.name);
        let set = a.materials.boat_set(&key);
        let kind = kinds.iter().position(|k| *k == (b.boat, b.individual)).unwrap_or(0) as u32;
        a.put(first + kind, (water(b.at), b.axis), (b.name.clone(), Class::Vehicle), set);
    }
    let made: Vec<Mesh> = marina.docks.par_iter().map(|d| d.dock.mesh(&mut a.city.child(&d.name).rng())).collect();
    for (d, mesh) in marina.docks.iter().zip(made) {
        let set = a.materials.dock_set(&a.city.child(&d.name));
        let mesh = a.mesh(mesh);
        a.put(mesh, (water(d.at), d.axis), (d.name.clone(), Class::OtherStructure), set);
    }
    for (name, at, axis, [length_m, half_m]) in &marina.piers {
        let set = a.materials.dock_set(&a.city.child(name));
        let mesh = a.mesh(docks::pier(*length_m, *half_m));
        a.put(mesh, (water(*at), *axis), (name.clone(), Class::OtherStructure), set);
    }
}

#[cfg(test)]
mod tests;
