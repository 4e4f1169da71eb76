//! CDR as others write it: what is encoded here comes out of rosbags, from PyPI, as the same bytes.
#![allow(missing_docs)]

#[path = "../src/random.rs"]
mod random;
#[path = "../../tests/ros/venv.rs"]
mod venv;

use fastrand::Rng;
use random::Random;
use std::fs;
use std::path::Path;
use std::process::Command;
use taut_ros::cdr::encode;
use taut_ros::messages::moveit_msgs::{
    ApplyPlanningSceneResponse, GetMotionPlanRequest, GetMotionPlanResponse,
    GetPlanningSceneRequest, GetPlanningSceneResponse, PlanningScene,
};
use taut_ros::{Message, definitions};

/// Random messages; `TAUT_CASES` asks for more.
const CASES: usize = 600;

/// Writes so many random messages, each after its length, and the definitions of all that is in them.
fn write<M: Message>(folder: &Path, rng: &mut Rng, count: usize) -> usize {
    venv::write_definitions(folder, definitions::<M>());
    let mut all = Vec::new();
    for _ in 0..count {
        let message = M::deserialize(Random(rng)).unwrap();
        let bytes = encode(&message).unwrap();
        all.extend((bytes.len() as u32).to_le_bytes());
        all.extend(bytes);
    }
    fs::write(folder.join(format!("{}.cdr", M::NAME)), all).unwrap();
    count
}

#[test]
fn bytes_are_those_of_rosbags() {
    let Some(python) = venv::python() else {
        return;
    };
    let asked = std::env::var("TAUT_CASES").ok();
    let cases: usize = asked.map_or(CASES, |count| count.parse().unwrap());
    let each = cases.div_ceil(6);
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_seed(3);
    let written = [
        write::<GetMotionPlanRequest>(folder.path(), &mut rng, each),
        write::<GetMotionPlanResponse>(folder.path(), &mut rng, each),
        write::<PlanningScene>(folder.path(), &mut rng, each),
        write::<ApplyPlanningSceneResponse>(folder.path(), &mut rng, each),
        write::<GetPlanningSceneRequest>(folder.path(), &mut rng, each),
        write::<GetPlanningSceneResponse>(folder.path(), &mut rng, each),
    ];
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/same_bytes.py");
    let same = venv::run(
        Command::new(python)
            .arg(script)
            .arg(folder.path()),
    );
    let same: usize = same
        .unwrap_or_else(|error| panic!("{error}"))
        .trim()
        .parse()
        .unwrap();
    assert_eq!(same, written.iter().sum::<usize>());
}
