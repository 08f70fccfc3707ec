//! An evaluation as one HTML file: tables, plots as SVG, pictures of the worst samples. It opens without a network and runs
//! no script.

mod chart;
pub(crate) mod page;
mod pictures;

use super::breakdown::Breakdown;
use super::report::Evaluation;
use super::score::Scores;
use super::source::Source;
use super::{EvaluateError, Options};
use chart::Series;
use page::{escape, put};
use std::path::Path;

/// Samples whose pictures are shown.
const WORST: usize = 6;
/// Break-downs in the order in which they are shown, with their titles.
const ORDER: [(&str, &str); 8] = [
    ("texture", "Texture"),
    ("disparity", "Disparity"),
    ("slope", "Slope"),
    ("height", "Height above ground"),
    ("class", "Class"),
    ("shadow", "Shadow"),
    ("boundary_distance", "Distance to the next boundary"),
    ("baseline", "Baseline"),
];

/// The report of an evaluation. The worst samples are read again, one at a time.
///
/// # Errors
/// Where the labels of one of them cannot be read any more.
pub fn html_report(
    source: Source<'_>,
    predictions: &Path,
    options: &Options,
    evaluation: &Evaluation,
) -> Result<String, EvaluateError> {
    let e = evaluation;
    let mut page = page::begin("satseed evaluation");
    head(&mut page, e);
    scores(&mut page, e);
    for (by, title) in ORDER {
        if let Some(breakdown) = e.total.by.get(by) {
            plots(&mut page, e, by, title, breakdown);
        }
    }
    worst(&mut page, source, predictions, options, e)?;
    Ok(page::end(page))
}

fn head(page: &mut String, e: &Evaluation) {
    let split = e.split.as_ref().map(|s| format!(" of split {}", escape(s))).unwrap_or_default();
    put(page, format_args!("<h1>{} of {} samples{split} evaluated</h1>\n", e.evaluated, e.samples));
    if let Some(hash) = &e.dataset_root_hash {
        put(page, format_args!("<p class=\"soft\">Dataset {}</p>\n", escape(hash)));
    }
    for m in &e.likely_mistakes {
        let told = escape(&m.told);
        put(
            page,
            format_args!("<p class=\"say\">Likely mistake in {} of {} samples, {told}.</p>\n", m.samples, e.evaluated),
        );
    }
    let missing = e.missing.iter().map(|id| format!("{id} has no prediction")).collect::<Vec<_>>();
    let unusable = e.unusable.iter().map(|u| format!("{}: {}", u.file, u.reason)).collect::<Vec<_>>();
    let strangers = e.strangers.iter().map(|f| format!("{f} belongs to no sample")).collect::<Vec<_>>();
    list(page, "samples without a prediction", &missing);
    list(page, "predictions that cannot be used", &unusable);
    list(page, "files that belong to no sample", &strangers);
    for note in &e.notes {
        put(page, format_args!("<p class=\"soft\">Note: {}.</p>\n", escape(note)));
    }
}

fn list(page: &mut String, title: &str, lines: &[String]) {
    if lines.is_empty() {
        return;
    }
    put(page, format_args!("<details class=\"say\"><summary>{} {title}</summary>", lines.len()));
    for line in lines {
        put(page, format_args!("{}<br>", escape(line)));
    }
    page.push_str("</details>\n");
}

fn px(value: Option<f64>) -> String {
    value.map_or_else(|| "&ndash;".to_owned(), |v| format!("{v:.3}"))
}

fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| "&ndash;".to_owned(), |v| format!("{:.2} %", v * 100.0))
}

const HEADS: &str = "<th>pixels</th><th>EPE px</th><th>bias px</th><th>within 1 px</th><th>within 3 px</th><th>bad 1</th>\
                     <th>bad 3</th><th>D1</th><th>unpredicted</th>";

fn row(page: &mut String, name: &str, s: &Scores) {
    put(
        page,
        format_args!(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>\
             <td>{}</td></tr>\n",
            escape(name),
            s.pixels,
            px(s.epe_px),
            px(s.bias_px),
            percent(s.within_1),
            percent(s.within_3),
            percent(s.bad_1),
            percent(s.bad_3),
            percent(s.d1),
            percent(s.unpredicted)
        ),
    );
}

fn scores(page: &mut String, e: &Evaluation) {
    let t = &e.total;
    put(page, format_args!("<h2>Scores</h2><div class=\"wide\"><table><tr><th></th>{HEADS}</tr>\n"));
    row(page, "both cameras see (noc)", &t.scores.noc);
    row(page, "occluded (occ)", &t.scores.occ);
    row(page, "all", &t.scores.all);
    row(page, "all, within 5 px of a jump", &t.boundary.within_5_px.all);
    for r in &e.regions {
        row(page, &format!("{}/{} (noc)", r.region, r.variant), &r.group.scores.noc);
    }
    page.push_str("</table></div>\n");
    let (i, b) = (&t.epe_images_px, &t.boundary);
    put(
        page,
        format_args!(
            "<p class=\"soft\">Mean of the samples' own mean errors: {} px noc, {} px occ, {} px all. Soft edge error \
             beside a jump: {} px in 3 x 3, {} px in 5 x 5. Not counted: {} pixels beyond the right frame, {} where \
             nothing was hit. A pixel without a prediction counts as bad and stands in no mean.</p>\n",
            px(i.noc),
            px(i.occ),
            px(i.all),
            px(b.see_3_px),
            px(b.see_5_px),
            t.out_of_frame_pixels,
            t.nothing_hit_pixels
        ),
    );
}

fn plots(page: &mut String, e: &Evaluation, by: &str, title: &str, breakdown: &Breakdown) {
    put(page, format_args!("<h2>{title}</h2><p class=\"soft\">By {}.</p>\n", escape(breakdown.of)));
    let names: Vec<&str> = breakdown.rows.iter().map(|r| r.name.as_str()).collect();
    let shown: Vec<String> = breakdown.rows.iter().map(|r| range(by, &r.name, r.from, r.to)).collect();
    let joined = !matches!(by, "class" | "shadow");
    let series = |of: fn(&Scores) -> Option<f64>| -> Vec<Series> {
        let all = Series { name: "all".to_owned(), values: breakdown.rows.iter().map(|r| of(&r.scores.noc)).collect() };
        let regions = e.regions.iter().filter(|_| e.regions.len() > 1).map(|region| {
            let rows = region.group.by.get(by).map_or(&[][..], |b| &b.rows);
            let value = |name: &&str| rows.iter().find(|r| r.name == **name).and_then(|r| of(&r.scores.noc));
            Series { name: format!("{}/{}", region.region, region.variant), values: names.iter().map(value).collect() }
        });
        std::iter::once(all).chain(regions).collect()
    };
    page.push_str("<div class=\"pair\">");
    chart::draw(page, "EPE of noc, px", &shown, &series(|s| s.epe_px), joined);
    chart::draw(page, "bad 1 of noc, %", &shown, &series(|s| s.bad_1.map(|b| b * 100.0)), joined);
    page.push_str("</div>\n");
    chart::key(page, &series(|s| s.epe_px));
    put(
        page,
        format_args!("<details><summary>Numbers</summary><div class=\"wide\"><table><tr><th>noc</th>{HEADS}</tr>\n"),
    );
    for r in &breakdown.rows {
        row(page, &range(by, &r.name, r.from, r.to), &r.scores.noc);
    }
    put(page, format_args!("<tr><th>occ</th>{HEADS}</tr>\n"));
    for r in &breakdown.rows {
        row(page, &range(by, &r.name, r.from, r.to), &r.scores.occ);
    }
    page.push_str("</table></div></details>\n");
}

/// A row's name; tenths of the pixels are told by where they lie.
fn range(by: &str, name: &str, from: Option<f64>, to: Option<f64>) -> String {
    match (by, from, to) {
        ("texture", Some(from), Some(to)) => format!("{from:.1} to {to:.1}"),
        _ => name.to_owned(),
    }
}

fn worst(
    page: &mut String,
    source: Source<'_>,
    predictions: &Path,
    options: &Options,
    e: &Evaluation,
) -> Result<(), EvaluateError> {
    let mut order: Vec<_> = e.each.iter().collect();
    let worse = |s: &Scores| (s.bad_3.unwrap_or(0.0), s.epe_px.unwrap_or(0.0));
    order.sort_by(|a, b| {
        let (a, b) = (worse(&a.scores.noc), worse(&b.scores.noc));
        b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    page.push_str("<h2>The worst samples</h2><p class=\"soft\">By bad 3 where both cameras see.</p>\n");
    pictures::key(page);
    for sample in order.into_iter().take(WORST) {
        let s = &sample.scores.noc;
        put(
            page,
            format_args!(
                "<h3>{}</h3><p class=\"soft\">{}: EPE {} px, bad 1 {}, bad 3 {}</p>\n",
                escape(&sample.id),
                escape(&sample.file),
                px(s.epe_px),
                percent(s.bad_1),
                percent(s.bad_3)
            ),
        );
        if let Some(item) = source.items().into_iter().find(|item| item.id() == sample.id) {
            pictures::sample(page, item, predictions, options, sample)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strangers_write_no_html() {
        assert_eq!(escape("<script>\"a\" & 'b'"), "&lt;script&gt;&quot;a&quot; &amp; &#39;b&#39;");
    }
}
