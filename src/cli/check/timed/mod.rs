//! `taut check --timed`: prove what a controller executes between the points of a trajectory, in
//! this process.

mod finding;
mod judge;
mod points;
mod table;

use std::path::Path;
use std::time::Instant;

use taut::files::result::texts;
use taut::files::{FileError, Reader, Trajectory};
use taut::timing::Limits;
use taut::validation::timed::Curve;
use taut::warning::{self, Warning};

pub(in crate::cli) use judge::{code_of_hit, held};
pub(super) use points::timed_points;

use super::arguments::Arguments;
use crate::cli::asked::Asked;
use crate::cli::error::CliError;
use crate::cli::format::{Format, print_line};
use crate::cli::load::{self, Loaded};
use crate::cli::motors::Motors;
use crate::cli::report;
use crate::cli::subject;
use finding::{Finding, found};
use judge::{Judged, Subject, Verdict, code, judge};

/// Checks the trajectories of every file.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let asked = arguments.asked()?;
    Ok(arguments.highest(|file| check(arguments, file, &asked, &mut reader)))
}

/// Checks the trajectory of a file.
///
/// # Errors
/// Files that cannot be used; a trajectory that is refused is no error but an exit code.
fn check(
    arguments: &Arguments,
    file: &Path,
    asked: &Asked,
    reader: &mut Reader,
) -> Result<u8, CliError> {
    let trajectory = Trajectory::read(file)?;
    let held = &asked.request.held;
    let loaded = load::load_holding(reader, file, &arguments.source, false, held)?;
    let points = timed_points(&trajectory, trajectory.for_robot(&loaded.robot)?)?;
    let curve = Curve::new(&loaded.robot, &points);
    let curve = curve.map_err(|error| FileError::content(file, error.to_string()))?;
    let constraints = loaded
        .constraints
        .clone()
        .and(asked.constraints.clone());
    let limits = limits(&arguments.motors, &loaded, &curve)?;
    let subject = Subject::new(
        &loaded,
        (&points, &curve),
        &asked.request,
        constraints,
        limits,
    )?;
    let start = Instant::now();
    let judged = judge(&subject, start);
    let time_s = start.elapsed().as_secs_f64();
    if let Verdict::Proved(proof) = &judged.verdict {
        arguments.write_certificate(Some(&proof.certificate))?;
    }
    let told = told(&loaded, &judged);
    let text = match arguments.format {
        Format::Json => json(&loaded, &curve, &judged, &told, time_s)?,
        Format::Table => {
            report::warn(&told, "");
            table::table(&curve, &judged, time_s)
        }
    };
    print_line(&text)?;
    Ok(code(&judged.verdict).0.exit_code())
}

/// The limits of velocity and acceleration that are asked for.
fn limits(motors: &Motors, loaded: &Loaded, curve: &Curve) -> Result<Option<Limits>, CliError> {
    if motors.limits.is_none() && motors.acceleration.is_none() {
        return Ok(None);
    }
    let moves = |column| curve.moves(column);
    motors.limits(&loaded.robot, moves).map(Some)
}

/// What a person should know beside the verdict.
fn told(loaded: &Loaded, judged: &Judged) -> Vec<Warning> {
    let of_files = subject::warnings(loaded);
    let all = of_files.iter().chain(&judged.warnings);
    warning::told(all.chain(&loaded.notes))
}

fn json(
    loaded: &Loaded,
    curve: &Curve,
    judged: &Judged,
    told: &[Warning],
    time_s: f64,
) -> Result<String, CliError> {
    let (code, reason) = code(&judged.verdict);
    let finding = Finding {
        name: &loaded.name,
        timed: true,
        code: code.into(),
        code_name: code.name(),
        points: curve.segments() + 1,
        duration_s: curve.total_s(),
        reason,
        pairs: judged.pairs,
        warnings: texts(told, |_| true),
        uncovered: texts(told, Warning::is_uncovered),
        time_s,
        ..found(&judged.verdict)
    };
    Ok(
        serde_json::to_string(&finding)
            .expect("a finding holds only strings, booleans and numbers"),
    )
}
