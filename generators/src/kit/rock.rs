//! Rock.
