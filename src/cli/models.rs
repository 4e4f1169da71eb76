//! `taut load-robot`, `load-scene`, `unload-…`, `list`, `describe`, `stop`: what the daemon keeps
//! loaded.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use taut::files::{self, Geometry, Packages, Reader, RobotFiles};
use taut_ipc::control::{
    ControlRequest, Listing, ModelState, RobotDescription, SceneSummary, SensedSummary,
    VariableDescription,
};
use taut_ipc::{DaemonState, Instance, daemon_state};

use super::error::{CliError, is_lost};
use super::format::{Format, print_line};
use super::instance::InstanceChoice;
use super::progress::Progress;
use super::quantity;
use super::report;
use super::source::folder_of;
use crate::daemon::translate;
use taut::warning::grouped;

/// How long `stop` waits for the daemon's end.
const STOP_PATIENCE: Duration = Duration::from_secs(30);

/// Load a robot into the daemon
///
/// Exit code: 0 loaded, 65 a bad file, 66 an unreadable one or a label that names another robot, 69
/// no daemon.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("source").required(true).args(["urdf", "problem"]))]
pub(super) struct LoadRobot {
    /// Its label
    label: String,
    /// Its URDF
    #[arg(long, value_name = "FILE")]
    urdf: Option<PathBuf>,
    /// Its SRDF
    #[arg(long, value_name = "FILE", requires = "urdf")]
    srdf: Option<PathBuf>,
    /// Problem file whose robot to take
    #[arg(long, value_name = "FILE")]
    problem: Option<PathBuf>,
    /// Take the problem's sphere model
    #[arg(long, requires = "problem")]
    spheres: bool,
    /// Folder of a package that the robot names as package://NAME/
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = quantity::package)]
    packages: Vec<(String, PathBuf)>,
    /// Take the label away from another robot
    #[arg(long)]
    replace: bool,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Load a scene into the daemon
///
/// Exit code: 0 loaded, 65 a bad file, 66 an unreadable one or a label that names another scene, 69
/// no daemon.
#[derive(clap::Args)]
pub(super) struct LoadScene {
    /// Its label
    label: String,
    /// Its file (JSON, YAML or MoveIt's .scene text), or a problem file
    file: PathBuf,
    /// Which of the problems in a file of VAMP's, by set and index
    #[arg(long, value_name = "SET:INDEX")]
    select: Option<String>,
    /// Take the label away from another scene; its version counts up
    #[arg(long)]
    replace: bool,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Forget a robot or scene of the daemon; running requests keep it
#[derive(clap::Args)]
pub(super) struct Unload {
    /// Its label
    label: String,
    #[command(flatten)]
    instance: InstanceChoice,
}

/// List what the daemon has loaded
#[derive(clap::Args)]
pub(super) struct List {
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Show the variables, limits and groups of a robot that the daemon has loaded
#[derive(clap::Args)]
pub(super) struct Describe {
    /// The robot's label
    robot: String,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Stop the daemon; what runs ends with the best path so far
#[derive(clap::Args)]
pub(super) struct Stop {
    #[command(flatten)]
    instance: InstanceChoice,
}

/// Loads a robot.
pub(super) fn load_robot(arguments: &LoadRobot) -> Result<u8, CliError> {
    let planner = arguments.instance.connect()?;
    let files = arguments.files()?;
    let progress = Progress::start(&files.urdf);
    let source = translate::robot_source(&files);
    let robot = planner.load_robot(&arguments.label, &source, arguments.replace)?;
    drop(progress);
    warn(&robot.warnings);
    print(arguments.format, &*robot, || {
        robot_line(&robot.label, robot.nq, robot.robot_hash)
    })
}

impl LoadRobot {
    /// The files that are named.
    fn files(&self) -> Result<RobotFiles, CliError> {
        let packages = quantity::packages(&self.packages);
        match (&self.urdf, &self.problem) {
            (Some(urdf), _) => Ok(RobotFiles {
                urdf: urdf.clone(),
                srdf: self
                    .srdf
                    .clone()
                    .or_else(|| files::srdf_of(urdf)),
                packages,
                ..RobotFiles::default()
            }),
            (None, Some(problem)) => {
                let mut reader = Reader::new(Packages::with_environment(packages));
                Ok(reader
                    .problem(problem, self.geometry())?
                    .robot_files)
            }
            (None, None) => Err(CliError::Usage("give --urdf or --problem".to_owned())),
        }
    }

    fn geometry(&self) -> Geometry {
        match self.spheres {
            true => Geometry::Spheres,
            false => Geometry::Given,
        }
    }
}

fn warn(warnings: &[String]) {
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
}

/// Loads a scene.
pub(super) fn load_scene(arguments: &LoadScene) -> Result<u8, CliError> {
    let planner = arguments.instance.connect()?;
    let file = &arguments.file;
    let json = files::selected_scene_text(file, arguments.select.as_deref())?;
    let folder = folder_of(file);
    let progress = Progress::start(file);
    let scene = planner.load_scene(
        &arguments.label,
        &json,
        folder.as_deref(),
        arguments.replace,
    );
    drop(progress);
    let scene = scene?;
    warn(&scene.warnings);
    print(arguments.format, &scene, || scene_line(&scene))
}

/// Forgets a robot.
pub(super) fn unload_robot(arguments: &Unload) -> Result<u8, CliError> {
    let planner = arguments.instance.connect()?;
    planner.unload_robot(&arguments.label)?;
    Ok(0)
}

/// Forgets a scene.
pub(super) fn unload_scene(arguments: &Unload) -> Result<u8, CliError> {
    let planner = arguments.instance.connect()?;
    planner.unload_scene(&arguments.label)?;
    Ok(0)
}

/// Lists what is loaded.
pub(super) fn list(arguments: &List) -> Result<u8, CliError> {
    let listing = arguments.instance.connect()?.list()?;
    print(arguments.format, &listing, || list_lines(&listing))
}

/// Describes a robot.
pub(super) fn describe(arguments: &Describe) -> Result<u8, CliError> {
    let robot = arguments
        .instance
        .connect()?
        .robot(&arguments.robot)?;
    print(arguments.format, &*robot, || description(&robot))
}

/// Stops the daemon and waits until it has gone.
pub(super) fn stop(arguments: &Stop) -> Result<u8, CliError> {
    let instance = arguments.instance.instance()?;
    let planner = arguments.instance.connect()?;
    let reply = planner.control_once(&ControlRequest::Shutdown);
    match reply.map_err(CliError::from) {
        // It may be gone before its reply is read.
        Err(error) if !is_lost(&error) => return Err(error),
        _ => {}
    }
    drop(planner);
    wait_for_end(&instance)?;
    taut_ipc::server::tidy(&instance);
    Ok(0)
}

fn wait_for_end(instance: &Instance) -> Result<(), CliError> {
    let end = Instant::now() + STOP_PATIENCE;
    while daemon_state(instance)? != DaemonState::Absent {
        if Instant::now() > end {
            let text =
                format!("the daemon has not ended within {STOP_PATIENCE:?}; end its process");
            return Err(CliError::Usage(text));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

pub(super) fn print<T: Serialize>(
    format: Format,
    value: &T,
    table: impl Fn() -> String,
) -> Result<u8, CliError> {
    let text = match format {
        Format::Json => json(value),
        Format::Table => table(),
    };
    if !text.is_empty() {
        print_line(&text)?;
    }
    Ok(0)
}

/// What a daemon answered, as JSON. Infinite limits become null, which JSON has.
pub(super) fn json<T: Serialize>(value: &T) -> String {
    serde_json::to_string(value).expect("control replies hold only plain values")
}

fn robot_line(label: &str, nq: u32, hash: u64) -> String {
    format!("robot {label}   {nq} variables   hash {hash:016x}")
}

pub(super) fn scene_line(scene: &SceneSummary) -> String {
    format!(
        "scene {} v{}   {} objects   hash {:016x}",
        scene.label, scene.version, scene.objects, scene.scene_hash
    )
}

fn list_lines(listing: &Listing) -> String {
    let robots = listing.robots.iter().map(|robot| {
        let line = robot_line(&robot.label, robot.nq, robot.robot_hash);
        (true, robot.label.as_str(), line, &[][..])
    });
    let scenes = listing.scenes.iter().map(|scene| {
        let line = scene_line(scene);
        (false, scene.label.as_str(), line, &scene.sensed[..])
    });
    let loaded: Vec<_> = robots.chain(scenes).collect();
    let lines = loaded
        .iter()
        .map(|(is_robot, label, line, sensed)| {
            let state = state_of(listing, *is_robot, label);
            let line = format!("{line}   {}", state.map_or_else(String::new, state_words));
            let sensed = sensed.iter().map(sensed_line);
            sensed.fold(line, |lines, line| lines + "\n  " + &line)
        });
    let is_loaded = |state: &&ModelState| {
        loaded
            .iter()
            .any(|(is_robot, label, ..)| state.is_robot == *is_robot && state.label == *label)
    };
    let coming = listing
        .models
        .iter()
        .filter(|state| !is_loaded(state));
    lines
        .chain(coming.map(coming_line))
        .collect::<Vec<_>>()
        .join("\n")
}

/// What the sensor of an object saw last.
fn sensed_line(sensed: &SensedSummary) -> String {
    let object = &sensed.object;
    let Some(last) = &sensed.last else {
        return format!("{object}   not seen yet: requests in the scene wait for its first frame");
    };
    let [points, on_robot, in_padding] =
        [last.points, last.on_robot, last.in_padding].map(|count| grouped(count as usize));
    let rate = match last.period_ns {
        0 => String::new(),
        period_ns => format!(", {:.1} frames a second", 1e9 / period_ns as f64),
    };
    format!(
        "{object}   seen {} ago{rate}   {points} points, {on_robot} on the robot left out, of these {in_padding} by padding",
        report::time(last.age_ns as f64 * 1e-9)
    )
}

fn state_of<'a>(listing: &'a Listing, is_robot: bool, label: &str) -> Option<&'a ModelState> {
    let mut states = listing.models.iter();
    states.find(|state| state.is_robot == is_robot && state.label == label)
}

fn state_words(state: &ModelState) -> String {
    let warm = match state.missing.as_str() {
        "" => "warm",
        missing => missing,
    };
    let triangles = grouped(state.triangles as usize);
    let megabytes = state.bytes as f64 * 1e-6;
    format!("{warm}   {triangles} triangles   {megabytes:.1} MB")
}

/// A robot or scene that is not there yet.
fn coming_line(state: &ModelState) -> String {
    let kind = if state.is_robot { "robot" } else { "scene" };
    format!("{kind} {}   {}", state.label, state.missing)
}

fn description(robot: &RobotDescription) -> String {
    let names = robot
        .variables
        .iter()
        .map(|variable| variable.name.len());
    let width = names.max().unwrap_or(0);
    let mut lines = vec![robot_line(&robot.label, robot.nq, robot.robot_hash)];
    for variable in &robot.variables {
        lines.push(format!("  {:<width$}  {}", variable.name, limits(variable)));
    }
    for held in &robot.held_variables {
        lines.push(format!("  {held:<width$}  held"));
    }
    lines.extend(groups(robot));
    for warning in &robot.warnings {
        lines.push(format!("  warning: {warning}"));
    }
    lines.join("\n")
}

fn limits(variable: &VariableDescription) -> String {
    match variable.continuous {
        true => "continuous".to_owned(),
        false => format!("{:.4} to {:.4}", variable.lower, variable.upper),
    }
}

/// A line for each group of joints.
fn groups(robot: &RobotDescription) -> impl Iterator<Item = String> {
    let groups = robot.groups.iter().enumerate();
    groups.map(|(index, group)| {
        let names = names(robot, &group.variables);
        format!("  group {index} {}: {}", group.name, names.join(", "))
    })
}

fn names<'a>(robot: &'a RobotDescription, variables: &[u32]) -> Vec<&'a str> {
    variables
        .iter()
        .map(|&variable| robot.variables[variable as usize].name.as_str())
        .collect()
}
