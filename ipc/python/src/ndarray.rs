//! Paths as numpy arrays: read in place, shown in place.

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::errors;

/// Columns and numbers of a path.
pub fn path_of<'a>(array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<(usize, &'a [f64])> {
    let numbers = array.as_slice();
    let numbers =
        numbers.map_err(|_| errors::invalid("the path's array is not C-contiguous; copy it"))?;
    Ok((array.shape()[1], numbers))
}

/// What numpy needs to know of numbers that lie at `numbers`, read-only.
pub fn interface<'py>(
    py: Python<'py>,
    numbers: &[f64],
    shape: (usize, usize),
    row_stride: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let interface = PyDict::new(py);
    interface.set_item("version", 3)?;
    interface.set_item(
        "typestr",
        if cfg!(target_endian = "little") {
            "<f8"
        } else {
            ">f8"
        },
    )?;
    interface.set_item("shape", shape)?;
    interface.set_item("strides", (row_stride * size_of::<f64>(), size_of::<f64>()))?;
    interface.set_item("data", (numbers.as_ptr() as usize, true))?;
    Ok(interface)
}
