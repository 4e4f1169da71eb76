//! One request about a file, answered.

use std::path::Path;
use std::time::{Duration, Instant};

use taut::files::Reader;
use taut::files::result::ResultCorridor;
use taut::optimize::Outcome;
use taut_ipc::ClientError;
use taut_ipc::control::RobotDescription;
use taut_ipc::planner::{Best, Request};
use taut_ipc::wire::ResponseHeader;

use super::answered::Answered;
use super::asked::Asked;
use super::error::CliError;
use super::place::Place;
use super::prepare::{self, Prepared};
use super::progress::Progress;
use super::source::Source;
use super::subject::Subject;
use crate::daemon::translate::{self, AnswerError};

/// Answers the request about a file. `watch` gets the length of each improvement and when it came.
/// Only an answer that is kept as a file says where robot and scene come from.
///
/// # Errors
/// A file that cannot be used, a request that is refused, a daemon that went away.
pub(super) fn answer(
    place: &Place,
    reader: &mut Reader,
    file: &Path,
    source: &Source,
    asked: &Asked,
    is_kept: bool,
    watch: &mut dyn FnMut(Duration, f64),
) -> Result<(Subject, Answered), CliError> {
    let progress = Progress::start(file);
    let mut prepared = prepare::prepare(place, reader, file, source, &asked.request.held)?;
    drop(progress);
    let request = prepared.request(asked)?;
    prepared.tell_what_is_asked(asked);
    let answered = run(place, &prepared, &request, watch)?;
    if is_kept {
        prepared.subject.source = asked.source(prepared.source(&request, &source.packages));
    }
    Ok((prepared.subject, answered))
}

fn run(
    place: &Place,
    prepared: &Prepared,
    request: &Request,
    watch: &mut dyn FnMut(Duration, f64),
) -> Result<Answered, CliError> {
    let name = &prepared.subject.name;
    let start = Instant::now();
    let mut lengths_over_time = Vec::new();
    let mut improved = |header: &ResponseHeader| {
        let time = start.elapsed();
        lengths_over_time.push((time.as_secs_f64(), header.length_after));
        watch(time, header.length_after);
    };
    let best = prepared
        .planner
        .answer(request, prepared.path.as_flat(), &mut improved)
        .map_err(|error| place.refusal(name, error))?;
    let answered = told(&best, request, &prepared.robot, start.elapsed());
    let answered = answered.map_err(|error| refused(place, name, error))?;
    Ok(Answered {
        request_id: place.known_id(best.header().request_id),
        lengths_over_time,
        ..answered
    })
}

/// What an answer tells, `time` after it was asked for.
///
/// # Errors
/// A refusal, or an answer that contradicts itself.
pub(super) fn told(
    best: &Best,
    request: &Request,
    robot: &RobotDescription,
    time: Duration,
) -> Result<Answered, AnswerError> {
    let view = best.view().map_err(AnswerError::Wire)?;
    let (outcome, code) = translate::outcome(&view, request, robot)?;
    Ok(Answered {
        corridor: corridor(&outcome, request, robot),
        times: translate::result_times(&view, robot)?,
        outcome,
        code,
        world_age_s: seen_s(view.header.world_age_ns),
        cpu_s: view.header.compute_ns as f64 * 1e-9,
        time_s: time.as_secs_f64(),
        request_id: Some(view.header.request_id),
        lengths_over_time: Vec::new(),
    })
}

fn seen_s(age_ns: u64) -> Option<f64> {
    (age_ns != 0).then_some(age_ns as f64 * 1e-9)
}

fn corridor(
    outcome: &Outcome,
    request: &Request,
    robot: &RobotDescription,
) -> Option<ResultCorridor> {
    let corridor = outcome.corridor.as_ref()?;
    Some(translate::result_corridor(
        corridor,
        robot,
        request.unwrapped,
    ))
}

fn refused(place: &Place, name: &str, error: AnswerError) -> CliError {
    match (place.daemon(), error) {
        (_, AnswerError::Wire(error)) => CliError::Client(ClientError::from(error)),
        (_, AnswerError::Request(error)) => place.refusal(name, error),
        (None, error) => CliError::Here {
            name: name.to_owned(),
            message: error.to_string(),
        },
        (Some(_), error) => error.into(),
    }
}
