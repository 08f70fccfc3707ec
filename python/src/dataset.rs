//! Datasets on disk.

use crate::{DatasetError, arrays, background};
use pyo3::prelude::*;
use satseed::dataset::{Dataset as Opened, DiskStore, Layer, ReadError, Sample};
use std::path::PathBuf;
use std::sync::Arc;

/// A finished dataset in a folder.
#[pyclass(frozen, module = "satseed._native")]
pub(crate) struct Dataset {
    store: Arc<DiskStore>,
    records: String,
    root_hash: String,
}

#[pymethods]
#[allow(clippy::needless_pass_by_value)] // Arguments come out of Python as values.
impl Dataset {
    #[new]
    fn new(folder: PathBuf) -> PyResult<Self> {
        let store = DiskStore::open(&folder).map_err(|e| DatasetError::new_err(e.to_string()))?;
        let (records, root_hash) = {
            let opened = Opened::open(&store).map_err(|e| failed(&e))?;
            let lines: Vec<String> = opened.records().iter().map(satseed::dataset::SampleRecord::to_line).collect();
            (format!("[{}]", lines.join(",")), opened.root_hash().hex())
        };
        Ok(Self { store: Arc::new(store), records, root_hash })
    }

    /// All records as a JSON list.
    #[getter]
    fn records(&self) -> &str {
        &self.records
    }

    /// The root hash.
    #[getter]
    fn root_hash(&self) -> &str {
        &self.root_hash
    }

    /// Reads a sample's arrays: all, or those of the names given.
    fn read<'py>(&self, py: Python<'py>, id: String, names: Option<Vec<String>>) -> PyResult<arrays::Made<'py>> {
        let store = Arc::clone(&self.store);
        let read = background::run(py, move || read(&store, &id, names.as_deref()))?;
        arrays::sample(py, read.map_err(|e| failed(&e))?)
    }
}

fn read(store: &DiskStore, id: &str, names: Option<&[String]>) -> Result<Sample, ReadError> {
    let dataset = Opened::open(store)?;
    let record = dataset.record(id)?;
    let camera = dataset.camera(record)?;
    let mut planes = Vec::new();
    for (layer, view) in record.files.keys().filter_map(|key| Layer::from_key(key)) {
        if names.is_none_or(|names| names.contains(&layer.key(view))) {
            planes.push((layer, view, dataset.plane(record, &camera, layer, view)?));
        }
    }
    Ok(Sample { identity: record.identity.clone(), camera, planes })
}

fn failed(error: &ReadError) -> PyErr {
    DatasetError::new_err(error.to_string())
}
