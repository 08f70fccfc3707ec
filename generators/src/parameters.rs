//! What is said of a parameter out of its range.

use core::ops::RangeInclusive;

/// A parameter outside its documented range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` is {found}, but must lie in {low} to {high}")]
pub struct ParameterError {
    /// The parameter's key.
    pub key: &'static str,
    /// What was given.
    pub found: f64,
    /// Smallest legal value.
    pub low: f64,
    /// Largest legal value.
    pub high: f64,
}

/// Refuses a value outside `range`, and NaN.
pub fn check_range(key: &'static str, found: f64, range: RangeInclusive<f64>) -> Result<(), ParameterError> {
    if range.contains(&found) {
        Ok(())
    } else {
        Err(ParameterError { key, found, low: *range.start(), high: *range.end() })
    }
}
