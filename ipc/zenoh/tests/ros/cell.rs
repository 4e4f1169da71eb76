//! A real daemon on an instance of its own, with problems of `config/`, and `taut-zenoh ros` beside it.

use crate::node::Node;
use crate::world::common::until;
use crate::world::{Until, free_port};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use taut_ipc::own_daemon::{OwnDaemon, find_program};
use taut_ros::messages::moveit_msgs::{
    GenericTrajectory, GetMotionPlan, GetMotionPlanRequest, MotionPlanRequest, MotionPlanResponse,
};
use taut_ros::messages::trajectory_msgs::{JointTrajectory, JointTrajectoryPoint};
use taut_zenoh::Network;
use taut_zenoh::ros::{self, Options};
use zenoh::Wait;

pub struct Cell {
    // It ends before its daemon.
    _ros: Until,
    _daemon: OwnDaemon,
    pub endpoint: String,
    pub node: Node,
    _folder: tempfile::TempDir,
}

/// The project's folder.
pub fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn problem_file(name: &str) -> PathBuf {
    project().join(format!("config/problems/{name}.json"))
}

/// The daemon's program; `None`, with a printed reason, where it is not built.
fn program() -> Option<PathBuf> {
    let named = std::env::var_os("TAUT_BIN").map(PathBuf::from);
    let built = project().join("target/release/taut");
    let found = named
        .or_else(|| find_program("taut"))
        .or_else(|| built.is_file().then_some(built));
    if found.is_none() {
        let reason = "no `taut`: build it with `cargo build --release` in the project's folder, or set TAUT_BIN";
        assert!(!is_all_required(), "{reason}");
        println!("skipped: {reason}");
    }
    found
}

pub fn is_all_required() -> bool {
    std::env::var_os("TAUT_REQUIRE_ALL").is_some_and(|value| value == "1")
}

impl Cell {
    /// With this problem's robot and scene, under its name.
    pub fn of(problem: &str) -> Option<Self> {
        Self::with(problem, |_| {})
    }

    pub fn with(problem: &str, change: impl FnOnce(&mut Options)) -> Option<Self> {
        let program = program()?;
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("daemon.toml");
        let file = problem_file(problem);
        let text = format!(
            "workers = 2\n[[problems]]\nfile = {file:?}\nrobot = {problem:?}\nscene = {problem:?}\n"
        );
        fs::write(&config, text).unwrap();
        let endpoint = format!("tcp/127.0.0.1:{}", free_port());
        let name = format!("r{}", endpoint.rsplit(':').next().unwrap());
        let config = config.to_str().unwrap();
        let daemon = OwnDaemon::start(&program, &name, &["--config", config], |_| Ok(())).unwrap();
        let mut options = Options {
            instance: daemon.instance().clone(),
            robot: problem.to_owned(),
            scene: problem.to_owned(),
            domain: 0,
            timing: String::new(),
            follows: false,
        };
        change(&mut options);
        let network = Network {
            listen: vec![endpoint.clone()],
            finds_peers: true,
            ..Network::default()
        };
        let ros = Until::stopped(move |stop| ros::serve(&network, &options, &stop).unwrap());
        let node = Node::open(&endpoint);
        until("services are there", || services(&node).len() == 3);
        Some(Self {
            _ros: ros,
            _daemon: daemon,
            endpoint,
            node,
            _folder: folder,
        })
    }

    pub fn ask(&self, service: &str, request: &MotionPlanRequest) -> MotionPlanResponse {
        let request = GetMotionPlanRequest {
            motion_plan_request: request.clone(),
        };
        let response = self
            .node
            .call::<GetMotionPlan>(service, &request);
        response.motion_plan_response
    }

    pub fn shorten(&self, request: &MotionPlanRequest) -> MotionPlanResponse {
        self.ask("/taut/shorten", request)
    }

    pub fn check(&self, request: &MotionPlanRequest) -> MotionPlanResponse {
        self.ask("/taut/check", request)
    }

    /// The code of a check, and what it says.
    pub fn verdict(&self, request: &MotionPlanRequest) -> (i32, String) {
        let error = self.check(request).error_code;
        (error.val, error.message)
    }
}

/// Tokens of servers in domain 0.
pub fn services(node: &Node) -> Vec<String> {
    let tokens = node.session.liveliness().get("@ros2_lv/0/**");
    let tokens: Vec<String> = tokens
        .wait()
        .unwrap()
        .iter()
        .filter_map(|reply| Some(reply.result().ok()?.key_expr().to_string()))
        .collect();
    tokens
        .into_iter()
        .filter(|token| token.contains("/SS/"))
        .collect()
}

/// The path of a problem, as a request.
pub fn request(problem: &str) -> MotionPlanRequest {
    let text = fs::read_to_string(problem_file(problem)).unwrap();
    let problem: Value = serde_json::from_str(&text).unwrap();
    let names = serde_json::from_value(problem["variables"].clone()).unwrap();
    let rows: Vec<Vec<f64>> = serde_json::from_value(problem["path"].clone()).unwrap();
    let points = rows
        .into_iter()
        .map(|positions| JointTrajectoryPoint {
            positions,
            ..JointTrajectoryPoint::default()
        });
    of(JointTrajectory {
        joint_names: names,
        points: points.collect(),
        ..JointTrajectory::default()
    })
}

/// A request about a path.
pub fn of(path: JointTrajectory) -> MotionPlanRequest {
    MotionPlanRequest {
        reference_trajectories: vec![GenericTrajectory {
            joint_trajectory: vec![path],
            ..GenericTrajectory::default()
        }],
        num_planning_attempts: 1,
        allowed_planning_time: 10.0,
        ..MotionPlanRequest::default()
    }
}

pub fn path(request: &mut MotionPlanRequest) -> &mut JointTrajectory {
    &mut request.reference_trajectories[0].joint_trajectory[0]
}
