//! What many messages begin with.

use super::builtin_interfaces::Time;
use crate::message::messages;

messages! {
    /// When, and in which frame.
    Header = "std_msgs/msg/Header" {
        stamp: Time,
        frame_id: String,
    }

    /// From 0 to 1.
    ColorRGBA = "std_msgs/msg/ColorRGBA" {
        r: f32,
        g: f32,
        b: f32,
        a: f32,
    }
}
