//! Labels against oracles that share only the scene and the camera with the tracer.
//!
//! The brute-force oracle looks at every triangle for every ray, in f64; the bin oracle looks at those whose projection
//! covers the pixel, and so can do whole scenes. Agreement is exact but for pixels whose segment passes within 1e-9 of its
//! length of an edge: those are counted. Planted faults show that the comparison can fail.

mod oracle {
    mod agreement;
    pub(crate) mod bins;
    pub(crate) mod brute;
    mod bundles;
    pub(crate) mod compare;
    mod consistency;
    pub(crate) mod double;
    mod faults;
    mod full;
    mod order;
    pub(crate) mod scenes;
    mod watertight;
}
mod support;
