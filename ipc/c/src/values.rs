//! Single values of options.

use crate::borrow::{array, texts};
use crate::handle::wrong;
use std::ffi::c_char;
use std::time::Duration;
use taut_ipc::planner::PlannerError;
use taut_ipc::wire::Mode;

/// What 0 and 1 mean.
pub(crate) fn flag(name: &str, flag: u8) -> Result<bool, PlannerError> {
    match flag {
        0 | 1 => Ok(flag == 1),
        _ => Err(wrong(format!(
            "options.{name} is {flag}; valid: 0, 1 (start from taut_options_default)"
        ))),
    }
}

/// The mode of a number.
pub(crate) fn mode(number: u32) -> Result<Mode, PlannerError> {
    Mode::try_from(number).map_err(|_| {
        let valid: Vec<String> = Mode::ALL
            .iter()
            .map(|(mode, _)| valid_mode(*mode))
            .collect();
        wrong(format!(
            "options.mode is {number}; valid: {}",
            valid.join(", ")
        ))
    })
}

fn valid_mode(mode: Mode) -> String {
    let name = mode.name().to_uppercase().replace('-', "_");
    format!("TAUT_MODE_{name} {}", u32::from(mode))
}

/// A length, or none where it is 0.
pub(crate) fn given(metres: f64) -> Option<f64> {
    (metres != 0.0).then_some(metres)
}

/// A time, or none where it is 0.
pub(crate) fn seconds(what: &str, seconds: f64) -> Result<Option<Duration>, PlannerError> {
    match seconds {
        0.0 => Ok(None),
        _ => duration(what, seconds).map(Some),
    }
}

/// Numbers, each with its name.
///
/// # Safety
/// NULL, or arrays of so many.
pub(crate) unsafe fn named(
    what: &str,
    names: *const *const c_char,
    numbers: *const f64,
    count: usize,
) -> Result<Vec<(String, f64)>, PlannerError> {
    // SAFETY: the caller's promise is the same.
    let names = unsafe { texts(what, names, count) }?;
    // SAFETY: the caller's promise is the same.
    let numbers = unsafe { array(what, numbers, count) }?;
    Ok(names
        .into_iter()
        .zip(numbers.iter().copied())
        .collect())
}

/// Seconds as a time; so many that nobody lives to see their end are a year.
pub(crate) fn duration(what: &str, seconds: f64) -> Result<Duration, PlannerError> {
    const YEAR: f64 = 365.0 * 86_400.0;
    if seconds.is_nan() || seconds < 0.0 {
        return Err(wrong(format!("{what} is {seconds} s; valid: 0 or more")));
    }
    Ok(Duration::from_secs_f64(seconds.min(YEAR)))
}
