//! Curves as one HTML file.

use super::curves::{CellScores, Curves, SceneScores};
use crate::evaluate::Scores;
use crate::evaluate::page::{Series, begin, draw, end, escape, key, put};

/// As many scenes are drawn line by line; of more, the lowest, the middle and the highest.
const MOST_SCENES: usize = 6;

/// A metric of all pixels of a cell, and of one scene.
type Metric = (&'static str, fn(&CellScores) -> Option<f64>, fn(&SceneScores) -> Option<f64>);

const METRICS: [Metric; 3] = [
    ("EPE where both see, px", |c| noc(c).epe_px, |s| s.noc_epe_px),
    ("bad 1 where both see, %", |c| noc(c).bad_1.map(|b| b * 100.0), |s| s.noc_bad_1.map(|b| b * 100.0)),
    ("EPE of occluded pixels, px", |c| c.evaluation.total.scores.occ.epe_px, |s| s.occ_epe_px),
];

fn noc(cell: &CellScores) -> &Scores {
    &cell.evaluation.total.scores.noc
}

/// The curves as one page that needs no network and runs no script: along the last key that is varied, a plot for each
/// combination of the others.
pub fn html_report(curves: &Curves) -> String {
    let mut page = begin("satseed sweep");
    let vary = &curves.sweep.vary;
    let keys = vary.iter().map(|v| v.key.as_str()).collect::<Vec<_>>().join(", ");
    put(&mut page, format_args!("<h1>{} over {} cells</h1>\n", escape(&keys), curves.scores.len()));
    put(
        &mut page,
        format_args!(
            "<p class=\"soft\">Scenes, seeds and pairs are the same in every cell. A scene's line is the mean of its \
             samples' own scores.</p>\n"
        ),
    );
    let Some(along) = vary.last() else { return end(page) };
    for (row, cells) in curves.scores.chunks(along.values.len()).enumerate() {
        let indexed = &curves.sweep.cells[row * along.values.len()];
        let fixed: Vec<String> =
            indexed.values.iter().filter(|(k, _)| **k != along.key).map(|(k, v)| format!("{k} = {v}")).collect();
        let heading = if fixed.is_empty() { along.key.clone() } else { format!("{}, {}", along.key, fixed.join(", ")) };
        put(&mut page, format_args!("<h2>{}</h2>\n<div class=\"pair\">", escape(&heading)));
        for (title, of_cell, of_scene) in METRICS {
            draw(&mut page, title, &along.values, &series(cells, of_cell, of_scene), true);
        }
        page.push_str("</div>\n");
        key(&mut page, &series(cells, METRICS[0].1, METRICS[0].2));
    }
    end(page)
}

fn series(
    cells: &[CellScores],
    of_cell: fn(&CellScores) -> Option<f64>,
    of_scene: fn(&SceneScores) -> Option<f64>,
) -> Vec<Series> {
    let mut all = vec![Series { name: "all".to_owned(), values: cells.iter().map(of_cell).collect() }];
    let names: Vec<&str> =
        cells.iter().flat_map(|c| &c.scenes).map(|s| s.scene.as_str()).fold(Vec::new(), |mut l, s| {
            if !l.contains(&s) {
                l.push(s);
            }
            l
        });
    if names.len() < 2 {
        return all;
    }
    if names.len() <= MOST_SCENES {
        let value = |cell: &CellScores, name: &str| cell.scenes.iter().find(|s| s.scene == name).and_then(of_scene);
        all.extend(names.iter().map(|name| Series {
            name: (*name).to_owned(),
            values: cells.iter().map(|cell| value(cell, name)).collect(),
        }));
        return all;
    }
    let sorted: Vec<Vec<f64>> = cells
        .iter()
        .map(|cell| {
            let mut values: Vec<f64> = cell.scenes.iter().filter_map(of_scene).collect();
            values.sort_by(f64::total_cmp);
            values
        })
        .collect();
    for (name, at) in [("lowest scene", 0.0), ("middle scene", 0.5), ("highest scene", 1.0)] {
        let pick = |v: &Vec<f64>| v.get(((v.len().max(1) - 1) as f64 * at).round() as usize).copied();
        all.push(Series { name: name.to_owned(), values: sorted.iter().map(pick).collect() });
    }
    all
}
