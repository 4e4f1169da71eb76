//! Hashes as they are published, and those of which two generators tell the same; bytes that come back, and bytes
//! that are none.

use crate::cdr::{CdrError, decode, encode};
use crate::message::{messages, services};
use crate::messages::moveit_msgs::{
    ApplyPlanningScene, GetMotionPlan, GetPlanningScene, PlanningScene, RobotTrajectory,
};
use crate::messages::moveit_msgs::{GetMotionPlanRequest, GetMotionPlanResponse};
use crate::messages::shape_msgs::SolidPrimitive;
use crate::messages::trajectory_msgs::JointTrajectory;
use crate::random::Random;
use crate::{Bounded, Message, definitions, message_hash, service_hash};
use fastrand::Rng;

messages! {
    /// Of the tutorial.
    AddTwoIntsRequest = "example_interfaces/srv/AddTwoInts_Request" {
        a: i64,
        b: i64,
    }
    /// Of the tutorial.
    AddTwoIntsResponse = "example_interfaces/srv/AddTwoInts_Response" {
        sum: i64,
    }
}

services! {
    /// The one whose hash rmw_zenoh's design page shows.
    AddTwoInts = "example_interfaces/srv/AddTwoInts" "example_interfaces/srv/AddTwoInts_Event": AddTwoIntsRequest => AddTwoIntsResponse;
}

#[test]
fn hashes_are_those_that_are_published() {
    assert_eq!(
        service_hash::<AddTwoInts>(),
        "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
    );
    for (hash, begins) in [
        (message_hash::<JointTrajectory>(), "179b33eb"),
        (message_hash::<RobotTrajectory>(), "af1dc87f"),
        (message_hash::<PlanningScene>(), "0f58540a"),
        (service_hash::<GetMotionPlan>(), "0e118e1d8d53d5fe"),
        (service_hash::<ApplyPlanningScene>(), "8e613478"),
        (service_hash::<GetPlanningScene>(), "7ed7e962"),
    ] {
        assert!(
            hash.starts_with(&format!("RIHS01_{begins}")),
            "{hash} {begins}"
        );
    }
}

/// Random cases; `TAUT_CASES` asks for more.
fn cases(short: u64) -> u64 {
    let asked = std::env::var("TAUT_CASES").ok();
    asked.map_or(short, |count| {
        count.parse().expect("TAUT_CASES is a number")
    })
}

fn random<M: Message>(rng: &mut Rng) -> M {
    M::deserialize(Random(rng)).unwrap()
}

fn comes_back<M: Message + PartialEq + std::fmt::Debug>(rng: &mut Rng) -> Vec<u8> {
    let message: M = random(rng);
    let bytes = encode(&message).unwrap();
    assert_eq!(decode::<M>(&bytes).unwrap(), message);
    bytes
}

#[test]
fn messages_come_back() {
    let mut rng = Rng::with_seed(1);
    for _ in 0..cases(300) / 3 {
        comes_back::<GetMotionPlanRequest>(&mut rng);
        comes_back::<GetMotionPlanResponse>(&mut rng);
        comes_back::<PlanningScene>(&mut rng);
    }
}

/// Changes some bytes, and of every fourth message cuts some off.
fn mutate(bytes: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..rng.usize(1..4) {
        let at = rng.usize(..bytes.len());
        bytes[at] = rng.u8(..);
    }
    if rng.usize(..4) == 0 {
        bytes.truncate(rng.usize(..bytes.len()));
    }
}

/// Whether a mutated one is read all the same.
fn is_read<M: Message + PartialEq + std::fmt::Debug>(rng: &mut Rng) -> bool {
    let mut bytes = comes_back::<M>(rng);
    mutate(&mut bytes, rng);
    decode::<M>(&bytes).is_ok()
}

#[test]
fn mutated_bytes_are_read_or_refused() {
    let mut rng = Rng::with_seed(2);
    let count = cases(2_000);
    let read = (0..count)
        .filter(|case| match case % 3 {
            0 => is_read::<GetMotionPlanRequest>(&mut rng),
            1 => is_read::<GetMotionPlanResponse>(&mut rng),
            _ => is_read::<PlanningScene>(&mut rng),
        })
        .count() as u64;
    println!("{read} of {count} read");
    assert!(0 < read && read < count, "{read}");
}

#[test]
fn what_is_too_long_or_encoded_otherwise_is_refused() {
    let long = SolidPrimitive {
        dimensions: Bounded(vec![0.0; 4]),
        ..SolidPrimitive::default()
    };
    let error = encode(&long).unwrap_err().to_string();
    assert!(error.contains("4 elements; at most 3"), "{error}");
    let mut bytes = encode(&SolidPrimitive::default()).unwrap();
    bytes[1] = 3;
    assert!(matches!(
        decode::<SolidPrimitive>(&bytes),
        Err(CdrError::Encoding(0, 3))
    ));
    assert!(matches!(
        decode::<SolidPrimitive>(&bytes[..3]),
        Err(CdrError::Short(3))
    ));
}

#[test]
fn definitions_are_those_of_the_packages() {
    let all = definitions::<PlanningScene>();
    let text = |name| {
        &all.iter()
            .find(|(found, _)| *found == name)
            .unwrap()
            .1
    };
    assert_eq!(
        text("shape_msgs/msg/SolidPrimitive"),
        "uint8 type\nfloat64[<=3] dimensions\ngeometry_msgs/Polygon polygon\n"
    );
    assert_eq!(text("shape_msgs/msg/Plane"), "float64[4] coef\n");
    assert!(text("moveit_msgs/msg/CollisionObject").ends_with("byte operation\n"));
}
