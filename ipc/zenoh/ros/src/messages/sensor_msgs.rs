//! Where joints are.

use super::geometry_msgs::{Transform, Twist, Wrench};
use super::std_msgs::Header;
use crate::message::messages;

messages! {
    /// Of joints with one value; lists that are not told are empty.
    JointState = "sensor_msgs/msg/JointState" {
        header: Header,
        name: Vec<String>,
        position: Vec<f64>,
        velocity: Vec<f64>,
        effort: Vec<f64>,
    }

    /// Of joints with more than one.
    MultiDOFJointState = "sensor_msgs/msg/MultiDOFJointState" {
        header: Header,
        joint_names: Vec<String>,
        transforms: Vec<Transform>,
        twist: Vec<Twist>,
        wrench: Vec<Wrench>,
    }
}
