//! A planner's talk with the daemon: make robot and scene known, send a path, take better ones.

use std::error::Error;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use taut::collision::CollisionModel;
use taut::files::{self, Geometry, Problem, Reader};
use taut::path::Path;
use taut::robot::JointKind;
use taut_ipc::control::{
    ControlReply, ControlRequest, RobotSource, VirtualJoint, VirtualJointKind,
};
use taut_ipc::wire::{Code, Mode, RequestHeader, label_id};
use taut_ipc::{Client, Response, deadline_after};

use super::rrt_connect::{self, Rules};

/// How long the daemon may take to read models, and to be late with an answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// What a planner is to find and how long shortening it may take.
#[derive(Clone, Debug)]
pub struct Query {
    /// Problem file: its robot, its scene, and the ends of its path.
    pub problem: PathBuf,
    /// Seed of the search and of the daemon's optimizer.
    pub seed: u64,
    /// Time that the daemon gets.
    pub deadline: Duration,
}

/// What happens on the way to the answer.
pub enum Step<'a> {
    /// The planner has found a path.
    Planned(&'a Path, Duration),
    /// The daemon has found and proved a shorter one, of this length.
    Improved(f64),
}

/// What the daemon made of the path.
#[derive(Debug)]
pub struct Answer {
    /// How it went.
    pub code: Code,
    /// What the daemon has to say about it; often nothing.
    pub message: String,
    /// Whether the path is proved free of collisions at every instant.
    pub proved: bool,
    /// Length of the planner's path, metres that the robot's farthest points move.
    pub length_before: f64,
    /// Length of the path now.
    pub length_after: f64,
    /// Distance that every pair of bodies is proved to keep [m]; `None` where nothing comes near.
    pub clearance_m: Option<f64>,
    /// The path now.
    pub path: Path,
    /// From the request to the final answer.
    pub time: Duration,
}

/// Plans for a query, has the path shortened, and returns what came of it.
///
/// # Errors
/// Files that cannot be read, no path within the planner's iterations, no daemon, or models that it
/// refuses.
pub fn run(
    client: &Client,
    query: &Query,
    tell: &mut dyn FnMut(Step),
) -> Result<Answer, Box<dyn Error>> {
    let problem = Reader::default().problem(&query.problem, Geometry::Given)?;
    let model = CollisionModel::new(Arc::new(problem.model()?), Arc::new(problem.scene.clone()))?;
    let start = Instant::now();
    let first = problem.path.waypoint(0);
    let last = problem.path.waypoint(problem.path.len() - 1);
    let rules = Rules {
        seed: query.seed,
        ..Rules::default()
    };
    let path = rrt_connect::plan(&model, first, last, &rules).ok_or_else(|| {
        format!(
            "no path in {} iterations; try another seed",
            rules.iterations
        )
    })?;
    tell(Step::Planned(&path, start.elapsed()));
    let header = introduce(client, &problem, &model)?;
    shorten(
        client,
        RequestHeader {
            seed: query.seed,
            ..header
        },
        &path,
        query.deadline,
        tell,
    )
}

/// Makes the robot and the scene known, which costs next to nothing where they are already, and
/// starts a request's header. With the hashes of what was planned for, the daemon refuses to take
/// others for them.
fn introduce(
    client: &Client,
    problem: &Problem,
    model: &CollisionModel,
) -> Result<RequestHeader, Box<dyn Error>> {
    let robot = ControlRequest::LoadRobot {
        label: problem.robot.name.clone(),
        source: robot_source(problem)?,
        replace: false,
        files: None,
    };
    let ControlReply::Robot(robot) = asked(client, &robot)? else {
        return Err("no robot in the reply".into());
    };
    let scene = ControlRequest::LoadScene {
        label: problem.name.clone(),
        json: files::scene_text(&problem.file)?,
        base_dir: std::path::absolute(&problem.file)?
            .parent()
            .map(FilePath::to_owned),
        replace: false,
        files: None,
        version: None,
    };
    let ControlReply::Scene(scene) = asked(client, &scene)? else {
        return Err("no scene in the reply".into());
    };
    Ok(RequestHeader {
        robot_id: label_id(&robot.label),
        robot_hash: model.robot().hash(),
        layout_hash: model.robot().layout_hash(),
        scene_id: label_id(&scene.label),
        scene_hash: model.scene().hash(),
        ..RequestHeader::default()
    })
}

/// A control message and its reply; a refusal is an error here.
fn asked(client: &Client, message: &ControlRequest) -> Result<ControlReply, Box<dyn Error>> {
    match client.control(message, PATIENCE)? {
        ControlReply::Refused(refusal) => Err(refusal.message.into()),
        reply => Ok(reply),
    }
}

/// Sends the path, again where the daemon asks for that, and waits for the final answer.
fn shorten(
    client: &Client,
    header: RequestHeader,
    path: &Path,
    deadline: Duration,
    tell: &mut dyn FnMut(Step),
) -> Result<Answer, Box<dyn Error>> {
    let start = Instant::now();
    loop {
        let answer = send(client, header, path, deadline, tell)?;
        let retry_after = Duration::from_millis(answer.header().retry_after_ms.into());
        if !answer.code().is_retryable() || start.elapsed() > PATIENCE {
            return Ok(into_answer(&answer, path, start.elapsed()));
        }
        std::thread::sleep(retry_after);
    }
}

fn send(
    client: &Client,
    header: RequestHeader,
    path: &Path,
    deadline: Duration,
    tell: &mut dyn FnMut(Step),
) -> Result<Response, Box<dyn Error>> {
    let mut request = client.request(path.len() as u32, path.nq() as u32);
    let waypoints = request.header.waypoints;
    let variables = request.header.variables;
    let group = request.header.group;
    let mode = Mode::Hybrid.into();
    let deadline_ns = deadline_after(deadline);
    request.header = RequestHeader {
        waypoints,
        variables,
        group,
        mode,
        deadline_ns,
        ..header
    };
    // Shared memory: what is written here is what the daemon reads.
    let mut loan = request.loan()?;
    for (row, waypoint) in loan
        .path_mut()
        .chunks_exact_mut(path.nq())
        .zip(path.waypoints())
    {
        row.copy_from_slice(waypoint);
    }
    let mut pending = loan.send()?;
    while let Some(best) = pending.next(deadline + PATIENCE)? {
        if best.is_final() {
            return Ok(best);
        }
        // Each of these is proved already; a planner in a hurry may take it and drop `pending`.
        tell(Step::Improved(best.header().length_after));
    }
    Err("the daemon sent no final answer".into())
}

/// Copies the answer out of shared memory, since the table and the picture outlive the connection.
fn into_answer(response: &Response, path: &Path, time: Duration) -> Answer {
    let header = response.header();
    // Without a better path the planner's own stands, with the verdict on it.
    let shortened = Path::from_rows(path.nq(), response.path().to_vec());
    Answer {
        code: response.code(),
        message: response.message().to_owned(),
        proved: response
            .view()
            .is_ok_and(|view| view.is_proved()),
        length_before: header.length_before,
        length_after: header.length_after,
        clearance_m: header
            .clearance_m
            .is_finite()
            .then_some(header.clearance_m),
        path: shortened.unwrap_or_else(|| path.clone()),
        time,
    }
}

/// The problem's robot as the daemon wants it: files that it can read, and what the problem adds to
/// them.
fn robot_source(problem: &Problem) -> Result<RobotSource, Box<dyn Error>> {
    let files = &problem.robot_files;
    let joint = &problem.robot.virtual_joint;
    let virtual_joint = joint.as_ref().map(|joint| VirtualJoint {
        name: joint.name.clone(),
        kind: if joint.kind == JointKind::Planar {
            VirtualJointKind::Planar
        } else {
            VirtualJointKind::Floating
        },
        parent_frame: "world".to_owned(),
        position_bounds: joint.position_bounds.clone(),
    });
    Ok(RobotSource {
        urdf: std::path::absolute(&files.urdf)?,
        srdf: files
            .srdf
            .as_ref()
            .map(std::path::absolute)
            .transpose()?,
        virtual_joint,
        variables: files.variables.clone().unwrap_or_default(),
        allowed_collisions: files.allowed_collisions.clone(),
        ..RobotSource::default()
    })
}
