//! What is served, and how.

use taut_ipc::Instance;

/// What nodes reach.
#[derive(Clone, Debug)]
pub struct Options {
    /// The daemon's instance.
    pub instance: Instance,
    /// Label of the robot that requests are about.
    pub robot: String,
    /// Label of its scene.
    pub scene: String,
    /// `ROS_DOMAIN_ID`.
    pub domain: u32,
    /// What times are asked for, as in a request's option `timing`; empty = none.
    pub timing: String,
    /// Whether MoveIt's scene is followed.
    pub follows: bool,
}
