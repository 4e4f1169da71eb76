//! What a request may say, from keyword arguments.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;
use taut_ipc::planner::Request;
use taut_ipc::wire::Mode;

use super::errors;

/// Names of the modes.
pub const MODES: [(&str, Mode); 6] = [
    ("check", Mode::Check),
    ("gradient", Mode::Gradient),
    ("random-shortcut", Mode::RandomShortcut),
    ("partial-shortcut", Mode::PartialShortcut),
    ("contact", Mode::Contact),
    ("hybrid", Mode::Hybrid),
];

/// A request from the entries of a dictionary; the Python side has checked that it knows them all.
pub fn request(robot: &str, scene: Option<&str>, options: &Bound<'_, PyDict>) -> PyResult<Request> {
    let mut request = Request::new(robot, scene);
    let mut known = 0;
    let mut take = |name: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
        let value = options.get_item(name)?;
        known += usize::from(value.is_some());
        Ok(value.filter(|value| !value.is_none()))
    };
    if let Some(mode) = take("mode")? {
        let name: String = mode.extract()?;
        let found = MODES.iter().find(|(mode, _)| *mode == name);
        let valid = || MODES.map(|(name, _)| name).join(", ");
        request.mode = found
            .ok_or_else(|| errors::invalid(format!("no mode {name:?}; valid: {}", valid())))?
            .1;
    }
    if let Some(seconds) = take("deadline")? {
        let seconds: f64 = seconds.extract()?;
        let deadline = Duration::try_from_secs_f64(seconds)
            .ok()
            .filter(|deadline| !deadline.is_zero());
        let refuse = || {
            errors::invalid(format!(
                "a deadline of {seconds} s; valid: more than 0, such as 0.02"
            ))
        };
        request.deadline = Some(deadline.ok_or_else(refuse)?);
    }
    macro_rules! entries {
        ($( $name:literal => $field:ident, )*) => { $(
            if let Some(value) = take($name)? {
                request.$field = value.extract()?;
            }
        )* };
    }
    entries! {
        "scene_version" => scene_version,
        "columns" => columns,
        "held" => held,
        "budget" => work_budget,
        "seed" => seed,
        "clearance" => clearance_m,
        "strict" => strict,
        "unwrapped" => unwrapped,
        "keep_goal" => keep_goal,
        "contacts" => contacts,
        "watch" => watch,
        "metric" => metric,
        "weights" => joint_weights,
        "fixed" => fixed_waypoints,
        "group" => group,
        "priority" => priority,
    }
    if known != options.len() {
        return Err(errors::invalid(format!(
            "unknown options among {:?}",
            options.keys()
        )));
    }
    Ok(request)
}
