//! Time.

use crate::message::messages;

messages! {
    /// Since the epoch of whichever clock it is.
    Time = "builtin_interfaces/msg/Time" {
        sec: i32,
        /// On top of `sec`, also before the epoch.
        nanosec: u32,
    }

    /// How long.
    Duration = "builtin_interfaces/msg/Duration" {
        sec: i32,
        /// On top of `sec`, also where that is negative.
        nanosec: u32,
    }
}
