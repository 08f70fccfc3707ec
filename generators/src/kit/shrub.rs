//! Shrubs.
