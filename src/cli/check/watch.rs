//! `taut check --watch`: a path that the daemon checks again whenever its scene changes.

use std::io::Write;
use std::time::Duration;

use taut_ipc::ClientError;
use taut_ipc::planner::{Answers, Best, PlannerError, Request};
use taut_ipc::wire::Mode;

use super::arguments::Arguments;
use crate::cli::answer::told;
use crate::cli::answered::Answered;
use crate::cli::asked::Asked;
use crate::cli::error::{CliError, stdout};
use crate::cli::format::Format;
use crate::cli::load;
use crate::cli::place::Place;
use crate::cli::prepare::{self, Prepared};
use crate::cli::report;
use crate::cli::subject::Subject;
use crate::daemon::translate::AnswerError;

/// How often a wait looks up; it ends only with a verdict or the daemon.
const LOOK_UP: Duration = Duration::from_secs(1);

/// Prints the first verdict of a path and every other one, until there were so many or the scene is
/// gone.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let asked = arguments.asked()?;
    let prepared = prepared(arguments, &asked)?;
    let request = Request {
        watch: true,
        ..prepared.request(&asked)?
    };
    follow(arguments, &prepared, &request)
}

fn prepared(arguments: &Arguments, asked: &Asked) -> Result<Prepared, CliError> {
    let place = Place::open(&arguments.place)?;
    let mut reader = load::reader(&arguments.source);
    let held = &asked.request.held;
    let file = &arguments.files[0];
    let mut prepared = prepare::prepare(&place, &mut reader, file, &arguments.source, held)?;
    prepared.tell_what_is_asked(asked);
    Ok(prepared)
}

fn follow(arguments: &Arguments, prepared: &Prepared, request: &Request) -> Result<u8, CliError> {
    let mut answers = prepared
        .planner
        .ask(request, prepared.path.as_flat())?;
    let mut exit = 0;
    let mut shown = 0;
    while arguments
        .count
        .is_none_or(|count| shown < count)
    {
        let best = next(&mut answers)?;
        exit = show(arguments, prepared, request, &best)?;
        shown += 1;
        if best.is_final() {
            break;
        }
    }
    Ok(exit)
}

/// Waits for the next verdict.
fn next(answers: &mut Answers) -> Result<Best, CliError> {
    loop {
        match answers.next(LOOK_UP) {
            Err(PlannerError::Client(ClientError::Timeout(_))) => {}
            best => return Ok(best?.ok_or(ClientError::NoAnswer)?),
        }
    }
}

fn show(
    arguments: &Arguments,
    prepared: &Prepared,
    request: &Request,
    best: &Best,
) -> Result<u8, CliError> {
    let version = best.header().scene_version;
    match told(best, request, &prepared.robot, Duration::ZERO) {
        // The watch goes on: the world may be seen again.
        Err(AnswerError::Request(error)) if !best.is_final() => {
            say_refused(&error, version, arguments.format).map_err(stdout)?;
            Ok(error.code().exit_code())
        }
        answered => {
            let answered = answered?;
            print(&prepared.subject, &answered, version, arguments.format).map_err(stdout)?;
            Ok(answered.code.exit_code())
        }
    }
}

fn say_refused(error: &PlannerError, version: u64, format: Format) -> std::io::Result<()> {
    let code = error.code();
    let line = match format {
        Format::Json => serde_json::json!({
            "code": i32::from(code), "code_name": code.name(), "message": error.to_string(),
            "proved": false, "scene_version": version,
        })
        .to_string(),
        Format::Table => format!("scene v{version}   {error}"),
    };
    say(&line)
}

fn say(line: &str) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}")?;
    out.flush()
}

fn print(
    subject: &Subject,
    answered: &Answered,
    version: u64,
    format: Format,
) -> std::io::Result<()> {
    let line = match format {
        Format::Json => json(subject, answered, version)?,
        Format::Table => {
            report::warn(&report::told(subject, answered), "");
            format!("scene v{version}   {}", report::verdict(answered))
        }
    };
    say(&line)
}

fn json(subject: &Subject, answered: &Answered, version: u64) -> serde_json::Result<String> {
    let result = report::result(subject, Mode::Check, answered);
    let mut answer = serde_json::to_value(&result)?;
    answer["scene_version"] = version.into();
    Ok(answer.to_string())
}
