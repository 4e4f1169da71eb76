//! The messages that taut reads and writes, a module for each package of ROS 2 (their branches of Jazzy;
//! moveit_msgs 2.6.0). Fields mean what the packages say of them, in SI units; frames are named by headers.

pub mod builtin_interfaces;
pub mod geometry_msgs;
pub mod moveit_msgs;
pub mod object_recognition_msgs;
pub mod octomap_msgs;
pub mod sensor_msgs;
pub mod service_msgs;
pub mod shape_msgs;
pub mod std_msgs;
pub mod trajectory_msgs;
