//! Maps of what is occupied.

use super::geometry_msgs::Pose;
use super::std_msgs::Header;
use crate::message::messages;

messages! {
    /// A tree as OctoMap writes it, without its file's header.
    Octomap = "octomap_msgs/msg/Octomap" {
        header: Header,
        binary: bool,
        id: String,
        resolution: f64,
        data: Vec<i8>,
    }

    /// The same, elsewhere.
    OctomapWithPose = "octomap_msgs/msg/OctomapWithPose" {
        header: Header,
        origin: Pose,
        octomap: Octomap,
    }
}
