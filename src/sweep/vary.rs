//! `KEY=a:b:n` and `KEY=v1,v2`: a key and the values that it takes.

use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// A key of the recipe, and what it is set to, one after the other.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Vary {
    /// A path as `--set` takes it, such as `scene.desert.texture_contrast`.
    pub key: String,
    /// Its values as TOML, at least one.
    pub values: Vec<String>,
}

impl FromStr for Vary {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, values) = text
            .split_once('=')
            .filter(|(key, values)| !key.trim().is_empty() && !values.trim().is_empty())
            .ok_or("what is varied is KEY=FROM:TO:COUNT or KEY=VALUE,VALUE, such as camera.gsd_m=0.3:0.5:5")?;
        let values = match range(values) {
            Some(values) => values?,
            None => parts(values),
        };
        if values.iter().any(|v| v.trim().is_empty()) {
            return Err(format!("a value of `{}` is empty", key.trim().escape_default()));
        }
        Ok(Self { key: key.trim().to_owned(), values })
    }
}

/// `a:b:n` as n numbers from a to b, both included; none where the text is something else.
fn range(text: &str) -> Option<Result<Vec<String>, String>> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [from, to, count] = parts[..] else { return None };
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite());
    let (from, to) = (number(from)?, number(to)?);
    let Some(count) = count.parse::<u32>().ok().filter(|n| (2..=100_000).contains(n)) else {
        return Some(Err(format!("`{}` is no number of values: FROM:TO:COUNT has 2 or more", count.escape_default())));
    };
    let at = |i: u32| {
        let value = from + (to - from) * f64::from(i) / f64::from(count - 1);
        // Steps such as 0.1 + 0.2 are told as people write them.
        format!("{:?}", (value * 1e9).round() / 1e9)
    };
    Some(Ok((0..count).map(at).collect()))
}

/// What stands between commas that are in no bracket and no quotes.
fn parts(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let (mut depth, mut quote) = (0, None);
    for c in text.chars() {
        match c {
            '"' | '\'' if quote == Some(c) => quote = None,
            '"' | '\'' if quote.is_none() => quote = Some(c),
            '[' | '{' if quote.is_none() => depth += 1,
            ']' | '}' if quote.is_none() => depth -= 1,
            ',' if depth == 0 && quote.is_none() => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        parts.last_mut().expect("it begins with one").push(c);
    }
    parts.into_iter().map(|p| p.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists() {
        let values = |text: &str| text.parse::<Vary>().unwrap().values;
        assert_eq!(values("a.b=0:0.3:4"), ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(values("a=200:50:2"), ["200.0", "50.0"]);
        assert_eq!(values("a=x, y ,\"p,q\""), ["x", "y", "\"p,q\""]);
        assert_eq!(values("camera.size_px=[64, 64],[128,128]"), ["[64, 64]", "[128,128]"]);
        assert_eq!(values("light.sun={elevation_deg=30,azimuth_deg=9},x"), ["{elevation_deg=30,azimuth_deg=9}", "x"]);
        assert_eq!(values("light.sun.time=10:30"), ["10:30"]);
        for (bad, told) in [
            ("a", "KEY=FROM"),
            ("=1", "KEY=FROM"),
            ("a=", "KEY=FROM"),
            ("a=1,,2", "is empty"),
            ("a=0:1:1", "2 or more"),
        ] {
            let error = bad.parse::<Vary>().unwrap_err();
            assert!(error.contains(told), "{bad}: {error}");
        }
    }
}
