//! Errors as `taut._errors` has them.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use taut_ipc::planner::{Place, PlannerError};
use taut_ipc::wire::Code;

static MAKE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// The exception for a code.
pub fn raise(code: Code, message: &str) -> PyErr {
    Python::attach(|py| made(py, code, message, 0, None).unwrap_or_else(|error| error))
}

/// An argument that is none.
pub fn invalid(message: impl AsRef<str>) -> PyErr {
    raise(Code::MalformedRequest, message.as_ref())
}

/// The exception for a planner's error.
pub fn of(error: &PlannerError) -> PyErr {
    Python::attach(|py| {
        made(
            py,
            error.code(),
            &error.to_string(),
            error.retry_after_ms(),
            error.place(),
        )
        .unwrap_or_else(|error| error)
    })
}

fn made(
    py: Python<'_>,
    code: Code,
    message: &str,
    retry_after_ms: u32,
    place: Option<&Place>,
) -> PyResult<PyErr> {
    let make = MAKE.get_or_try_init(py, || {
        py.import("taut._errors")?
            .getattr("of")?
            .into_py_any(py)
    })?;
    let retry = (retry_after_ms > 0).then(|| f64::from(retry_after_ms) * 1e-3);
    let place = place.map(|place| dict(py, place)).transpose()?;
    let error = make
        .bind(py)
        .call1((i32::from(code), code.name(), message, retry, place))?;
    Ok(PyErr::from_value(error))
}

fn dict<'py>(py: Python<'py>, place: &Place) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("kind", place.kind.name())?;
    dict.set_item("names", &place.names)?;
    dict.set_item("segment", place.segment)?;
    dict.set_item("t", place.t)?;
    dict.set_item("amount", place.amount)?;
    dict.set_item("allowed", place.allowed)?;
    dict.set_item("unit", place.unit.name())?;
    dict.set_item(
        "points",
        (place.points[0].to_vec(), place.points[1].to_vec()),
    )?;
    dict.set_item("normal", place.normal.to_vec())?;
    Ok(dict)
}
