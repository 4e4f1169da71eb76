//! Where joints are to be, and when.

use super::builtin_interfaces::Duration;
use super::geometry_msgs::{Transform, Twist};
use super::std_msgs::Header;
use crate::message::messages;

messages! {
    /// Of the trajectory's joints, in their order; lists that are not told are empty.
    JointTrajectoryPoint = "trajectory_msgs/msg/JointTrajectoryPoint" {
        positions: Vec<f64>,
        velocities: Vec<f64>,
        accelerations: Vec<f64>,
        effort: Vec<f64>,
        time_from_start: Duration,
    }

    /// Of joints with one value.
    JointTrajectory = "trajectory_msgs/msg/JointTrajectory" {
        header: Header,
        joint_names: Vec<String>,
        points: Vec<JointTrajectoryPoint>,
    }

    /// Of joints with more than one.
    MultiDOFJointTrajectoryPoint = "trajectory_msgs/msg/MultiDOFJointTrajectoryPoint" {
        transforms: Vec<Transform>,
        velocities: Vec<Twist>,
        accelerations: Vec<Twist>,
        time_from_start: Duration,
    }

    /// Of joints with more than one.
    MultiDOFJointTrajectory = "trajectory_msgs/msg/MultiDOFJointTrajectory" {
        header: Header,
        joint_names: Vec<String>,
        points: Vec<MultiDOFJointTrajectoryPoint>,
    }
}
