//! What is asked for: the project's problems.

use std::path::PathBuf;

use serde_json::Value;
use taut_ipc::wire::Mode;

use crate::error::Error;
use crate::orders::Job;
use crate::programs::project;

/// Problems of `config/`; daemons of the lab have their robots and scenes under these labels.
pub(crate) const PROBLEMS: [&str; 4] = ["arm_shelf", "corner", "rooms", "slalom"];
/// Work of a request that takes some milliseconds.
const BUDGET: u64 = 6_000;
/// The seed that stays at its first improvement until told to stop, where the configuration allows it.
const HANG_SEED: u64 = 0x4a46_4a46_4a46_4a46;

/// The file of a problem.
pub(crate) fn file(name: &str) -> PathBuf {
    project().join(format!("config/problems/{name}.json"))
}

/// A request for each problem, with fixed work, so that equal ones have equal answers.
pub(crate) fn jobs() -> Result<Vec<Job>, Error> {
    PROBLEMS.iter().map(|name| job(name)).collect()
}

/// The request for a problem.
pub(crate) fn job(name: &str) -> Result<Job, Error> {
    Ok(Job {
        name: name.to_owned(),
        robot: name.to_owned(),
        scene: Some(name.to_owned()),
        path: path(name)?,
        budget: BUDGET,
        seed: 7,
        ..Job::default()
    })
}

/// A request that goes on until it is told to stop.
pub(crate) fn endless() -> Result<Job, Error> {
    Ok(Job {
        name: "endless".to_owned(),
        seed: HANG_SEED,
        budget: 0,
        ..job("rooms")?
    })
}

/// The request for a problem whose path is cut into so many parts a segment.
pub(crate) fn cut(name: &str, parts: usize) -> Result<Job, Error> {
    let whole = job(name)?;
    let columns = match name {
        "rooms" => 2,
        _ => 3,
    };
    let rows: Vec<&[f64]> = whole.path.chunks(columns).collect();
    let between = |pair: &[&[f64]], part: usize| -> Vec<f64> {
        let share = part as f64 / parts as f64;
        let ends = pair[0].iter().zip(pair[1]);
        ends.map(|(from, to)| from + share * (to - from))
            .collect()
    };
    let mut path: Vec<f64> = rows
        .windows(2)
        .flat_map(|pair| {
            (0..parts)
                .flat_map(|part| between(pair, part))
                .collect::<Vec<_>>()
        })
        .collect();
    path.extend(rows.last().copied().unwrap_or_default());
    Ok(Job { path, ..whole })
}

/// The same with so much work that improvements come before the answer.
pub(crate) fn improved(name: &str, parts: usize) -> Result<Job, Error> {
    Ok(Job {
        budget: 20 * BUDGET,
        ..cut(name, parts)?
    })
}

/// A request whose path has so many bytes, which is checked and comes back: a disc that goes to and
/// fro where nothing is.
pub(crate) fn sized(bytes: usize) -> Job {
    let waypoints = bytes / 16;
    let row = |index: usize| [0.001 * (index % 2) as f64, 0.0];
    Job {
        name: format!("{bytes} B"),
        robot: "rooms".to_owned(),
        scene: None,
        path: (0..waypoints).flat_map(row).collect(),
        mode: Mode::Check.name().to_owned(),
        ..Job::default()
    }
}

fn path(name: &str) -> Result<Vec<f64>, Error> {
    let unreadable = |reason: String| Error::Process {
        what: file(name).display().to_string(),
        reason,
    };
    let text =
        std::fs::read_to_string(file(name)).map_err(|error| unreadable(error.to_string()))?;
    let problem: Value =
        serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
    let rows = problem["path"].as_array();
    let rows = rows.ok_or_else(|| unreadable("no path".to_owned()))?;
    let numbers = rows
        .iter()
        .flat_map(|row| row.as_array().into_iter().flatten());
    Ok(numbers.filter_map(Value::as_f64).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_has_a_path() {
        let jobs = jobs().unwrap();
        assert_eq!(jobs.len(), PROBLEMS.len());
        assert!(jobs.iter().all(|job| job.path.len() > 8));
        assert_eq!(sized(4096).path.len() * 8, 4096);
    }
}
