//! The clock of deadlines, and numbers that differ between processes.

use rustix::time::{ClockId, clock_gettime};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
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

/// A number that nothing else has: of one series in this process, however many threads take from it
/// at once, and of another in each other process.
pub(crate) fn next_number() -> u64 {
    static FIRST: LazyLock<u64> = LazyLock::new(unique_number);
    static TAKEN: AtomicU64 = AtomicU64::new(0);
    FIRST.wrapping_add(TAKEN.fetch_add(1, Ordering::Relaxed))
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn threads_that_take_numbers_at_the_same_moment_get_different_ones() {
        let take = || {
            (0..100_000)
                .map(|_| next_number())
                .collect::<Vec<_>>()
        };
        let threads: Vec<_> = (0..4)
            .map(|_| std::thread::spawn(take))
            .collect();
        let taken = threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap());
        assert_eq!(taken.collect::<HashSet<_>>().len(), 400_000);
    }
}
