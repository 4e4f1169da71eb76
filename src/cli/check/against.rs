//! `taut check --timed --against`: whether a trajectory stays in the corridor of an answer, without
//! robot and scene.

use std::f64::consts::TAU;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use serde::Serialize;
use taut::files::result::ResultCorridor;
use taut::files::{FileError, ResultFile, Trajectory};
use taut::path;
use taut::robot::Variable;
use taut::validation::certificate::FIRST_BY_NUMBERS;
use taut::validation::timed::inside::{Inside, stays_inside};
use taut::validation::timed::{Curve, Point};
use taut::validation::{Corridor, corridor};

use super::arguments::Arguments;
use super::timed::timed_points;
use crate::cli::error::{CliError, stdout};
use crate::cli::format::Format;
use crate::cli::report;
use taut_ipc::wire::Code;

/// What was found, as JSON has it.
#[derive(Serialize)]
struct Finding<'a> {
    name: &'a str,
    timed: bool,
    inside: bool,
    code: i32,
    code_name: &'static str,
    floor_m: f64,
    /// The largest part of the slack that is used anywhere.
    used: Option<f64>,
    point: Option<usize>,
    at_s: Option<f64>,
    /// Segment of the answer's path.
    segment: Option<usize>,
    excess_m: Option<f64>,
    time_s: f64,
}

/// Checks the trajectory of a file against the corridor of an answer.
///
/// # Errors
/// Files that cannot be used; a trajectory that leaves the corridor is no error but an exit code.
pub(super) fn run(arguments: &Arguments, file: &Path, answer: &Path) -> Result<u8, CliError> {
    let deadline = arguments.asked()?.request.deadline;
    let trajectory = Trajectory::read(file)?;
    let result = ResultFile::read(answer)?;
    let (path, corridor) = corridor_of(answer, &result)?;
    let named = |name: &String| Variable::within(name, f64::NEG_INFINITY, f64::INFINITY);
    let variables: Vec<Variable> = result.variables.iter().map(named).collect();
    let mut points = timed_points(&trajectory, trajectory.ordered(&variables)?)?;
    shift_whole_turns(&result, &path, &mut points);
    let refuse = |error: taut::validation::timed::CurveError| FileError::Content {
        file: file.to_owned(),
        text: error.to_string(),
    };
    let curve = Curve::of_lines(variables.len(), &points).map_err(refuse)?;
    let start = Instant::now();
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let inside = stays_inside(&curve, &path, &corridor, &mut stop);
    tell(
        file,
        &corridor,
        points.len(),
        inside,
        start.elapsed(),
        arguments.format,
    )
}

/// The path of an answer, whose numbers say how it moves, and its corridor, which the certificate
/// must bear out.
fn corridor_of(answer: &Path, result: &ResultFile) -> Result<(path::Path, Corridor), FileError> {
    let refuse = |text: String| FileError::Content {
        file: answer.to_owned(),
        text,
    };
    let none = "the answer has no corridor; ask for it: taut shorten … --corridor -o RESULT.json";
    let file = result
        .corridor
        .as_ref()
        .ok_or_else(|| refuse(none.to_owned()))?;
    if let Some(rotation) = file
        .coordinates
        .iter()
        .find(|coordinate| coordinate.kind == "rotation")
    {
        let text = format!(
            "{} is part of a quaternion, which no trajectory of joints moves",
            rotation.variable
        );
        return Err(refuse(text));
    }
    let columns = file
        .coordinates
        .iter()
        .map(|coordinate| &coordinate.variable);
    if !columns.eq(&result.variables) {
        return Err(refuse(
            "the coordinates of its corridor are not the columns of its path".to_owned(),
        ));
    }
    let rows = result.path.concat();
    let path = path::Path::from_rows(result.variables.len(), rows)
        .ok_or_else(|| refuse("its path is empty".into()))?;
    check_certificate(result, file, &path).map_err(refuse)?;
    let reach = file
        .coordinates
        .iter()
        .map(|coordinate| coordinate.reach_m)
        .collect();
    let corridor = Corridor {
        floor_m: file.floor_m,
        reach,
        slack_m: file.slack_m.clone(),
    };
    Ok((path, corridor))
}

/// A corridor is as good as the certificate that it was made of.
fn check_certificate(
    result: &ResultFile,
    file: &ResultCorridor,
    path: &path::Path,
) -> Result<(), String> {
    let certificate = result
        .certificate
        .as_ref()
        .ok_or("it has a corridor, but no certificate")?;
    if certificate.checker_version < FIRST_BY_NUMBERS {
        let version = certificate.checker_version;
        return Err(format!(
            "its certificate is of checker version {version}, whose steps may mean other numbers; ask again"
        ));
    }
    let is_whole =
        certificate.digest == Some(certificate.content()) && certificate.path_hash == path.hash();
    let is_same =
        file.floor_m == certificate.floor_m() && file.slack_m == corridor::slack_m(certificate);
    match is_whole && is_same {
        true => Ok(()),
        false => Err(
            "its certificate does not bear out its corridor: one of the two was changed".to_owned(),
        ),
    }
}

/// Takes whole turns from the columns of circles, so that the trajectory starts where the path
/// does.
fn shift_whole_turns(result: &ResultFile, path: &path::Path, points: &mut [Point]) {
    let Some(corridor) = &result.corridor else {
        return;
    };
    let Some(first) = points.first().map(|point| point.positions.clone()) else {
        return;
    };
    for (column, coordinate) in corridor.coordinates.iter().enumerate() {
        if coordinate.kind == "circle" {
            let turns = ((first[column] - path.waypoint(0)[column]) / TAU).round();
            points
                .iter_mut()
                .for_each(|point| point.positions[column] -= turns * TAU);
        }
    }
}

fn tell(
    file: &Path,
    corridor: &Corridor,
    points: usize,
    inside: Inside,
    time: Duration,
    format: Format,
) -> Result<u8, CliError> {
    let code = match inside {
        Inside::Yes(_) => Code::Success,
        Inside::No { .. } => Code::Uncertified,
        Inside::Stopped => Code::TimedOut,
    };
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let took = report::time(time.as_secs_f64());
    let text = match format {
        Format::Json => {
            let mut finding = Finding {
                name: &name,
                timed: true,
                inside: code == Code::Success,
                code: code.into(),
                code_name: code.name(),
                floor_m: corridor.floor_m,
                used: None,
                point: None,
                at_s: None,
                segment: None,
                excess_m: None,
                time_s: time.as_secs_f64(),
            };
            match inside {
                Inside::Yes(used) => finding.used = Some(used),
                Inside::No {
                    point,
                    time_s,
                    segment,
                    excess_m,
                } => {
                    finding.point = Some(point);
                    finding.at_s = Some(time_s);
                    finding.segment = Some(segment);
                    finding.excess_m = Some(excess_m);
                }
                Inside::Stopped => {}
            }
            serde_json::to_string(&finding)
                .expect("a finding holds only strings, booleans and numbers")
        }
        Format::Table => match inside {
            Inside::Yes(used) => {
                let floor = report::length(corridor.floor_m);
                format!(
                    "inside   every pair keeps {floor}, {:.0} % of the corridor used   {took}",
                    100.0 * used
                )
            }
            Inside::No {
                point,
                time_s,
                segment,
                excess_m,
            } => {
                let excess = report::length(excess_m);
                let point = point + 1;
                let segment = segment + 1;
                format!(
                    "OUTSIDE at {time_s:.4} s, after point {point} of {points}: beyond the corridor of segment {segment} by {excess}; check it with the robot and the scene   {took}"
                )
            }
            Inside::Stopped => format!("{}   the deadline passed   {took}", code.name()),
        },
    };
    writeln!(std::io::stdout().lock(), "{text}").map_err(stdout)?;
    Ok(code.exit_code())
}
