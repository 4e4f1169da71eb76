//! `taut check --certificate`: verify a proof by the reference checker, in this process.

use std::f64::consts::TAU;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use taut::collision::CollisionModel;
use taut::files::{FileError, Kind, PathTable};
use taut::optimize::Mode;
use taut::path;
use taut::robot::configuration::turns_between;
use taut::validation::Certificate;
use taut::validation::certificate::{CHECKER_VERSION, FIRST_BY_NUMBERS};
use taut::validation::reference::{self, Effort, Objection};

use super::arguments::Arguments;
use crate::cli::error::{CliError, stdout};
use crate::cli::format::Format;
use crate::cli::load::{self, Loaded};
use crate::cli::progress::progress_bar;
use crate::cli::report;
use taut_ipc::wire::Code;

/// A file that holds a certificate, alone or with the answer that it came with.
struct Proof {
    file: PathBuf,
    certificate: Certificate,
    /// The answer holds a path of its own: it is no answer of `check`, which changes nothing.
    has_path: bool,
}

/// What was found, as JSON has it. Distances are in metres, times in seconds.
#[derive(Serialize)]
struct Finding<'a> {
    name: &'a str,
    geometry: &'static str,
    verified: bool,
    code: i32,
    code_name: &'static str,
    reason: Option<String>,
    checker_version: u32,
    verified_by: u32,
    segments: usize,
    clearance_m: Option<f64>,
    floor_m: f64,
    intervals: u64,
    distances: u64,
    time_s: f64,
}

/// Verifies the certificate in `proof` for the robot, scene and path of the file.
///
/// # Errors
/// Files that cannot be used; a certificate that is refused is no error but an exit code.
pub(super) fn run(arguments: &Arguments, proof: &Path) -> Result<u8, CliError> {
    let file = &arguments.files[0];
    let proof = Proof::read(proof)?;
    let mut reader = load::reader(&arguments.source);
    let loaded = load::load(&mut reader, file, &arguments.source, false)?;
    let model = loaded.model()?;
    let start = Instant::now();
    let deadline = arguments.asked()?.request.deadline;
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let result = match proof.path(file, &loaded)? {
        Ok(path) => proof.verify(&model, &path, &mut stop),
        Err(reason) => Err((Code::Uncertified, reason)),
    };
    let time = start.elapsed();
    tell(&loaded, &proof.certificate, result, time, arguments.format)
}

impl Proof {
    fn read(file: &Path) -> Result<Self, FileError> {
        #[derive(Deserialize)]
        struct Answer {
            mode: Option<String>,
            certificate: Option<Certificate>,
        }
        let text = std::fs::read_to_string(file).map_err(|error| FileError::Unreadable {
            file: file.to_owned(),
            reason: error.to_string(),
        })?;
        let refuse = |text: String| FileError::Content {
            file: file.to_owned(),
            text,
        };
        let expected = "not a certificate, nor an answer of `taut check` or `taut shorten` as JSON";
        let bad = |error: serde_json::Error| refuse(format!("{expected}: {error}"));
        let value: serde_json::Value = serde_json::from_str(&text).map_err(bad)?;
        if value.get("certificate").is_none() {
            let certificate = serde_json::from_value(value).map_err(bad)?;
            return Ok(Self {
                file: file.to_owned(),
                certificate,
                has_path: false,
            });
        }
        let Answer { mode, certificate } = serde_json::from_value(value).map_err(bad)?;
        let none = || refuse("the answer has no certificate: its path was not proved".to_owned());
        let has_path = mode.is_some_and(|mode| mode != Mode::Check.name());
        Ok(Self {
            file: file.to_owned(),
            certificate: certificate.ok_or_else(none)?,
            has_path,
        })
    }

    /// What verifying takes, else the objection.
    fn verify(
        &self,
        model: &CollisionModel,
        path: &path::Path,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<Effort, (Code, String)> {
        let bar = progress_bar(self.certificate.segments.len() as u64);
        bar.set_message("segments verified");
        let mut progress = |done: usize| bar.set_position(done as u64);
        let result = reference::verify(model, path, &self.certificate, stop, &mut progress);
        bar.finish_and_clear();
        result.map_err(|objection| (code(&objection), refusal(&objection, self)))
    }

    /// The path that the certificate is about: that of `file`, unless this is the answer to it,
    /// with a path of its own. The inner error is a refusal.
    fn path(&self, file: &Path, loaded: &Loaded) -> Result<Result<path::Path, String>, CliError> {
        if !self.has_path || Kind::of(file)? == Kind::BarePath {
            return Ok(Ok(self.as_proved(loaded)));
        }
        let answer = PathTable::read(&self.file)?.into_path(loaded.robot.variables())?;
        if !self.has_the_ends(&answer, loaded) {
            return Ok(Err(
                "the answer's path has other ends than the problem's; give the problem it answers"
                    .into(),
            ));
        }
        Ok(Ok(answer))
    }

    /// The given path as its certificate means it: angles that step by more than half a turn are
    /// written anew.
    fn as_proved(&self, loaded: &Loaded) -> path::Path {
        let mut path = loaded.path.clone();
        if self.certificate.checker_version >= FIRST_BY_NUMBERS && !self.certificate.unwrapped {
            loaded.robot.space().unroll(path.as_flat_mut());
        }
        path
    }

    /// Whether an answer starts and ends where the given path does: an angle may end whole turns
    /// away.
    fn has_the_ends(&self, answer: &path::Path, loaded: &Loaded) -> bool {
        let is_angle = |q: usize| {
            !self.certificate.unwrapped && loaded.robot.space().circles().any(|circle| circle == q)
        };
        let is_same = |(q, (a, b)): (usize, (&f64, &f64))| match is_angle(q) {
            true => *a == b + turns_between(*b, *a) as f64 * TAU,
            false => a == b,
        };
        [(0, 0), (answer.len() - 1, loaded.path.len() - 1)]
            .into_iter()
            .all(|(end, given)| {
                answer
                    .waypoint(end)
                    .iter()
                    .zip(loaded.path.waypoint(given))
                    .enumerate()
                    .all(is_same)
            })
    }
}

fn code(objection: &Objection) -> Code {
    match objection {
        Objection::Stopped => Code::TimedOut,
        _ => Code::Uncertified,
    }
}

/// The objection, with what is to be done about it.
fn refusal(objection: &Objection, proof: &Proof) -> String {
    match objection {
        Objection::Other { kind: "robot", .. } => {
            format!("{objection}, with the --geometry, --srdf and columns of its proof")
        }
        Objection::Other { kind: "path", .. } if !proof.has_path => {
            format!(
                "{objection}; the certificate of a shortened path comes with the answer that holds it"
            )
        }
        other => other.to_string(),
    }
}

fn tell(
    loaded: &Loaded,
    certificate: &Certificate,
    result: Result<Effort, (Code, String)>,
    time: Duration,
    format: Format,
) -> Result<u8, CliError> {
    let (code, reason, effort) = match result {
        Ok(effort) => (Code::Success, None, effort),
        Err((code, reason)) => (code, Some(reason), Effort::default()),
    };
    let mut out = std::io::stdout().lock();
    match format {
        Format::Json => {
            let finding = Finding {
                name: &loaded.name,
                geometry: loaded.geometry_name(),
                verified: reason.is_none(),
                code: code.into(),
                code_name: code.name(),
                reason,
                checker_version: certificate.checker_version,
                verified_by: CHECKER_VERSION,
                segments: certificate.segments.len(),
                clearance_m: certificate.clearance_m(),
                floor_m: certificate.floor_m(),
                intervals: effort.intervals,
                distances: effort.distances,
                time_s: time.as_secs_f64(),
            };
            let text = serde_json::to_string(&finding)
                .expect("a finding holds only strings, booleans and numbers");
            writeln!(out, "{text}")
        }
        Format::Table => {
            let time = report::time(time.as_secs_f64());
            match reason {
                None => {
                    let clearance = report::clearance(certificate.clearance_m());
                    let segments = certificate.segments.len();
                    let plural = if segments == 1 { "" } else { "s" };
                    writeln!(
                        out,
                        "verified   {segments} segment{plural}, {clearance}   {time}"
                    )
                }
                Some(reason) => writeln!(out, "{}   {reason}   {time}", code.name()),
            }
        }
    }
    .map_err(stdout)?;
    Ok(code.exit_code())
}
