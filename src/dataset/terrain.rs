//! Figures of a scene from its surface models, over its circle of full detail: what all frames of its pivot see together.

use super::formats::HeightMap;
use serde::Serialize;

/// What stands higher above the ground than this is a tower, m (spec: towers are above 60 m).
const TOWER_M: f64 = 60.0;
/// What stands higher above the ground than this is no car or hedge, m.
const RAISED_M: f64 = 2.5;
/// The smallest area that is a tower and no mast, square metres.
const TOWER_AREA_M2: f64 = 100.0;
/// Tangent of 60 degrees.
const TAN_60: f64 = 1.732_050_807_568_877_2;

/// Figures over a scene's circle of full detail, seen as a map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SceneFigures {
    /// Highest minus lowest bare ground, m.
    pub relief_m: f64,
    /// Share of the bare ground that is steeper than 60 degrees.
    pub steeper_than_60_deg_fraction: f64,
    /// Share of the map that stands 2.5 m or more above the ground: buildings, trees, bridges.
    pub raised_fraction: f64,
    /// Share of the map that stands 60 m or more above the ground.
    pub above_60_m_fraction: f64,
    /// Towers: connected parts above 60 m of at least 100 square metres.
    pub towers: usize,
    /// Median of the towers' heights above the ground, m; none without towers.
    pub tower_height_median_m: Option<f64>,
}

impl SceneFigures {
    /// Counts the cells within `radius_m` from the pivot. Both maps must have the same grid; where they have not, only the
    /// ground is counted.
    pub fn of(dsm: &HeightMap, dtm: &HeightMap, radius_m: f64) -> Self {
        let (width, height) = (dtm.width as usize, dtm.height as usize);
        let inside = |i: usize, j: usize| {
            let (x, y) = (dtm.west_m + i as f64 * dtm.cell_m, dtm.south_m + j as f64 * dtm.cell_m);
            x * x + y * y <= radius_m * radius_m
        };
        let ground = |i: usize, j: usize| f64::from(dtm.heights_m[j * width + i]);
        let same_grid = (dsm.width, dsm.height) == (dtm.width, dtm.height);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut cells, mut slopes, mut steep, mut raised, mut tall) = (0_u64, 0_u64, 0_u64, 0_u64, 0_u64);
        // Height above the ground where it is a tower's, 0 elsewhere.
        let mut towers = vec![0.0_f32; if same_grid { width * height } else { 0 }];
        for j in 0..height {
            for i in 0..width {
                let z = ground(i, j);
                if z.is_nan() || !inside(i, j) {
                    continue;
                }
                cells += 1;
                low = low.min(z);
                high = high.max(z);
                if (1..width.saturating_sub(1)).contains(&i) && (1..height.saturating_sub(1)).contains(&j) {
                    let dx = (ground(i + 1, j) - ground(i - 1, j)) / (2.0 * dtm.cell_m);
                    let dy = (ground(i, j + 1) - ground(i, j - 1)) / (2.0 * dtm.cell_m);
                    slopes += 1;
                    steep += u64::from((dx * dx + dy * dy).sqrt() > TAN_60);
                }
                if same_grid {
                    let above = f64::from(dsm.heights_m[j * width + i]) - z;
                    raised += u64::from(above >= RAISED_M);
                    tall += u64::from(above >= TOWER_M);
                    if above >= TOWER_M {
                        towers[j * width + i] = above as f32;
                    }
                }
            }
        }
        let share = |n: u64, of: u64| n as f64 / of.max(1) as f64;
        let mut heights = tower_heights(towers, width, (TOWER_AREA_M2 / (dtm.cell_m * dtm.cell_m)) as usize);
        heights.sort_unstable_by(f64::total_cmp);
        Self {
            relief_m: if low <= high { high - low } else { 0.0 },
            steeper_than_60_deg_fraction: share(steep, slopes),
            raised_fraction: share(raised, cells),
            above_60_m_fraction: share(tall, cells),
            towers: heights.len(),
            tower_height_median_m: heights.get(heights.len() / 2).copied(),
        }
    }
}

/// The height of every connected part (four neighbours) of at least `least_cells`: that which a tenth of its cells
/// exceed, so that a mast on a roof does not count.
fn tower_heights(mut above_m: Vec<f32>, width: usize, least_cells: usize) -> Vec<f64> {
    let mut heights = Vec::new();
    for start in 0..above_m.len() {
        if above_m[start] == 0.0 {
            continue;
        }
        let mut part = Vec::new();
        let mut open = vec![start];
        while let Some(cell) = open.pop() {
            let height = std::mem::take(&mut above_m[cell]);
            if height == 0.0 {
                continue;
            }
            part.push(height);
            let i = cell % width;
            if i > 0 {
                open.push(cell - 1);
            }
            if i + 1 < width {
                open.push(cell + 1);
            }
            if cell >= width {
                open.push(cell - width);
            }
            if cell + width < above_m.len() {
                open.push(cell + width);
            }
        }
        if part.len() >= least_cells.max(1) {
            part.sort_unstable_by(f32::total_cmp);
            heights.push(f64::from(part[part.len() * 9 / 10]));
        }
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(height: impl Fn(f64, f64) -> f64) -> HeightMap {
        let (n, cell_m, west_m) = (201_u32, 1.0, -100.0);
        let at = |k: usize| height(west_m + (k % 201) as f64, west_m + (k / 201) as f64) as f32;
        HeightMap { west_m, south_m: west_m, cell_m, width: n, height: n, heights_m: (0..201 * 201).map(at).collect() }
    }

    #[test]
    fn a_town_of_boxes() {
        let ground = map(|_, _| 5.0);
        let boxes = [
            (-60.0, -60.0, 20.0, 80.0),
            (0.0, 0.0, 30.0, 120.0),
            (40.0, -40.0, 20.0, 150.0),
            (-50.0, 30.0, 20.0, 12.0),
        ];
        let town = map(|x, y| {
            let inside = boxes.iter().find(|(bx, by, s, _)| x >= *bx && x < bx + s && y >= *by && y < by + s);
            5.0 + inside.map_or(0.0, |b| b.3)
        });
        let figures = SceneFigures::of(&town, &ground, 100.0);
        assert_eq!((figures.relief_m, figures.steeper_than_60_deg_fraction), (0.0, 0.0));
        assert_eq!((figures.towers, figures.tower_height_median_m), (3, Some(120.0)));
        let cells =
            (0..201 * 201).filter(|k| (k % 201 - 100_i32).pow(2) + (k / 201 - 100_i32).pow(2) <= 10_000).count();
        assert_eq!(figures.above_60_m_fraction, (400 + 900 + 400) as f64 / cells as f64);
        assert_eq!(figures.raised_fraction, (400 + 900 + 400 + 400) as f64 / cells as f64);
    }

    #[test]
    fn a_ramp_has_its_slope() {
        for (slope, steep) in [(1.7, 0.0), (1.8, 1.0)] {
            let ramp = map(|x, _| slope * x);
            let figures = SceneFigures::of(&ramp, &ramp, 50.0);
            assert_eq!(figures.steeper_than_60_deg_fraction, steep);
            assert!((figures.relief_m - slope * 100.0).abs() < 1e-4);
            assert_eq!((figures.towers, figures.tower_height_median_m), (0, None));
        }
    }
}
