//! `taut check --watch`: a path that the daemon checks again whenever its scene changes.

use std::io::Write;
use std::path::Path;
use std::time::Duration;

use taut::files::Reader;
use taut::optimize::Mode;
use taut_ipc::ClientError;
use taut_ipc::wire::{RequestBody, RequestFlags};

use super::error::{CliError, stdout};
use super::layout::Layout;
use super::place::Place;
use super::report;
use super::request::{Asked, Source};
use super::run::Timed;
use super::{Format, remote};

/// How often a wait looks up; it ends only with a verdict or the daemon.
const LOOK_UP: Duration = Duration::from_secs(1);

/// Prints the first verdict of a path and every other one, until there were so many or the scene is
/// gone.
pub(super) fn run(
    place: &mut Place,
    reader: &mut Reader,
    file: &Path,
    source: &Source,
    asked: &Asked,
    count: Option<u64>,
    format: Format,
) -> Result<u8, CliError> {
    let Place::Daemon(client) = place else {
        return Err(CliError::Usage(
            "--watch needs a daemon; leave out --local".to_owned(),
        ));
    };
    let mut prepared = remote::prepare(client, reader, file, source, asked.choices.held())?;
    let layout = Layout::of_description(&prepared.robot);
    let settings = asked.settings(prepared.weights.as_ref(), &layout, prepared.path.len())?;
    prepared.subject.metric = asked.metric(prepared.weights.is_some());
    let mut request = remote::request(client, &prepared, &settings, None)?;
    request.header.flags |= RequestFlags::WATCH;
    let weights = settings
        .weights
        .as_deref()
        .unwrap_or(&prepared.robot.weights);
    let held_values = settings.held.as_deref().unwrap_or_default();
    let mut loan = request
        .with_body(RequestBody {
            weights,
            held_values,
            ..RequestBody::default()
        })
        .loan()?;
    loan.path_mut().copy_from_slice(prepared.path.as_flat());
    let mut pending = loan.send()?;
    let mut exit = 0;
    let mut told = 0;
    while count.is_none_or(|count| told < count) {
        let response = match pending.next(LOOK_UP) {
            Err(ClientError::Timeout(_)) => continue,
            response => response?.ok_or(ClientError::NoAnswer)?,
        };
        let timed = remote::timed(
            &response,
            &settings,
            &prepared.robot,
            weights,
            Duration::ZERO,
        )?;
        exit = timed.code.exit_code();
        print(
            &prepared.subject,
            &timed,
            response.header().scene_version,
            format,
        )
        .map_err(stdout)?;
        told += 1;
        if response.is_final() {
            break;
        }
    }
    Ok(exit)
}

fn print(
    subject: &report::Subject,
    timed: &Timed,
    version: u64,
    format: Format,
) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    match format {
        Format::Json => {
            let result = report::result(subject, Mode::Check, timed);
            let mut answer = serde_json::to_value(&result)?;
            answer["scene_version"] = version.into();
            writeln!(out, "{answer}")?;
        }
        Format::Table => {
            report::warn(&report::told(subject, timed), "");
            writeln!(out, "scene v{version}   {}", report::verdict(timed))?;
        }
    }
    out.flush()
}
