//! A connection to a daemon, or the same in this process.

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{PoisonError, RwLock};
use std::time::Instant;
use taut::files::RobotFiles;
use taut_ipc::Instance;
use taut_ipc::control::{
    ControlReply, ControlRequest, LastFrame, RobotDescription, SceneSummary, SceneText,
};
use taut_ipc::planner::{Planner, PlannerError};
use taut_ipc::wire::{Code, label_id};

use super::about::{About, RobotFilesOf};
use super::answers::Answers;
use super::feed::SceneFeed;
use super::guard::{Interrupt, Own};
use super::{errors, frames, ndarray, options, problem};

/// Who answers. See `taut.Planner`.
#[pyclass(frozen, module = "taut._taut")]
pub struct Connection {
    planner: RwLock<Option<Own<Planner>>>,
    files: RobotFilesOf,
}

/// Connects to the daemon of an instance.
#[pyfunction]
#[pyo3(signature = (instance=None))]
pub fn connect(py: Python<'_>, instance: Option<&str>) -> PyResult<Connection> {
    let instance = match instance {
        Some(text) => Instance::parse(text),
        None => Instance::from_environment(),
    };
    let instance = instance.map_err(|error| errors::of(&error.into()))?;
    let planner = py
        .detach(|| Planner::connect(&instance))
        .map_err(|error| errors::of(&error))?;
    Ok(Connection::new(planner))
}

/// Answers in this process.
#[pyfunction]
pub fn local() -> Connection {
    Connection::new(Planner::in_process(taut::local::LocalService::default()))
}

impl Connection {
    fn new(planner: Planner) -> Self {
        Self {
            planner: RwLock::new(Some(Own::new(planner))),
            files: RobotFilesOf::default(),
        }
    }

    fn planner(&self) -> PyResult<Planner> {
        let planner = self
            .planner
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        match &*planner {
            Some(planner) => Ok(planner.get()?.clone()),
            None => Err(errors::raise(
                Code::DaemonLost,
                "this connection is closed; make another one",
            )),
        }
    }

    /// Sends a control message without the interpreter's lock; a signal ends the wait.
    fn control(&self, py: Python<'_>, message: ControlRequest) -> PyResult<ControlReply> {
        let planner = self.planner()?;
        let interrupt = Interrupt::default();
        let reply = py.detach(|| planner.control_until(&message, &|| interrupt.came()));
        match interrupt.take() {
            Some(signal) => Err(signal),
            None => reply.map_err(|error| errors::of(&error)),
        }
    }

    fn robot_after(&self, py: Python<'_>, message: ControlRequest) -> PyResult<RobotDescription> {
        match self.control(py, message)? {
            ControlReply::Robot(robot) => Ok(*robot),
            other => Err(unexpected(&other)),
        }
    }

    fn scene_after<'py>(
        &self,
        py: Python<'py>,
        message: ControlRequest,
    ) -> PyResult<Bound<'py, PyDict>> {
        match self.control(py, message)? {
            ControlReply::Scene(scene) => scene_dict(py, &scene),
            other => Err(unexpected(&other)),
        }
    }
}

fn unexpected(reply: &ControlReply) -> PyErr {
    errors::invalid(format!(
        "the daemon answers {reply:?}; use client and daemon of the same release"
    ))
}

#[pymethods]
impl Connection {
    /// Ends the connection; answers that are there stay as they are.
    fn close(&self, py: Python<'_>) {
        let planner = self
            .planner
            .write()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        py.detach(|| drop(planner));
    }

    #[getter]
    fn closed(&self) -> bool {
        self.planner
            .read()
            .unwrap_or_else(PoisonError::into_inner)
            .is_none()
    }

    /// Labels of robots and summaries of scenes.
    fn listing<'py>(&self, py: Python<'py>) -> PyResult<(Vec<String>, Vec<Bound<'py, PyDict>>)> {
        match self.control(py, ControlRequest::List)? {
            ControlReply::Listing(listing) => {
                let scenes = listing
                    .scenes
                    .iter()
                    .map(|scene| scene_dict(py, scene))
                    .collect::<PyResult<_>>()?;
                Ok((
                    listing
                        .robots
                        .into_iter()
                        .map(|robot| robot.label)
                        .collect(),
                    scenes,
                ))
            }
            other => Err(unexpected(&other)),
        }
    }

    fn robot<'py>(&self, py: Python<'py>, label: String) -> PyResult<Bound<'py, PyDict>> {
        robot_dict(
            py,
            &self.robot_after(py, ControlRequest::Describe { label })?,
        )
    }

    #[pyo3(signature = (label, urdf, srdf, packages, variables, allowed_collisions, replace))]
    #[expect(
        clippy::too_many_arguments,
        reason = "they are the parts of a robot, named on the Python side"
    )]
    fn load_robot<'py>(
        &self,
        py: Python<'py>,
        label: String,
        urdf: PathBuf,
        srdf: Option<PathBuf>,
        packages: BTreeMap<String, PathBuf>,
        variables: Option<Vec<String>>,
        allowed_collisions: Vec<(String, String)>,
        replace: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let srdf = srdf.or_else(|| taut::files::srdf_of(&urdf));
        let files = RobotFiles {
            urdf,
            srdf,
            packages,
            variables,
            allowed_collisions,
            ..RobotFiles::default()
        };
        let source = taut::translate::robot_source(&files);
        let files = taut::translate::robot_files(source.clone());
        let robot = self.robot_after(
            py,
            ControlRequest::LoadRobot {
                label,
                source,
                replace,
                files: None,
            },
        )?;
        self.files.learn(robot.robot_hash, files);
        robot_dict(py, &robot)
    }

    fn unload_robot(&self, py: Python<'_>, label: String) -> PyResult<()> {
        self.control(py, ControlRequest::UnloadRobot { label })
            .map(drop)
    }

    fn load_scene<'py>(
        &self,
        py: Python<'py>,
        label: String,
        json: String,
        base_dir: Option<PathBuf>,
        replace: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.scene_after(
            py,
            ControlRequest::LoadScene {
                label,
                json,
                base_dir,
                replace,
                files: None,
                version: None,
            },
        )
    }

    /// The text of a scene file, or of the scene of a problem file, as JSON.
    fn scene_text(&self, file: PathBuf) -> PyResult<String> {
        let text = taut::files::scene_text(&file);
        text.map_err(|error| {
            let refusal = taut::translate::file_refusal(&error);
            errors::raise(
                Code::try_from(refusal.code).unwrap_or(Code::InvalidModel),
                &refusal.message,
            )
        })
    }

    fn unload_scene(&self, py: Python<'_>, label: String) -> PyResult<()> {
        self.control(py, ControlRequest::UnloadScene { label })
            .map(drop)
    }

    fn change_scene<'py>(
        &self,
        py: Python<'py>,
        label: String,
        json: String,
        base_dir: Option<PathBuf>,
        base_version: u64,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.scene_after(
            py,
            ControlRequest::DiffScene {
                label,
                json,
                base_dir,
                base_version,
                files: None,
                version: None,
            },
        )
    }

    fn pin_scene<'py>(
        &self,
        py: Python<'py>,
        label: String,
        version: u64,
        pinned: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.scene_after(
            py,
            ControlRequest::PinScene {
                label,
                version,
                pinned,
            },
        )
    }

    /// Sends a frame of a sensor; the array is copied once, into shared memory.
    fn frame<'py>(
        &self,
        py: Python<'py>,
        label: &str,
        object: &str,
        points: PyReadonlyArray1<'_, u8>,
        head: &Bound<'_, PyDict>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let planner = self.planner()?;
        let frame = frames::head(head)?;
        let points = points.as_slice()?;
        let taken = py.detach(|| planner.set_cloud(label, object, frame, points));
        frames::summary(py, &taken.map_err(|error| errors::of(&error))?)
    }

    fn show_scene(
        &self,
        py: Python<'_>,
        label: String,
        version: u64,
        base_version: u64,
    ) -> PyResult<(u64, String, String)> {
        match self.control(
            py,
            ControlRequest::ShowScene {
                label,
                version,
                base_version,
            },
        )? {
            ControlReply::SceneText(SceneText {
                version,
                scene_hash,
                json,
                ..
            }) => Ok((version, format!("{scene_hash:016x}"), json)),
            other => Err(unexpected(&other)),
        }
    }

    fn subscribe(&self, label: &str) -> PyResult<SceneFeed> {
        SceneFeed::open(&self.planner()?, label_id(label))
    }

    fn load_problem<'py>(
        &self,
        py: Python<'py>,
        file: PathBuf,
        spheres: bool,
        robot: Option<String>,
        scene: Option<String>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let planner = self.planner()?;
        let loaded = py
            .detach(|| problem::load(&planner, &file, spheres, robot.as_deref(), scene.as_deref()));
        let loaded = loaded.map_err(|error| errors::of(&error))?;
        self.files
            .learn(loaded.robot_hash, loaded.robot_files);
        let dict = PyDict::new(py);
        dict.set_item("name", loaded.name)?;
        dict.set_item("robot", loaded.robot)?;
        dict.set_item("scene", loaded.scene)?;
        dict.set_item("columns", loaded.columns)?;
        dict.set_item("path", numpy::PyArray1::from_vec(py, loaded.path))?;
        dict.set_item("waypoints", loaded.waypoints)?;
        dict.set_item("weights", loaded.weights)?;
        dict.set_item("constraints", loaded.constraints)?;
        dict.set_item("warnings", loaded.warnings)?;
        Ok(dict)
    }

    /// Sends a path; the array is read in place.
    fn ask(
        &self,
        py: Python<'_>,
        path: PyReadonlyArray2<'_, f64>,
        robot: &str,
        scene: Option<&str>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<Answers> {
        let planner = self.planner()?;
        let request = options::request(robot, scene, options)?;
        let (width, numbers) = ndarray::path_of(&path)?;
        let start = Instant::now();
        let asked = py.detach(|| {
            check_width(&planner, &request, width)?;
            planner.ask(&request, numbers)
        });
        let stream = asked.map_err(|error| errors::of(&error))?;
        let about = About {
            planner: Own::new(planner),
            files: self.files.clone(),
            request,
            start,
        };
        Ok(Answers::new(stream, about))
    }
}

/// Rows of another width may make whole rows by chance.
fn check_width(
    planner: &Planner,
    request: &taut_ipc::planner::Request,
    width: usize,
) -> Result<(), PlannerError> {
    let robot = planner.robot(&request.robot)?;
    let columns = request.columns_of(&robot)?;
    if columns.width() == width {
        return Ok(());
    }
    let names = match request.columns.as_slice() {
        [] => robot
            .variables
            .iter()
            .map(|variable| variable.name.clone())
            .collect(),
        names => names.to_vec(),
    };
    let message = format!(
        "the path has {width} columns, not {}: {}",
        names.len(),
        names.join(", ")
    );
    Err(PlannerError::Invalid {
        code: Code::InvalidRobotState,
        message,
    })
}

fn robot_dict<'py>(py: Python<'py>, robot: &RobotDescription) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("label", &robot.label)?;
    dict.set_item("hash", format!("{:016x}", robot.robot_hash))?;
    let variables: Vec<_> = robot
        .variables
        .iter()
        .map(|v| (v.name.as_str(), v.lower, v.upper, v.continuous))
        .collect();
    dict.set_item("variables", variables)?;
    let name = |index: &u32| robot.variables[*index as usize].name.as_str();
    let groups: BTreeMap<&str, Vec<&str>> = robot
        .groups
        .iter()
        .map(|group| {
            (
                group.name.as_str(),
                group.variables.iter().map(name).collect(),
            )
        })
        .collect();
    dict.set_item("groups", groups)?;
    let held: BTreeMap<&String, f64> = robot
        .held_variables
        .iter()
        .zip(robot.held_values.iter().copied())
        .collect();
    dict.set_item("held", held)?;
    dict.set_item("weights", &robot.weights)?;
    dict.set_item("warnings", &robot.warnings)?;
    Ok(dict)
}

fn scene_dict<'py>(py: Python<'py>, scene: &SceneSummary) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("label", &scene.label)?;
    dict.set_item("version", scene.version)?;
    dict.set_item("hash", format!("{:016x}", scene.scene_hash))?;
    dict.set_item("objects", scene.objects)?;
    dict.set_item("warnings", &scene.warnings)?;
    dict.set_item("kept_from", scene.kept_from)?;
    dict.set_item("pinned", &scene.pinned)?;
    let sensed = PyDict::new(py);
    for object in &scene.sensed {
        sensed.set_item(
            &object.object,
            object
                .last
                .map(|last| frame_dict(py, last))
                .transpose()?,
        )?;
    }
    dict.set_item("sensed", sensed)?;
    Ok(dict)
}

fn frame_dict(py: Python<'_>, last: LastFrame) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("age", last.age_ns as f64 * 1e-9)?;
    dict.set_item("period", last.period_ns as f64 * 1e-9)?;
    dict.set_item("came", last.came)?;
    dict.set_item("on_robot", last.on_robot)?;
    dict.set_item("in_padding", last.in_padding)?;
    dict.set_item("points", last.points)?;
    Ok(dict)
}
