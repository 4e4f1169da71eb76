//! One run by the daemon.

use std::path::{Path as FilePath, PathBuf};
use std::time::{Duration, Instant};

use taut::files::result::{ResultSubject, RobotSource, SceneSource, rows};
use taut::files::{self, FileError, PathTable, Reader, RobotFiles};
use taut::optimize::{RequestError, Settings};
use taut::path::Path;
use taut::robot::Variable;
use taut::warning::Warning;
use taut_ipc::client::RequestBuilder;
use taut_ipc::control::{
    ControlReply, ControlRequest, Listing, RobotDescription, SceneSummary, VariableDescription,
};
use taut_ipc::planner::{Columns, PlannerError};
use taut_ipc::wire::{Code, RequestBody};
use taut_ipc::{Client, ClientError, Response, deadline_after};

use super::connect::{RECOVERY, control, unexpected};
use super::error::CliError;
use super::layout::{self, Layout};
use super::load::{self, Loaded};
use super::report::Subject;
use super::request::Source;
use super::run::Timed;
use crate::daemon::translate;

/// A path, and a robot and a scene that the daemon has loaded.
pub(super) struct Prepared {
    /// What the report says about them.
    pub subject: Subject,
    /// The robot.
    pub robot: RobotDescription,
    /// The scene.
    pub scene: SceneSummary,
    /// What was read here to know which; `None` where both were named by their labels.
    pub loaded: Option<Loaded>,
    /// The path.
    pub path: Path,
    /// The problem's weights.
    pub weights: Option<Vec<f64>>,
}

/// Sees to it that the daemon has the robot and the scene that a file is about.
///
/// They are read here too: their hashes say which ones the daemon must have, and the answer is for
/// no others.
///
/// # Errors
/// A file that cannot be used, or what the daemon refuses to load.
pub(super) fn prepare(
    client: &Client,
    reader: &mut Reader,
    file: &FilePath,
    source: &Source,
    held: &[(String, f64)],
) -> Result<Prepared, CliError> {
    if let Some(label) = source.robot.as_deref().and_then(label) {
        return labelled(client, file, label, source, held);
    }
    if let Some(label) = source.scene.as_deref().and_then(label) {
        let text = format!(
            "--scene {label} is a label; name the robot by its label too, or give a scene file"
        );
        return Err(CliError::Usage(text));
    }
    let loaded = load::load_holding(reader, file, source, false, held)?;
    let listing = listing(client)?;
    let robot = loaded_robot(client, &listing, &loaded)?;
    let scene = loaded_scene(client, &listing, &loaded)?;
    // The daemon tells with its answer what is to be known of both; but where it has the same
    // content from other files, only these were read for what they leave out.
    let mut subject = loaded.subject();
    subject.warnings.retain(Warning::is_uncovered);
    let path = loaded.path.clone();
    let weights = loaded.weights.clone();
    Ok(Prepared {
        subject,
        robot,
        scene,
        loaded: Some(loaded),
        path,
        weights,
    })
}

/// A name on the command line that is no file's.
fn label(name: &FilePath) -> Option<&str> {
    let text = name.to_str()?;
    let looks_like_a_file = text.contains('/')
        || name.is_file()
        || [".urdf", ".xml", ".json", ".scene", ".yaml", ".yml"]
            .iter()
            .any(|end| text.ends_with(end));
    (!looks_like_a_file).then_some(text)
}

fn listing(client: &Client) -> Result<Listing, CliError> {
    match control(client, &ControlRequest::List)? {
        ControlReply::Listing(listing) => Ok(listing),
        other => Err(unexpected(&other)),
    }
}

/// A bare path for what is loaded already.
fn labelled(
    client: &Client,
    file: &FilePath,
    label: &str,
    source: &Source,
    held: &[(String, f64)],
) -> Result<Prepared, CliError> {
    let whole = describe(client, label)?;
    let scene = match &source.scene {
        None => load_scene(client, "empty", 0, r#"{"objects": []}"#.to_owned(), None)?,
        Some(name) => {
            let name = name.to_string_lossy();
            let mut scenes = listing(client)?.scenes;
            let known: Vec<&str> = scenes.iter().map(|scene| scene.label.as_str()).collect();
            let position = known.iter().position(|label| *label == name);
            let message = format!("no scene {name:?} is loaded; loaded: {}", known.join(", "));
            let unknown = CliError::Refused {
                code: Code::UnknownScene,
                message,
                retry_after_ms: 0,
            };
            scenes.swap_remove(position.ok_or(unknown)?)
        }
    };
    let variable = |v: &VariableDescription| Variable::within(&v.name, v.lower, v.upper);
    let whole_variables: Vec<Variable> = whole.variables.iter().map(variable).collect();
    let table = PathTable::read(file)?.for_variables(&whole_variables, &whole.fixed_joints)?;
    let refuse = |error: PlannerError| FileError::Content {
        file: file.to_owned(),
        text: error.to_string(),
    };
    let columns = Columns::new(&whole.variables, table.variables(), held).map_err(refuse)?;
    // As for a file: joints without a column are held, and what only they move is built so.
    let robot = match columns.width() < columns.robot_width() {
        true => select(client, label, table.variables().to_vec())?,
        false => whole,
    };
    let defaults = robot
        .held_variables
        .iter()
        .map(String::as_str)
        .zip(robot.held_values.iter().copied());
    let given = |name: &str| {
        held.iter()
            .rev()
            .find(|(known, _)| known == name)
            .map(|(_, value)| *value)
    };
    table.check_held(defaults.map(|(name, value)| (name, given(name).unwrap_or(value))))?;
    let variables: Vec<Variable> = robot.variables.iter().map(variable).collect();
    let read = table.warnings().to_vec();
    let path = table.into_path(&variables)?;
    let subject = Subject {
        name: file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        geometry: "loaded",
        warnings: Vec::new(),
        notes: columns
            .note()
            .map(Warning::uncovered)
            .into_iter()
            .chain(read)
            .collect(),
        variables: robot
            .variables
            .iter()
            .map(|variable| variable.name.clone())
            .collect(),
        coordinates: layout::coordinates_of_description(&robot),
        metric: String::new(),
        path_before: rows(&path),
        source: ResultSubject::default(),
    };
    Ok(Prepared {
        subject,
        robot,
        scene,
        loaded: None,
        path,
        weights: None,
    })
}

fn describe(client: &Client, label: &str) -> Result<RobotDescription, CliError> {
    match control(
        client,
        &ControlRequest::Describe {
            label: label.to_owned(),
        },
    )? {
        ControlReply::Robot(robot) => Ok(*robot),
        other => Err(unexpected(&other)),
    }
}

/// The robot of a label with these columns only.
fn select(
    client: &Client,
    label: &str,
    variables: Vec<String>,
) -> Result<RobotDescription, CliError> {
    match control(
        client,
        &ControlRequest::SelectVariables {
            label: label.to_owned(),
            variables,
        },
    )? {
        ControlReply::Robot(robot) => Ok(*robot),
        other => Err(unexpected(&other)),
    }
}

/// The label of what comes from a file: its name and the start of its hash.
fn file_label(name: &str, hash: u64) -> String {
    format!("{name}@{:08x}", hash >> 32)
}

fn loaded_robot(
    client: &Client,
    listing: &Listing,
    loaded: &Loaded,
) -> Result<RobotDescription, CliError> {
    let hash = loaded.robot.hash();
    if let Some(robot) = listing.robots.iter().find(|robot| robot.robot_hash == hash) {
        return describe(client, &robot.label);
    }
    let label = file_label(loaded.robot.name(), hash);
    let robot = load_robot(client, label, &loaded.robot_files, false)?;
    check_same("robot", &robot.label, robot.robot_hash, hash)?;
    Ok(robot)
}

fn loaded_scene(
    client: &Client,
    listing: &Listing,
    loaded: &Loaded,
) -> Result<SceneSummary, CliError> {
    let hash = loaded.scene.hash();
    if let Some(scene) = listing.scenes.iter().find(|scene| scene.scene_hash == hash) {
        return Ok(scene.clone());
    }
    let name = if loaded.scene.name().is_empty() {
        &loaded.name
    } else {
        loaded.scene.name()
    };
    let (text, folder) = match &loaded.scene_file {
        Some(file) => (
            files::selected_scene_text(file, loaded.selected.as_deref())?,
            folder_of(file),
        ),
        None => (r#"{"objects": []}"#.to_owned(), None),
    };
    let scene = load_scene(client, name, hash, text, folder)?;
    check_same("scene", &scene.label, scene.scene_hash, hash)?;
    Ok(scene)
}

/// Two processes that read the same files may find different packages.
fn check_same(kind: &str, label: &str, daemon: u64, own: u64) -> Result<(), CliError> {
    if daemon == own {
        return Ok(());
    }
    let message = format!(
        "the daemon reads {kind} {label} with hash {daemon:016x}, this process with {own:016x}; name packages with --package NAME=FOLDER, or load it under a label"
    );
    Err(CliError::Refused {
        code: Code::VersionConflict,
        message,
        retry_after_ms: 0,
    })
}

/// Loads a robot.
pub(super) fn load_robot(
    client: &Client,
    label: String,
    files: &RobotFiles,
    replace: bool,
) -> Result<RobotDescription, CliError> {
    let source = translate::robot_source(files);
    match control(
        client,
        &ControlRequest::LoadRobot {
            label,
            source,
            replace,
        },
    )? {
        ControlReply::Robot(robot) => Ok(*robot),
        other => Err(unexpected(&other)),
    }
}

fn load_scene(
    client: &Client,
    name: &str,
    hash: u64,
    json: String,
    base_dir: Option<PathBuf>,
) -> Result<SceneSummary, CliError> {
    let label = file_label(name, hash);
    match control(
        client,
        &ControlRequest::LoadScene {
            label,
            json,
            base_dir,
            replace: false,
        },
    )? {
        ControlReply::Scene(scene) => Ok(scene),
        other => Err(unexpected(&other)),
    }
}

/// The absolute folder of a file, for a daemon that was started elsewhere.
pub(super) fn folder_of(file: &FilePath) -> Option<PathBuf> {
    std::path::absolute(file)
        .ok()?
        .parent()
        .map(FilePath::to_owned)
}

/// Where robot and scene of an answer come from: from what was read here, else the daemon is asked
/// for the scene.
pub(super) fn source(
    client: &Client,
    prepared: &Prepared,
    packages: &[(String, PathBuf)],
) -> ResultSubject {
    let robot = &prepared.robot;
    let scene = &prepared.scene;
    if let Some(loaded) = &prepared.loaded {
        return loaded.source(packages);
    }
    let message = ControlRequest::ShowScene {
        label: scene.label.clone(),
        version: scene.version,
        base_version: 0,
    };
    let content = match control(client, &message) {
        Ok(ControlReply::SceneText(text)) => serde_json::from_str(&text.json).ok(),
        _ => None,
    };
    let hash = |hash: u64| format!("{hash:016x}");
    ResultSubject {
        robot: RobotSource {
            label: Some(robot.label.clone()),
            hash: hash(robot.robot_hash),
            files: None,
        },
        scene: SceneSource {
            label: Some(scene.label.clone()),
            version: Some(scene.version),
            hash: hash(scene.scene_hash),
            file: None,
            content,
        },
        ..ResultSubject::default()
    }
}

/// Runs a request. `watch` gets the length of each improvement and the time since the start.
///
/// # Errors
/// A refusal, or a daemon that went away and did not come back.
pub(super) fn run(
    client: &Client,
    prepared: &Prepared,
    layout: &Layout,
    settings: &Settings,
    deadline: Option<Duration>,
    watch: &mut dyn FnMut(Duration, f64),
) -> Result<Timed, CliError> {
    let start = Instant::now();
    let request = request(client, prepared, settings, deadline)?;
    let weights = settings
        .weights
        .as_deref()
        .unwrap_or(&prepared.robot.weights);
    let bytes = |mask: &Vec<bool>| mask.iter().map(|set| u8::from(*set)).collect::<Vec<u8>>();
    let fixed = settings
        .fixed_waypoints
        .as_ref()
        .map(bytes)
        .unwrap_or_default();
    let moving = settings
        .moving
        .as_ref()
        .map(|moving| layout.columns_of(moving))
        .unwrap_or_default();
    let body = RequestBody {
        weights: settings.weights.as_deref().unwrap_or_default(),
        fixed_waypoints: &fixed,
        group_mask: &moving,
        held_values: settings.held.as_deref().unwrap_or_default(),
    };
    let patience = deadline.unwrap_or(RECOVERY);
    let mut lengths_over_time = Vec::new();
    let mut improved = |response: &Response| {
        let time = start.elapsed();
        let length = response.header().length_after;
        lengths_over_time.push((time.as_secs_f64(), length));
        watch(time, length);
    };
    let response =
        request
            .with_body(body)
            .answer(prepared.path.as_flat(), patience, &mut improved)?;
    Ok(Timed {
        lengths_over_time,
        ..timed(
            &response,
            settings,
            &prepared.robot,
            weights,
            start.elapsed(),
        )?
    })
}

/// A request about what is prepared; nothing is sent yet.
pub(super) fn request(
    client: &Client,
    prepared: &Prepared,
    settings: &Settings,
    deadline: Option<Duration>,
) -> Result<RequestBuilder<'static>, CliError> {
    if settings.clearance_m == 0.0 {
        // On the wire, 0 is the daemon's default.
        return Err(CliError::Request {
            name: prepared.subject.name.clone(),
            source: RequestError::Clearance(0.0),
        });
    }
    let Prepared {
        robot, scene, path, ..
    } = prepared;
    let mut request = client.request(path.len() as u32, path.nq() as u32);
    request.header = taut_ipc::wire::RequestHeader {
        waypoints: request.header.waypoints,
        variables: request.header.variables,
        robot_id: robot.robot_id,
        robot_hash: robot.robot_hash,
        layout_hash: robot.layout_hash,
        scene_id: scene.scene_id,
        scene_hash: scene.scene_hash,
        deadline_ns: deadline.map_or(0, deadline_after),
        ..translate::request_header(settings)
    };
    Ok(request)
}

/// What a response tells, `time` after it was asked for.
///
/// # Errors
/// A refusal, or a response that contradicts itself.
pub(super) fn timed(
    response: &Response,
    settings: &Settings,
    robot: &RobotDescription,
    weights: &[f64],
    time: Duration,
) -> Result<Timed, CliError> {
    let view = response.view().map_err(ClientError::from)?;
    let (outcome, code) = translate::outcome(&view, settings, robot, weights)?;
    let cpu_s = view.header.compute_ns as f64 * 1e-9;
    let time_s = time.as_secs_f64();
    let request_id = Some(view.header.request_id);
    Ok(Timed {
        outcome,
        code,
        cpu_s,
        time_s,
        request_id,
        lengths_over_time: Vec::new(),
    })
}
