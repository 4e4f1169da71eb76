//! What a request may say, from keyword arguments.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;
use taut_ipc::planner::Request;
use taut_ipc::planner::options::{Kind, Row, TABLE, Value};
use taut_ipc::wire::Mode;

use super::errors;

/// A request from a dictionary of options by the names of their fields; the Python side has checked
/// that it knows them all.
pub fn request(robot: &str, scene: Option<&str>, options: &Bound<'_, PyDict>) -> PyResult<Request> {
    let mut request = Request::new(robot, scene);
    let mut known = 0;
    for row in TABLE {
        let given = options.get_item(row.field)?;
        known += usize::from(given.is_some());
        let Some(given) = given.filter(|given| !given.is_none()) else {
            continue;
        };
        row.set(&mut request, value(row, &given)?)
            .map_err(|error| errors::of(&error))?;
    }
    if known != options.len() {
        return Err(errors::invalid(format!(
            "unknown options among {:?}",
            options.keys()
        )));
    }
    Ok(request)
}

fn value(row: &Row, given: &Bound<'_, PyAny>) -> PyResult<Value> {
    Ok(match row.kind {
        Kind::Flag => Value::Flag(given.extract()?),
        Kind::Count(_) => Value::Count(given.extract()?),
        Kind::Metres => Value::Metres(given.extract()?),
        Kind::Seconds => Value::Seconds(seconds(row, given.extract()?)?),
        Kind::Mode => Value::Mode(mode(&given.extract::<String>()?)?),
        Kind::Name => Value::Name(given.extract()?),
        Kind::Text => Value::Text(given.extract()?),
        Kind::Names => Value::Names(given.extract()?),
        Kind::Named => Value::Named(given.extract()?),
        Kind::Numbers => Value::Numbers(given.extract()?),
        Kind::Indices => Value::Indices(given.extract()?),
    })
}

fn seconds(row: &Row, seconds: f64) -> PyResult<Duration> {
    let time = Duration::try_from_secs_f64(seconds)
        .ok()
        .filter(|time| !time.is_zero());
    time.ok_or_else(|| {
        errors::invalid(format!(
            "a {} of {seconds} s; valid: more than 0, such as 0.02",
            row.field
        ))
    })
}

fn mode(name: &str) -> PyResult<Mode> {
    Mode::named(name).ok_or_else(|| {
        let valid: Vec<&str> = Mode::ALL
            .iter()
            .map(|(mode, _)| mode.name())
            .collect();
        errors::invalid(format!("no mode {name:?}; valid: {}", valid.join(", ")))
    })
}
