//! What a building is before it is triangles.

use crate::kit::mesh_builder::Wall;
use crate::kit::polygon;
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Material slots that every building mesh uses; a building's material set says what stands in each.
pub mod slot {
    /// Opaque wall.
    pub const WALL: u16 = 0;
    /// Glazing behind the wall's plane, with its window cells.
    pub const GLASS: u16 = 1;
    /// Slab edges and spandrels.
    pub const SLAB: u16 = 2;
    /// Parapet tops and inner faces, copings, ridge caps.
    pub const COPING: u16 = 3;
    /// Strip along a parapet's foot.
    pub const STRIP: u16 = 4;
    /// Roof.
    pub const ROOF: u16 = 5;
    /// Sheet metal of roof furniture.
    pub const METAL: u16 = 6;
    /// Shop windows of the ground floor.
    pub const SHOP: u16 = 7;
    /// Balcony guards.
    pub const GUARD: u16 = 8;
    /// Solar panels.
    pub const PANEL: u16 = 9;
    /// Planted roofs and beds.
    pub const GREEN: u16 = 10;
    /// Openings of fans, louvres.
    pub const DARK: u16 = 11;
    /// A second roof or terrace covering.
    pub const TERRACE: u16 = 12;
    /// Number of slots.
    pub const COUNT: usize = 13;
}

/// How a wall is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Facade {
    /// A flat wall; windows, if any, are in its material.
    Plain,
    /// Glazing set back behind slab edges of every floor: most condominiums.
    Slabs {
        /// Depth of the set-back, m.
        recess_m: f64,
        /// Height of the slab edge, m.
        slab_m: f64,
        /// A full-height pier at every n-th bay; 0 for none.
        pier_every: u32,
    },
    /// Bands of wall and piers around recessed windows: masonry and precast.
    Punched {
        /// Depth of the windows, m.
        recess_m: f64,
        /// Height of the band between two rows of windows, m.
        band_m: f64,
        /// Width of a pier, m.
        pier_m: f64,
        /// How far piers stand before the bands, m; negative: behind.
        proud_m: f64,
    },
    /// Glass skin with thin fins.
    Curtain {
        /// Depth of a fin, m.
        fin_m: f64,
    },
}

/// What covers a mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Roof {
    /// Flat behind a parapet.
    Flat {
        /// Height of the parapet, m.
        parapet_m: f64,
        /// Its slot for the covering.
        slot: u16,
    },
    /// Two slopes with the ridge along x (true) or y of a four-cornered outline.
    Gable {
        /// Ridge along the first edge's direction.
        along_first: bool,
        /// Rise of the ridge above the eaves, m.
        rise_m: f64,
        /// Overhang at the eaves, m.
        eaves_m: f64,
        /// Share of the half-length that the ridge is cut back at each end: 0 gable, up to 1 hip and pyramid.
        hip: f64,
    },
}

/// A row of balconies, one above another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Balcony {
    /// Which edge of the outline.
    pub edge: usize,
    /// Begin and end along it, m.
    pub span_m: [f64; 2],
    /// Depth, m.
    pub depth_m: f64,
    /// Only on every n-th floor.
    pub every: u32,
}

/// One block of a building; heights above the building's ground level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mass {
    /// Outline in the building's frame, counter-clockwise.
    pub outline: Vec<DVec2>,
    /// Where its walls begin, m: below ground, or inside the mass below it.
    pub low_m: f64,
    /// Roof or eaves, m.
    pub roof_m: f64,
    /// Height of the lowest full floor's slab, m.
    pub first_floor_m: f64,
    /// Height of a floor, m.
    pub floor_m: f64,
    /// Width of a bay, m.
    pub bay_m: f64,
    /// Glazed shop base below `first_floor_m`.
    pub shop: bool,
    /// Wall.
    pub facade: Facade,
    /// Roof.
    pub roof: Roof,
    /// Balconies.
    pub balconies: Vec<Balcony>,
}

/// Kinds of things on roofs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RoofItemKind {
    /// Packaged air handler: a box with an intake hood at one end, a fan at the other of short ones.
    AirHandler,
    /// Condenser: fans in a row, as many as it is longer than wide.
    Condenser,
    /// Cooling tower: a fan's stack on a box.
    CoolingTower,
    /// Screen around a plant: four walls.
    Screen,
    /// Duct.
    Duct,
    /// Stair or lift head.
    Bulkhead,
    /// Pipe or small fan.
    Vent,
    /// Skylight.
    Skylight,
    /// Row of solar panels.
    Panels,
    /// Round tank.
    Tank,
    /// Planted bed.
    Bed,
    /// Chimney.
    Chimney,
    /// Antenna mast.
    Mast,
}

/// One thing on a roof.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoofItem {
    /// What.
    pub kind: RoofItemKind,
    /// Centre in the building's frame, m.
    pub centre_m: DVec2,
    /// Direction of its first axis.
    pub axis: DVec2,
    /// Half sizes, m.
    pub half_m: DVec2,
    /// Height of the roof it stands on, m.
    pub base_m: f64,
    /// Its own height, m.
    pub height_m: f64,
}

/// A building as data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BuildingPlan {
    /// Origin of its frame in the world's plane, m.
    pub centre_m: DVec2,
    /// Its x axis in the world's plane.
    pub axis: DVec2,
    /// World height of its ground level, m.
    pub ground_m: f64,
    /// Lowest terrain under it, m below `ground_m` (not negative).
    pub drop_m: f64,
    /// Blocks, the main one first.
    pub masses: Vec<Mass>,
    /// Roof furniture.
    pub items: Vec<RoofItem>,
}

impl Mass {
    /// How its walls are laid out.
    pub fn wall(&self) -> Wall {
        Wall { bay_m: self.bay_m, floor_m: self.floor_m, datum_m: self.first_floor_m }
    }
}

impl BuildingPlan {
    /// A point of its frame in the world's plane.
    pub fn to_world(&self, p: DVec2) -> DVec2 {
        self.centre_m + self.axis * p.x + self.axis.perp() * p.y
    }

    /// Outline of a mass in the world's plane.
    pub fn world_outline(&self, mass: &Mass) -> Vec<DVec2> {
        mass.outline.iter().map(|p| self.to_world(*p)).collect()
    }

    /// Highest roof above ground level, m, without furniture.
    pub fn roof_m(&self) -> f64 {
        self.masses.iter().map(|m| m.roof_m).fold(0.0, f64::max)
    }

    /// Area of the masses that stand on the ground, m^2 (overlaps counted once where they nest).
    pub fn footprint_m2(&self) -> f64 {
        self.masses.iter().filter(|m| m.low_m < 0.0).map(|m| polygon::area(&m.outline)).sum()
    }
}
