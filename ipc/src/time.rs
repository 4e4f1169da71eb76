//! The clock of deadlines, and numbers that differ between processes.

use rustix::time::{ClockId, clock_gettime};
use std::time::Duration;

/// CLOCK_MONOTONIC now, in nanoseconds: the clock of `deadline_ns`, the same for all processes of a
/// machine.
pub fn monotonic_ns() -> u64 {
    to_ns(ClockId::Monotonic)
}

/// The `deadline_ns` that lies `after` from now.
///
/// ```
/// use std::time::Duration;
/// assert!(taut_ipc::deadline_after(Duration::from_millis(20)) > taut_ipc::monotonic_ns());
/// ```
pub fn deadline_after(after: Duration) -> u64 {
    monotonic_ns().saturating_add(u64::try_from(after.as_nanos()).unwrap_or(u64::MAX))
}

/// A number that no other start of a process has: mixed from both clocks and the process id.
pub(crate) fn unique_number() -> u64 {
    let mut z = to_ns(ClockId::Realtime)
        ^ monotonic_ns().rotate_left(32)
        ^ u64::from(std::process::id()).rotate_left(48);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)).max(1)
}

fn to_ns(clock: ClockId) -> u64 {
    let time = clock_gettime(clock);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}
