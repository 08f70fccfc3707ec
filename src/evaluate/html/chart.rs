//! Line plots as SVG.

use super::page::{escape, put};

/// Colours that people with any colour vision tell apart (Okabe and Ito, 2008); the first is the page's own ink.
const COLOURS: [&str; 8] = ["var(--ink)", "#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#b3a100"];

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 262.0;
const LEFT: f64 = 42.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = 74.0;

/// One line of a plot: a value for each name, where there is one.
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) values: Vec<Option<f64>>,
}

/// Draws the values over their names, from zero up. `joined` draws lines through them: where the names have an order.
pub(crate) fn draw(page: &mut String, title: &str, names: &[String], series: &[Series], joined: bool) {
    let most = series.iter().flat_map(|s| s.values.iter().flatten()).fold(0.0_f64, |a, b| a.max(*b));
    let step = step(most);
    let top = step * (most / step).ceil().max(1.0);
    let bottom = HEIGHT - BOTTOM;
    let x = |i: usize| LEFT + (WIDTH - LEFT - 8.0) * (i as f64 + 0.5) / names.len().max(1) as f64;
    let y = |value: f64| bottom - (bottom - TOP) * value / top;
    put(
        page,
        format_args!(
            "<figure><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{0}\"><text x=\"4\" \
             y=\"12\">{0}</text>",
            escape(title)
        ),
    );
    let lines = (top / step).round() as usize;
    for k in 0..=lines {
        let value = step * k as f64;
        let (right, at) = (WIDTH - 8.0, y(value));
        put(page, format_args!("<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"var(--line)\"/>"));
        let digits = if step < 0.1 { 2 } else { usize::from(step < 1.0) };
        let (label_x, label_y) = (LEFT - 5.0, at + 4.0);
        put(page, format_args!("<text x=\"{label_x}\" y=\"{label_y:.1}\" text-anchor=\"end\">{value:.digits$}</text>"));
    }
    for (i, name) in names.iter().enumerate() {
        let (at, below) = (x(i), bottom + 12.0);
        put(
            page,
            format_args!(
                "<text transform=\"translate({at:.1} {below}) rotate(-40)\" text-anchor=\"end\">{}</text>",
                escape(name)
            ),
        );
    }
    for (s, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        let mut path = String::new();
        let mut pen = 'M';
        for (i, value) in s.values.iter().enumerate() {
            // A missing value interrupts the line.
            let Some(value) = value else {
                pen = 'M';
                continue;
            };
            put(&mut path, format_args!("{pen}{:.1} {:.1}", x(i), y(*value)));
            pen = 'L';
        }
        if joined {
            put(page, format_args!("<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>"));
        }
        for (i, value) in s.values.iter().enumerate() {
            let Some(value) = value else { continue };
            let (at, high) = (x(i), y(*value));
            let (name, of) = (escape(&s.name), escape(&names[i]));
            put(
                page,
                format_args!(
                    "<circle cx=\"{at:.1}\" cy=\"{high:.1}\" r=\"2.6\" fill=\"{colour}\"><title>{name}, {of}: \
                     {value:.3}</title></circle>"
                ),
            );
        }
    }
    page.push_str("</svg></figure>");
}

/// Names the lines.
pub(crate) fn key(page: &mut String, series: &[Series]) {
    page.push_str("<p class=\"key\">");
    for (s, colour) in series.iter().zip(COLOURS.iter().cycle()) {
        put(page, format_args!("<span><i style=\"background:{colour}\"></i>{}</span>", escape(&s.name)));
    }
    page.push_str("</p>\n");
}

/// A round step of which four to eight reach the most.
fn step(most: f64) -> f64 {
    if !(most > 0.0 && most.is_finite()) {
        return 1.0;
    }
    let mut step = 1.0;
    while step * 4.0 > most {
        step /= 10.0;
    }
    while step * 40.0 <= most {
        step *= 10.0;
    }
    [1.0, 2.0, 5.0].into_iter().map(|k| k * step).find(|s| most / s <= 8.0).unwrap_or(step * 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (most, expected) in [(1.0, 0.2), (0.9, 0.2), (8.0, 1.0), (9.0, 2.0), (100.0, 20.0), (0.03, 0.005)] {
            assert!((step(most) / expected - 1.0).abs() < 1e-9, "{most}: {}", step(most));
        }
        assert_eq!((step(0.0), step(f64::NAN), step(f64::INFINITY)), (1.0, 1.0, 1.0));
    }

    #[test]
    fn missing_values_interrupt_the_line() {
        let mut page = String::new();
        let values = vec![Some(1.0), None, Some(2.0), Some(4.0)];
        let names = ["a", "b", "c", "<d>"].map(str::to_owned);
        draw(&mut page, "<t>", &names, &[Series { name: "x&y".into(), values }], true);
        assert_eq!(page.matches("<circle").count(), 3);
        let line = page.split("fill=\"none\"").next().unwrap().rsplit("<path d=\"").next().unwrap();
        assert_eq!((line.matches('M').count(), line.matches('L').count()), (2, 1), "{line}");
        assert!(page.contains("x&amp;y, &lt;d&gt;: 4.000") && !page.contains("<t>"), "{page}");
    }
}
