//! A sample as Python sees it: arrays by name, facts as JSON.

use numpy::{IntoPyArray as _, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use satseed::dataset::Sample;
use satseed::dataset::formats::{Pixels, Plane};

/// Identity and cameras as JSON, arrays by their names in a dataset's records.
pub(crate) type Made<'py> = (String, Bound<'py, PyDict>);

/// Hands a sample over; no array is copied.
pub(crate) fn sample(py: Python<'_>, sample: Sample) -> PyResult<Made<'_>> {
    // As text, not as a `Value`: that would turn f32 into f64, whose digits differ from the files'.
    let text = |part: Result<String, serde_json::Error>| part.map_err(|e| crate::GenerateError::new_err(e.to_string()));
    let identity = text(serde_json::to_string(&sample.identity))?;
    let camera = text(serde_json::to_string(&sample.camera))?;
    let facts = format!("{{\"identity\":{identity},\"camera\":{camera}}}");
    let arrays = PyDict::new(py);
    for (layer, view, plane) in sample.planes {
        arrays.set_item(layer.key(view), array(py, plane)?)?;
    }
    Ok((facts, arrays))
}

/// (rows, columns), or (rows, columns, bands) where a pixel has several values.
fn array(py: Python<'_>, plane: Plane) -> PyResult<Bound<'_, PyAny>> {
    let (h, w) = (plane.height as usize, plane.width as usize);
    match plane.pixels {
        Pixels::Gray(v) => shaped(py, v, [h, w], 1),
        Pixels::Rgb(v) => shaped(py, v, [h, w], 3),
        Pixels::Bytes4(v) => shaped(py, v, [h, w], 4),
        Pixels::Float(v) => shaped(py, v, [h, w], 1),
        Pixels::Id(v) => shaped(py, v, [h, w], 1),
        Pixels::Vector(v) => shaped(py, v, [h, w], 3),
        Pixels::Counts(n, v) => shaped(py, v, [h, w], n.into()),
        Pixels::Radiance(n, v) | Pixels::SceneLinear(n, v) => shaped(py, v, [h, w], n.into()),
    }
}

fn shaped<T: numpy::Element>(
    py: Python<'_>,
    values: Vec<T>,
    shape: [usize; 2],
    bands: usize,
) -> PyResult<Bound<'_, PyAny>> {
    let flat = values.into_pyarray(py);
    Ok(if bands == 1 { flat.reshape(shape)?.into_any() } else { flat.reshape([shape[0], shape[1], bands])?.into_any() })
}

/// Hands arrays of a size over as samples do, with the addresses that their values had before: for the test that nothing is
/// copied.
#[pyfunction]
pub(crate) fn _hand_over(py: Python<'_>, height: u32, width: u32) -> PyResult<Vec<(usize, Bound<'_, PyAny>)>> {
    let pixels = height as usize * width as usize;
    let (image, map) = (vec![0_u8; 3 * pixels], vec![0_f32; pixels]);
    let addresses = [image.as_ptr() as usize, map.as_ptr() as usize];
    let handed = [Pixels::Rgb(image), Pixels::Float(map)].map(|pixels| array(py, Plane { width, height, pixels }));
    addresses.into_iter().zip(handed).map(|(address, array)| Ok((address, array?))).collect()
}
