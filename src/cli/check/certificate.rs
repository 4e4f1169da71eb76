//! `taut check --certificate`: verify a proof, of a path or with `--timed` of a trajectory, by the
//! reference checker, in this process.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use taut::collision::CollisionModel;
use taut::constraint::{ConstraintsFile, constraints};
use taut::files::{FileError, Kind, PathTable, Trajectory};
use taut::optimize::Mode;
use taut::path;
use taut::robot::configuration::turns_between;
use taut::validation::certificate::{CHECKER_VERSION, FIRST_BY_NUMBERS};
use taut::validation::reference::{self, Effort, Objection};
use taut::validation::timed::Point;
use taut::validation::{Certificate, LimitClaim, NamedRequirement};

use super::arguments::Arguments;
use super::timed::timed_points;
use crate::cli::error::CliError;
use crate::cli::format::{Format, print_line};
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

/// What a certificate is held against.
enum About {
    Path(path::Path),
    Trajectory(Vec<Point>),
}

/// What was found, as JSON has it. Distances are in metres, times in seconds.
#[derive(Serialize)]
struct Finding<'a> {
    name: &'a str,
    geometry: &'static str,
    verified: bool,
    code: i32,
    code_name: &'static str,
    reason: Option<&'a str>,
    checker_version: u32,
    verified_by: u32,
    segments: usize,
    clearance_m: Option<f64>,
    floor_m: f64,
    keeps: Vec<Claimed>,
    /// Of a trajectory: limits of velocity and acceleration.
    #[serde(skip_serializing_if = "<[LimitClaim]>::is_empty")]
    limits: &'a [LimitClaim],
    intervals: u64,
    distances: u64,
    time_s: f64,
}

/// What is claimed of one constraint along the whole path.
#[derive(Serialize)]
struct Claimed {
    #[serde(flatten)]
    requirement: NamedRequirement,
    /// What is left of its tolerance, as it is asked (in its unit).
    left: f64,
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
    let about = match arguments.timed {
        true => proof.trajectory(file, &loaded)?,
        false => proof.path(file, &loaded)?,
    };
    let result = match about {
        Ok(about) => proof.verify(&model, &about, &mut stop),
        Err(reason) => Err((Code::Uncertified, reason)),
    };
    let verdict = Verdict::of(result, start.elapsed());
    let text = match arguments.format {
        Format::Json => json(&loaded, &proof.certificate, &verdict),
        Format::Table => line(&loaded, &proof.certificate, &verdict),
    };
    print_line(&text)?;
    Ok(verdict.code.exit_code())
}

impl Proof {
    fn read(file: &Path) -> Result<Self, FileError> {
        let text = std::fs::read_to_string(file).map_err(|error| FileError::Unreadable {
            file: file.to_owned(),
            reason: error.to_string(),
        })?;
        let (certificate, has_path) =
            certificate_in(&text).map_err(|text| FileError::content(file, text))?;
        Ok(Self {
            file: file.to_owned(),
            certificate,
            has_path,
        })
    }

    /// What verifying takes, else the objection.
    fn verify(
        &self,
        model: &CollisionModel,
        about: &About,
        stop: &mut dyn FnMut() -> bool,
    ) -> Result<Effort, (Code, String)> {
        let bar = progress_bar(self.certificate.segments.len() as u64);
        bar.set_message("segments verified");
        let mut progress = |done: usize| bar.set_position(done as u64);
        let certificate = &self.certificate;
        let result = match about {
            About::Path(path) => reference::verify(model, path, certificate, stop, &mut progress),
            About::Trajectory(points) => {
                reference::verify_trajectory(model, points, certificate, stop, &mut progress)
            }
        };
        bar.finish_and_clear();
        result.map_err(|objection| (code(&objection), refusal(&objection, self)))
    }

    /// The path that the certificate is about: that of `file`, unless this is the answer to it,
    /// with a path of its own; all that either is asked to keep must be claimed. The inner error is a
    /// refusal.
    fn path(&self, file: &Path, loaded: &Loaded) -> Result<Result<About, String>, CliError> {
        if !self.has_path || Kind::of(file)? == Kind::BarePath {
            let claimed = self.check_claims(loaded, loaded.constraints.clone());
            return Ok(claimed.map(|()| About::Path(self.as_proved(loaded))));
        }
        let (answer, own) = PathTable::read(&self.file)?.into_path(loaded.robot.variables())?;
        let other_ends =
            "the answer's path has other ends than the problem's; give the problem it answers";
        if !self.has_the_ends(&answer, loaded) {
            return Ok(Err(other_ends.to_owned()));
        }
        let claimed = self.check_claims(loaded, loaded.constraints.clone().and(own));
        Ok(claimed.map(|()| About::Path(answer)))
    }

    /// The trajectory of `file`; all that it is asked to keep must be claimed. The inner error is a
    /// refusal.
    fn trajectory(&self, file: &Path, loaded: &Loaded) -> Result<Result<About, String>, CliError> {
        let trajectory = Trajectory::read(file)?;
        let points = timed_points(&trajectory, trajectory.for_robot(&loaded.robot)?)?;
        let claimed = self.check_claims(loaded, loaded.constraints.clone());
        Ok(claimed.map(|()| About::Trajectory(points)))
    }

    /// Refuses a certificate that leaves out what its path is asked to keep.
    fn check_claims(&self, loaded: &Loaded, asked: ConstraintsFile) -> Result<(), String> {
        let robot = &loaded.robot;
        let defaults = robot.held().iter();
        let held = self
            .certificate
            .held
            .clone()
            .unwrap_or_else(|| {
                defaults
                    .map(|variable| variable.default)
                    .collect()
            });
        if held.len() != robot.held().len() {
            return Ok(());
        }
        let asked = asked.started(robot, &loaded.scene, loaded.path.waypoint(0), &held);
        let asked = asked.map_err(|error| error.to_string())?;
        let made = constraints(&asked, robot, &loaded.scene).map_err(|error| error.to_string())?;
        if made.is_empty() {
            // Tolerances of half a turn and more ask for nothing.
            return Ok(());
        }
        let claims = self.certificate.constraints.as_ref();
        let claimed = claims.map(|claims| claims.asked.clone());
        match asked.first_beyond(&claimed.unwrap_or_default()) {
            None => Ok(()),
            Some(name) => Err(format!(
                "it claims nothing of the constraint {name:?}, which its path is asked to keep; ask for the path again with it"
            )),
        }
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
        let given = &loaded.path;
        let last = answer.waypoint(answer.len() - 1);
        self.is_end(answer.waypoint(0), given.waypoint(0), loaded)
            && self.is_end(last, given.waypoint(given.len() - 1), loaded)
    }

    fn is_end(&self, answer: &[f64], given: &[f64], loaded: &Loaded) -> bool {
        let mut columns = answer.iter().zip(given).enumerate();
        columns.all(|(q, (a, b))| match self.is_angle(q, loaded) {
            true => *a == b + turns_between(*b, *a) as f64 * TAU,
            false => a == b,
        })
    }

    /// Whether whole turns in a column are the same place.
    fn is_angle(&self, q: usize, loaded: &Loaded) -> bool {
        let mut circles = loaded.robot.space().circles();
        !self.certificate.unwrapped && circles.any(|circle| circle == q)
    }
}

/// An answer that may hold a certificate.
#[derive(Deserialize)]
struct Answer {
    mode: Option<String>,
    certificate: Option<Certificate>,
}

/// A certificate that stands alone or in an answer, and whether that has a path of its own.
fn certificate_in(text: &str) -> Result<(Certificate, bool), String> {
    let value: serde_json::Value = serde_json::from_str(text).map_err(no_certificate)?;
    if value.get("certificate").is_none() {
        let certificate = serde_json::from_value(value).map_err(no_certificate)?;
        return Ok((certificate, false));
    }
    let answer: Answer = serde_json::from_value(value).map_err(no_certificate)?;
    let has_path = answer
        .mode
        .is_some_and(|mode| mode != Mode::Check.name());
    let none = "the answer has no certificate: its path was not proved";
    Ok((answer.certificate.ok_or(none)?, has_path))
}

fn no_certificate(error: serde_json::Error) -> String {
    format!("not a certificate, nor an answer of `taut check` or `taut shorten` as JSON: {error}")
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

/// What came of a certificate.
struct Verdict {
    code: Code,
    /// Why it is refused.
    reason: Option<String>,
    effort: Effort,
    time: Duration,
}

impl Verdict {
    fn of(result: Result<Effort, (Code, String)>, time: Duration) -> Self {
        let (code, reason, effort) = match result {
            Ok(effort) => (Code::Success, None, effort),
            Err((code, reason)) => (code, Some(reason), Effort::default()),
        };
        Self {
            code,
            reason,
            effort,
            time,
        }
    }
}

fn json(loaded: &Loaded, certificate: &Certificate, verdict: &Verdict) -> String {
    let finding = Finding {
        name: &loaded.name,
        geometry: loaded.geometry_name(),
        verified: verdict.reason.is_none(),
        code: verdict.code.into(),
        code_name: verdict.code.name(),
        reason: verdict.reason.as_deref(),
        checker_version: certificate.checker_version,
        verified_by: CHECKER_VERSION,
        segments: certificate.segments.len(),
        clearance_m: certificate.clearance_m(),
        floor_m: certificate.floor_m(),
        keeps: claimed(loaded, certificate),
        limits: limits(certificate),
        intervals: verdict.effort.intervals,
        distances: verdict.effort.distances,
        time_s: verdict.time.as_secs_f64(),
    };
    serde_json::to_string(&finding).expect("a finding holds only strings, booleans and numbers")
}

fn line(loaded: &Loaded, certificate: &Certificate, verdict: &Verdict) -> String {
    let time = report::time(verdict.time.as_secs_f64());
    match &verdict.reason {
        Some(reason) => format!("{}   {reason}   {time}", verdict.code.name()),
        None => format!("verified   {}   {time}", claim(loaded, certificate)),
    }
}

fn claim(loaded: &Loaded, certificate: &Certificate) -> String {
    let clearance = report::clearance(certificate.clearance_m());
    let segments = certificate.segments.len();
    let plural = if segments == 1 { "" } else { "s" };
    let keeps = claimed(loaded, certificate).into_iter();
    let keeps = keeps.map(|Claimed { requirement, left }| {
        format!(
            "{requirement} {} {}",
            report::no_more(left),
            requirement.unit.name()
        )
    });
    let keeps = report::listed(", left: ", keeps);
    let limits = match limits(certificate).len() {
        0 => String::new(),
        1 => ", limits of 1 variable".to_owned(),
        count => format!(", limits of {count} variables"),
    };
    format!("{segments} segment{plural}, {clearance}{limits}{keeps}")
}

/// The limits that it claims a trajectory keeps.
fn limits(certificate: &Certificate) -> &[LimitClaim] {
    let claims = certificate.timed.as_ref();
    claims.map_or(&[], |claims| &claims.limits)
}

/// What it claims of each constraint that means something for this robot and scene.
fn claimed(loaded: &Loaded, certificate: &Certificate) -> Vec<Claimed> {
    let Some(claims) = &certificate.constraints else {
        return Vec::new();
    };
    let known = constraints(&claims.asked, &loaded.robot, &loaded.scene).unwrap_or_default();
    let known = known.iter().enumerate();
    known
        .map(|(index, constraint)| Claimed {
            requirement: NamedRequirement::constraint(constraint),
            left: claims.least(index),
        })
        .collect()
}
