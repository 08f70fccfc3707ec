//! Texts that a recipe comes from, places in them, and what is said of a mistake there.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A text that values come from: a recipe file, a preset, a seed list, or one `--set`.
#[derive(Debug)]
pub(super) struct Source {
    /// What messages call it.
    pub(super) name: String,
    /// All of it.
    pub(super) text: String,
    /// How its places are named.
    pub(super) kind: SourceKind,
}

/// How a place in a source is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SourceKind {
    /// `name:line:column`
    File,
    /// `--set key=value, column N`: it has one line.
    Argument,
}

impl Source {
    pub(super) fn new(name: impl Into<String>, text: impl Into<String>, kind: SourceKind) -> Arc<Self> {
        Arc::new(Self { name: name.into(), text: text.into(), kind })
    }
}

/// Where a key or a value stands.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    source: Arc<Source>,
    start: usize,
    end: usize,
}

impl Origin {
    pub(super) fn new(source: &Arc<Source>, span: Range<usize>) -> Self {
        Self { source: Arc::clone(source), start: span.start, end: span.end.max(span.start) }
    }

    /// The whole source's beginning: for what is missing altogether.
    pub(super) fn beginning(source: &Arc<Source>) -> Self {
        Self::new(source, 0..0)
    }

    /// The mistake `message` at this place.
    pub(super) fn error(&self, message: impl Into<String>) -> RecipeError {
        RecipeError { message: plain(&message.into(), MESSAGE_CHARS), place: Some(Box::new(self.place())) }
    }

    fn place(&self) -> Place {
        let text = &self.source.text;
        let start = floor_boundary(text, self.start);
        let end = floor_boundary(text, self.end).max(start);
        let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let line_end = text[line_start..].find('\n').map_or(text.len(), |i| line_start + i);
        let line = text[..line_start].bytes().filter(|b| *b == b'\n').count() + 1;
        let before = text[line_start..start].chars().count();
        let marked = text[start..end.min(line_end).max(start)].chars().count().max(1);
        // A window of a long line, so that a line of a megabyte does not fill the terminal.
        let skipped = before.saturating_sub(WINDOW_BEFORE);
        let excerpt: String = text[line_start..line_end].chars().skip(skipped).take(WINDOW).map(printable).collect();
        let caret = before - skipped;
        Place {
            name: plain(&self.source.name, NAME_CHARS),
            kind: self.source.kind,
            line,
            column: before + 1,
            excerpt: excerpt.trim_end().to_owned(),
            caret: caret..caret + marked.min(WINDOW - caret),
        }
    }
}

/// Longest message, source name, and excerpt of a line, characters.
const MESSAGE_CHARS: usize = 600;
const NAME_CHARS: usize = 200;
const WINDOW: usize = 110;
const WINDOW_BEFORE: usize = 60;

fn floor_boundary(text: &str, index: usize) -> usize {
    let mut i = index.min(text.len());
    while !text.is_char_boundary(i) {
        i -= 1;
    }
    i
}

/// Strangers' text must not drive a terminal: control and direction characters become a replacement sign.
fn printable(c: char) -> char {
    match c {
        '\t' => ' ',
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    }
}

/// `text` in one line of at most `limit` printable characters.
pub(super) fn plain(text: &str, limit: usize) -> String {
    let mut chars = text.trim_end().chars().map(|c| if c == '\n' { ' ' } else { printable(c) });
    let mut out: String = chars.by_ref().take(limit).collect();
    if chars.next().is_some() {
        out.push_str("...");
    }
    out
}

/// A line of a source with the offending text marked.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Place {
    name: String,
    kind: SourceKind,
    line: usize,
    column: usize,
    excerpt: String,
    caret: Range<usize>,
}

/// Why there is no recipe: one sentence, and where one exists the place it is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecipeError {
    message: String,
    place: Option<Box<Place>>,
}

impl RecipeError {
    /// A mistake that has no place in a text, such as a file that cannot be read.
    pub(super) fn placeless(message: impl AsRef<str>) -> Self {
        Self { message: plain(message.as_ref(), MESSAGE_CHARS), place: None }
    }

    /// The sentence, without its place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Line and column, from 1, where there is a place.
    pub fn line_column(&self) -> Option<(usize, usize)> {
        self.place.as_ref().map(|p| (p.line, p.column))
    }
}

impl fmt::Display for RecipeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(p) = &self.place else { return f.write_str(&self.message) };
        match p.kind {
            SourceKind::File => write!(f, "{}:{}:{}: ", p.name, p.line, p.column)?,
            SourceKind::Argument => write!(f, "{}, column {}: ", p.name, p.column)?,
        }
        let number = p.line.to_string();
        let gutter = number.len();
        writeln!(f, "{}", self.message)?;
        writeln!(f, "{:gutter$} |", "")?;
        writeln!(f, "{number} | {}", p.excerpt)?;
        write!(f, "{:gutter$} | {:caret$}{}", "", "", "^".repeat(p.caret.len()), caret = p.caret.start)
    }
}

impl std::error::Error for RecipeError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_at(text: &str, span: Range<usize>) -> RecipeError {
        Origin::new(&Source::new("r.toml", text, SourceKind::File), span).error("wrong")
    }

    #[test]
    fn the_caret_stands_under_the_text() {
        let e = error_at("a = 1\nbc = 22\n", 11..13);
        assert_eq!(e.line_column(), Some((2, 6)));
        assert_eq!(e.to_string(), "r.toml:2:6: wrong\n  |\n2 | bc = 22\n  |      ^^");
    }

    #[test]
    fn columns_count_characters() {
        let e = error_at("ä = 'öö' # x", 5..11);
        assert_eq!(e.line_column(), Some((1, 5)));
        assert!(e.to_string().ends_with("\n  |     ^^^^"), "{e}");
    }

    #[test]
    fn spans_past_the_end_and_inside_characters_are_harmless() {
        for (start, end) in [(0, 0), (1, 2), (5, 900), (900, 901), (3, 2)] {
            let _ = error_at("äöü", Range { start, end }).to_string();
        }
        let _ = error_at("", 0..5).to_string();
    }

    #[test]
    fn long_lines_are_cut_and_control_characters_replaced() {
        let text = format!("{}\u{1b}[31m{}", "x".repeat(100_000), "y".repeat(100_000));
        let e = error_at(&text, 100_000..150_000);
        let shown = e.to_string();
        assert!(shown.len() < 700 && !shown.contains('\u{1b}'), "{shown}");
        assert_eq!(e.line_column(), Some((1, 100_001)));
    }
}
