//! `taut check --timed --against`: whether a trajectory stays in the corridor of an answer, without
//! robot and scene.

use std::f64::consts::TAU;
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
use taut::validation::{Certificate, Corridor, corridor};

use super::arguments::Arguments;
use super::timed::timed_points;
use crate::cli::error::CliError;
use crate::cli::format::{Format, print_line};
use crate::cli::report;
use taut_ipc::wire::Code;

/// What was found, as JSON has it.
#[derive(Default, Serialize)]
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
    let points = points_of(&trajectory, &result, &path)?;
    let curve = Curve::of_lines(result.variables.len(), &points)
        .map_err(|error| FileError::content(file, error.to_string()))?;
    let start = Instant::now();
    let mut stop = || deadline.is_some_and(|deadline| start.elapsed() >= deadline);
    let inside = stays_inside(&curve, &path, &corridor, &mut stop);
    let looked_at = LookedAt {
        file,
        floor_m: corridor.floor_m,
        points: points.len(),
        time: start.elapsed(),
    };
    tell(&looked_at, inside, arguments.format)
}

/// The points of a trajectory, in the columns and the turns of the answer's path.
fn points_of(
    trajectory: &Trajectory,
    result: &ResultFile,
    path: &path::Path,
) -> Result<Vec<Point>, FileError> {
    let named = |name: &String| Variable::within(name, f64::NEG_INFINITY, f64::INFINITY);
    let variables: Vec<Variable> = result.variables.iter().map(named).collect();
    let mut points = timed_points(trajectory, trajectory.ordered(&variables)?)?;
    shift_whole_turns(result, path, &mut points);
    Ok(points)
}

/// The path of an answer, whose numbers say how it moves, and its corridor, which the certificate
/// must bear out.
fn corridor_of(answer: &Path, result: &ResultFile) -> Result<(path::Path, Corridor), FileError> {
    let refuse = |text: String| FileError::content(answer, text);
    let file = result.corridor.as_ref().ok_or_else(|| {
        refuse(
            "the answer has no corridor; ask for it: taut shorten … --corridor -o RESULT.json"
                .to_owned(),
        )
    })?;
    check_coordinates(file, &result.variables).map_err(refuse)?;
    let path = path::Path::from_rows(result.variables.len(), result.path.concat())
        .ok_or_else(|| refuse("its path is empty".into()))?;
    check_certificate(result, file, &path).map_err(refuse)?;
    let reach = file
        .coordinates
        .iter()
        .map(|coordinate| coordinate.reach_m);
    let corridor = Corridor {
        floor_m: file.floor_m,
        reach: reach.collect(),
        slack_m: file.slack_m.clone(),
    };
    Ok((path, corridor))
}

/// Checks that the coordinates of a corridor are columns of a trajectory.
fn check_coordinates(file: &ResultCorridor, variables: &[String]) -> Result<(), String> {
    let mut coordinates = file.coordinates.iter();
    if let Some(rotation) = coordinates.find(|coordinate| coordinate.kind == "rotation") {
        return Err(format!(
            "{} is part of a quaternion, which no trajectory of joints moves",
            rotation.variable
        ));
    }
    let coordinates = file.coordinates.iter();
    match coordinates
        .map(|coordinate| &coordinate.variable)
        .eq(variables)
    {
        true => Ok(()),
        false => Err("the coordinates of its corridor are not the columns of its path".to_owned()),
    }
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
    let version = certificate.checker_version;
    if version < FIRST_BY_NUMBERS {
        return Err(format!(
            "its certificate is of checker version {version}, whose steps may mean other numbers; ask again"
        ));
    }
    match is_whole(certificate, path) && bears_out(certificate, file) {
        true => Ok(()),
        false => Err(
            "its certificate does not bear out its corridor: one of the two was changed".to_owned(),
        ),
    }
}

fn is_whole(certificate: &Certificate, path: &path::Path) -> bool {
    certificate.digest == Some(certificate.content()) && certificate.path_hash == path.hash()
}

fn bears_out(certificate: &Certificate, file: &ResultCorridor) -> bool {
    file.floor_m == certificate.floor_m() && file.slack_m == corridor::slack_m(certificate)
}

/// Takes whole turns from the columns of circles, so that the trajectory starts where the path
/// does.
fn shift_whole_turns(result: &ResultFile, path: &path::Path, points: &mut [Point]) {
    let Some(corridor) = &result.corridor else {
        return;
    };
    let coordinates = corridor.coordinates.iter().enumerate();
    for (column, _) in coordinates.filter(|(_, coordinate)| coordinate.kind == "circle") {
        shift_column(column, path.waypoint(0)[column], points);
    }
}

/// Takes whole turns from a column, so that it starts at most half a turn from `start`.
fn shift_column(column: usize, start: f64, points: &mut [Point]) {
    let Some(first) = points.first() else {
        return;
    };
    let turns = ((first.positions[column] - start) / TAU).round();
    for point in points {
        point.positions[column] -= turns * TAU;
    }
}

fn tell(looked_at: &LookedAt, inside: Inside, format: Format) -> Result<u8, CliError> {
    let code = match inside {
        Inside::Yes(_) => Code::Success,
        Inside::No { .. } => Code::Uncertified,
        Inside::Stopped => Code::TimedOut,
    };
    let text = match format {
        Format::Json => looked_at.json(&inside, code),
        Format::Table => looked_at.line(&inside, code),
    };
    print_line(&text)?;
    Ok(code.exit_code())
}

/// What was looked at, and for how long.
struct LookedAt<'a> {
    file: &'a Path,
    /// What the corridor keeps (m).
    floor_m: f64,
    /// Points of the trajectory.
    points: usize,
    time: Duration,
}

impl LookedAt<'_> {
    fn json(&self, inside: &Inside, code: Code) -> String {
        let name = self.file.file_stem().unwrap_or_default();
        let finding = Finding {
            name: &name.to_string_lossy(),
            timed: true,
            inside: code == Code::Success,
            code: code.into(),
            code_name: code.name(),
            floor_m: self.floor_m,
            time_s: self.time.as_secs_f64(),
            ..place_of(inside)
        };
        serde_json::to_string(&finding).expect("a finding holds only strings, booleans and numbers")
    }

    fn line(&self, inside: &Inside, code: Code) -> String {
        let took = report::time(self.time.as_secs_f64());
        match inside {
            Inside::Yes(used) => format!(
                "inside   every pair keeps {}, {:.0} % of the corridor used   {took}",
                report::length(self.floor_m),
                100.0 * used
            ),
            Inside::No {
                point,
                time_s,
                segment,
                excess_m,
            } => format!(
                "OUTSIDE at {time_s:.4} s, after point {} of {}: beyond the corridor of segment {} by {}; check it with the robot and the scene   {took}",
                point + 1,
                self.points,
                segment + 1,
                report::length(*excess_m)
            ),
            Inside::Stopped => format!("{}   the deadline passed   {took}", code.name()),
        }
    }
}

/// Where a trajectory leaves the corridor, or how much of it is used.
fn place_of<'a>(inside: &Inside) -> Finding<'a> {
    match *inside {
        Inside::Yes(used) => Finding {
            used: Some(used),
            ..Finding::default()
        },
        Inside::No {
            point,
            time_s,
            segment,
            excess_m,
        } => Finding {
            point: Some(point),
            at_s: Some(time_s),
            segment: Some(segment),
            excess_m: Some(excess_m),
            ..Finding::default()
        },
        Inside::Stopped => Finding::default(),
    }
}
