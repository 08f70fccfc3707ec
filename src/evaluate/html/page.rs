//! What pages of numbers are made of.

pub(crate) use super::chart::{Series, draw, key};

use std::fmt::Write as _;

const STYLE: &str = "
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#5c6773;--line:#d5dae0;--paper:#fff;--mark:#f3f5f7}
@media(prefers-color-scheme:dark){:root{--ink:#e6e9ec;--soft:#9aa4ae;--line:#3a424b;--paper:#15181c;--mark:#1f242a}}
body{font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:72rem;margin:0 auto;padding:1rem}
h1{font-size:1.5rem}h2{font-size:1.15rem;margin:2.2rem 0 .4rem}p{margin:.4rem 0;max-width:46rem;overflow-wrap:anywhere}
.soft{color:var(--soft)}.wide{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .7rem;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th:first-child,td:first-child{text-align:left}th{color:var(--soft);font-weight:500}
.say{background:var(--mark);border-left:4px solid #d55e00;padding:.5rem .8rem;margin:.5rem 0}
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(20rem,1fr));gap:1rem}
.four{display:grid;grid-template-columns:repeat(auto-fit,minmax(14rem,1fr));gap:.6rem}
figure{margin:0}figcaption{color:var(--soft);font-size:.85rem}
figure img{width:100%;image-rendering:pixelated;display:block;background:var(--mark)}
svg{width:100%;height:auto;display:block;overflow:visible}svg text{fill:var(--soft);font:11px system-ui,sans-serif}
.key{display:flex;flex-wrap:wrap;gap:.2rem 1rem;font-size:.85rem}.key i{display:inline-block;width:.9em;height:.9em;margin-right:.35em;vertical-align:-.1em}
details{margin:.4rem 0}summary{cursor:pointer;color:var(--soft)}
";

/// A page up to its first heading.
pub(crate) fn begin(title: &str) -> String {
    let mut page = String::with_capacity(1 << 20);
    page.push_str("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">");
    page.push_str("<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">");
    put(&mut page, format_args!("<title>{}</title><style>{STYLE}</style></head><body>\n", escape(title)));
    page
}

/// The page with its end.
pub(crate) fn end(mut page: String) -> String {
    page.push_str("</body></html>\n");
    page
}

/// Appends to a text, which cannot fail.
pub(crate) fn put(page: &mut String, text: std::fmt::Arguments<'_>) {
    page.write_fmt(text).expect("a String takes any text");
}

/// A stranger's text as HTML.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}
