//! Of services themselves.

use super::builtin_interfaces::Time;
use crate::message::messages;

messages! {
    /// Who called whom; part of every service's type.
    ServiceEventInfo = "service_msgs/msg/ServiceEventInfo" {
        event_type: u8,
        stamp: Time,
        /// A `char` in the package's file, which is a `uint8` in type descriptions.
        client_gid: [u8; 16],
        sequence_number: i64,
    }
}
