//! What grows: crops in their stages, with height, row distance and colour.

use satseed_scene::Bands;

/// The time of the year, drawn by seed: which stages stand side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Season {
    /// Cereals green, rape in pod, maize and beet in open rows, much bare soil.
    Early,
    /// Cereals ripe or cut, maize tall, beet closed.
    Late,
}

/// How a crop stands on its ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form {
    /// A closed canopy, drilled in rows narrower than a pixel; tramlines this far apart, m (0: none).
    Slab {
        /// Height, m.
        height_m: f64,
        /// Distance of the rows, m; texture.
        row_m: f64,
        /// Width of a sprayer's boom, m.
        boom_m: f64,
    },
    /// Plants in rows, as geometry.
    Rows {
        /// Distance of the rows, m.
        row_m: f64,
        /// Height, m.
        height_m: f64,
        /// Half the width of a row, m.
        half_m: f64,
        /// Rows of one pass of the machine.
        pass: u32,
    },
    /// Trees in rows.
    Orchard {
        /// Distance of the rows, m.
        row_m: f64,
        /// Distance within a row, m.
        tree_m: f64,
    },
    /// Nothing that stands: swaths or bales may lie on it.
    Flat,
}

/// What covers a parcel. The order is that of [`TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Crop {
    WheatGreen,
    WheatRipe,
    Barley,
    Rape,
    RapeRipe,
    MaizeYoung,
    MaizeTall,
    Soy,
    Potato,
    BeetYoung,
    Beet,
    Vines,
    Orchard,
    Pasture,
    Meadow,
    Hay,
    Stubble,
    Straw,
    Bales,
    Tilled,
    Seedbed,
    Copse,
    Yard,
}

/// What is known of a crop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    pub(super) crop: Crop,
    pub(super) name: &'static str,
    /// Species: two stages of one are not two crops.
    pub(super) species: u8,
    pub(super) form: Form,
    /// Reflectance from above: of the canopy, or of the ground's cover.
    pub(super) color: Bands,
    /// Weight of being drawn in the mosaic early and late, and under pivots.
    pub(super) weights: [f64; 3],
    /// How much of the ground the cover hides where it is no geometry, 0..1.
    pub(super) cover: f32,
}

const fn slab(height_m: f64, row_m: f64, boom_m: f64) -> Form {
    Form::Slab { height_m, row_m, boom_m }
}

const fn rows(row_m: f64, height_m: f64, half_m: f64, pass: u32) -> Form {
    Form::Rows { row_m, height_m, half_m, pass }
}

macro_rules! table {
    ($($crop:ident $name:literal $species:literal $form:expr, [$($c:literal),*], [$($w:literal),*], $cover:literal;)*) => {
        /// All crops, in the order of [`Crop`].
        pub(super) const TABLE: &[Facts] = &[$(Facts {
            crop: Crop::$crop,
            name: $name,
            species: $species,
            form: $form,
            color: Bands([$($c),*]),
            weights: [$($w),*],
            cover: $cover,
        }),*];
    };
}

// Class values: canopies of the crop spectra of USGS splib07 and of the radiometry page, darkened by their own shadow.
table! {
    WheatGreen "wheat, green" 0 slab(0.78, 0.15, 24.0), [0.042, 0.085, 0.066, 0.33], [5.0, 0.0, 2.0], 1.0;
    WheatRipe "wheat, ripe" 0 slab(0.85, 0.15, 24.0), [0.108, 0.160, 0.192, 0.31], [0.0, 4.0, 2.5], 1.0;
    Barley "barley, ripe" 1 slab(0.72, 0.15, 28.0), [0.122, 0.172, 0.198, 0.33], [2.0, 2.0, 0.5], 1.0;
    Rape "rape in pod" 2 slab(1.35, 0.25, 24.0), [0.058, 0.108, 0.094, 0.32], [3.0, 0.0, 0.0], 1.0;
    RapeRipe "rape, ripe" 2 slab(1.25, 0.25, 24.0), [0.092, 0.128, 0.145, 0.28], [0.0, 1.6, 0.0], 1.0;
    MaizeYoung "maize, young" 3 rows(0.76, 0.38, 0.23, 8), [0.042, 0.082, 0.060, 0.36], [3.5, 0.0, 2.0], 0.45;
    MaizeTall "maize, tall" 3 rows(0.76, 2.05, 0.43, 8), [0.039, 0.075, 0.058, 0.36], [0.0, 3.5, 3.0], 0.9;
    Soy "soy" 4 rows(0.76, 0.60, 0.345, 12), [0.047, 0.087, 0.066, 0.38], [0.4, 1.0, 3.0], 0.7;
    Potato "potatoes" 5 rows(0.75, 0.46, 0.33, 4), [0.045, 0.080, 0.064, 0.34], [1.5, 1.5, 0.8], 0.7;
    BeetYoung "beet, young" 6 slab(0.22, 0.5, 27.0), [0.054, 0.100, 0.086, 0.30], [2.0, 0.0, 0.0], 0.6;
    Beet "beet" 6 slab(0.45, 0.5, 27.0), [0.044, 0.082, 0.065, 0.37], [0.0, 2.5, 0.0], 1.0;
    Vines "vines" 7 rows(2.2, 1.7, 0.34, 1), [0.040, 0.080, 0.058, 0.34], [0.9, 0.9, 0.0], 0.3;
    Orchard "orchard" 8 Form::Orchard { row_m: 4.6, tree_m: 3.6 }, [0.060, 0.098, 0.072, 0.32], [0.7, 0.7, 0.0], 0.9;
    Pasture "pasture" 9 Form::Flat, [0.056, 0.100, 0.084, 0.30], [2.2, 2.0, 1.0], 0.92;
    Meadow "meadow, uncut" 10 slab(0.42, 0.0, 0.0), [0.062, 0.106, 0.092, 0.31], [1.4, 0.8, 1.2], 1.0;
    Hay "meadow, cut" 10 Form::Flat, [0.084, 0.126, 0.120, 0.29], [1.4, 1.0, 1.0], 0.85;
    Stubble "stubble" 11 Form::Flat, [0.112, 0.154, 0.184, 0.28], [0.0, 2.2, 1.6], 0.75;
    Straw "stubble with swaths" 11 Form::Flat, [0.108, 0.150, 0.180, 0.28], [0.0, 2.0, 0.6], 0.75;
    Bales "stubble with bales" 11 Form::Flat, [0.114, 0.156, 0.186, 0.29], [0.0, 2.2, 0.8], 0.8;
    Tilled "tilled soil" 12 Form::Flat, [0.080, 0.110, 0.146, 0.20], [2.4, 2.0, 1.6], 0.0;
    Seedbed "seedbed" 12 Form::Flat, [0.100, 0.136, 0.176, 0.23], [1.6, 0.8, 1.0], 0.0;
    Copse "copse" 14 Form::Flat, [0.062, 0.092, 0.080, 0.26], [0.9, 0.9, 0.0], 0.9;
    Yard "farmyard" 15 Form::Flat, [0.150, 0.172, 0.188, 0.22], [0.0, 0.0, 0.0], 0.9;
}

impl Crop {
    /// Its facts.
    pub(super) fn facts(self) -> &'static Facts {
        &TABLE[self as usize]
    }

    /// Whether it may stand on a parcel of any shape: nothing of it is laid out in rows of geometry.
    pub(super) fn is_loose(self) -> bool {
        matches!(self.facts().form, Form::Flat) && !matches!(self, Self::Straw | Self::Hay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order() {
        for (k, facts) in TABLE.iter().enumerate() {
            assert_eq!(facts.crop as usize, k, "{}", facts.name);
            if let Form::Rows { row_m, .. } = facts.form {
                assert!(row_m >= 0.7, "{}: narrower rows are texture", facts.name);
            }
        }
    }
}
