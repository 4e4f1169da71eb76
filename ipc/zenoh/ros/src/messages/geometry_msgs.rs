//! Places, directions and motions.

use super::std_msgs::Header;
use crate::message::messages;

messages! {
    /// A place (m).
    Point = "geometry_msgs/msg/Point" {
        x: f64,
        y: f64,
        z: f64,
    }

    /// A place (m), in fewer bytes.
    Point32 = "geometry_msgs/msg/Point32" {
        x: f32,
        y: f32,
        z: f32,
    }

    /// A direction, or whatever has three parts.
    Vector3 = "geometry_msgs/msg/Vector3" {
        x: f64,
        y: f64,
        z: f64,
    }

    /// A rotation; all zero where nobody set it.
    Quaternion = "geometry_msgs/msg/Quaternion" {
        x: f64,
        y: f64,
        z: f64,
        w: f64,
    }

    /// Where and how turned.
    Pose = "geometry_msgs/msg/Pose" {
        position: Point,
        orientation: Quaternion,
    }

    /// The same in a frame.
    PoseStamped = "geometry_msgs/msg/PoseStamped" {
        header: Header,
        pose: Pose,
    }

    /// From one frame to another.
    Transform = "geometry_msgs/msg/Transform" {
        translation: Vector3,
        rotation: Quaternion,
    }

    /// From the header's frame to the child's.
    TransformStamped = "geometry_msgs/msg/TransformStamped" {
        header: Header,
        child_frame_id: String,
        transform: Transform,
    }

    /// Velocities (m/s, rad/s).
    Twist = "geometry_msgs/msg/Twist" {
        linear: Vector3,
        angular: Vector3,
    }

    /// Accelerations (m/s², rad/s²).
    Accel = "geometry_msgs/msg/Accel" {
        linear: Vector3,
        angular: Vector3,
    }

    /// Force and torque (N, N m).
    Wrench = "geometry_msgs/msg/Wrench" {
        force: Vector3,
        torque: Vector3,
    }

    /// Corners in their order; the last is joined with the first.
    Polygon = "geometry_msgs/msg/Polygon" {
        points: Vec<Point32>,
    }
}
