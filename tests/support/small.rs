//! Recipes of small datasets with every label.

/// What differs from one small recipe to another.
pub(crate) struct Recipe<'a> {
    pub(crate) gsd_m: f64,
    pub(crate) size_px: [u32; 2],
    /// Lines of `[acquisition]`.
    pub(crate) acquisition: &'a str,
    /// The sensor's preset.
    pub(crate) sensor: &'a str,
    /// A line for each `[[scene]]`; each has one pivot.
    pub(crate) scenes: &'a [&'a str],
}

/// The text of the recipe: cameras 1 km up, one sample a pixel, all labels.
pub(crate) fn recipe(of: &Recipe<'_>) -> String {
    let Recipe { gsd_m, size_px, acquisition, sensor, scenes } = of;
    let scenes = scenes.iter().map(|scene| format!("[[scene]]\n{scene}\npivots = 1")).collect::<Vec<_>>().join("\n");
    format!(
        r#"seed = 3
[camera]
altitude_m = 1000.0
gsd_m = {gsd_m:?}
size_px = {size_px:?}
datum = "pivot"
[acquisition]
{acquisition}
[sensor]
preset = "{sensor}"
samples_per_pixel = 1
[labels]
write = ["disparity_right", "class", "elevation", "instance", "normal", "shadow", "edge"]
{scenes}
"#
    )
}
