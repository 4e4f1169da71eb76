//! What the system says of a process (times, memory, files) and does for one.

use std::fs;
use std::time::Duration;

use taut_ipc::monotonic_ns;

use crate::error::Error;

/// Ends this process with the one that started it, however that ends.
pub(super) fn end_with_parent() -> Result<(), Error> {
    let set = rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::KILL));
    set.map_err(|error| Error::System {
        what: "end with its parent",
        source: error.into(),
    })
}

/// Sleeps until then, on the monotonic clock (ns).
pub(super) fn sleep_until(at_ns: u64) {
    let left = at_ns.saturating_sub(monotonic_ns());
    if left > 0 {
        std::thread::sleep(Duration::from_nanos(left));
    }
}

/// CPU time of all threads of a process that live (ns); 0 if it is gone.
pub(super) fn cpu_ns_of(pid: u32) -> u64 {
    let tasks = fs::read_dir(format!("/proc/{pid}/task"))
        .into_iter()
        .flatten()
        .flatten();
    let spent = tasks.filter_map(|task| {
        let text = fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<u64>().ok()
    });
    spent.sum()
}

/// Memory that no other process shares (bytes); 0 if it is gone.
pub(super) fn private_bytes(pid: u32) -> u64 {
    let text = fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).unwrap_or_default();
    ["Private_Clean:", "Private_Dirty:"]
        .iter()
        .map(|name| kilobytes(&text, name) * 1024)
        .sum()
}

/// Memory of its own that is in use, shared memory left out (bytes); 0 if it is gone.
pub(super) fn resident_bytes(pid: u32) -> u64 {
    let text = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    kilobytes(&text, "RssAnon:") * 1024
}

fn kilobytes(text: &str, name: &str) -> u64 {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix(name));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok())
        .unwrap_or(0)
}

/// Open files of a process; 0 if it is gone.
pub(super) fn open_files(pid: u32) -> u64 {
    fs::read_dir(format!("/proc/{pid}/fd")).map_or(0, |entries| entries.count() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_has_all_of_it() {
        let pid = std::process::id();
        assert!(private_bytes(pid) > 0 && resident_bytes(pid) > 0 && open_files(pid) > 2);
        assert!(cpu_ns_of(pid) > 0);
        assert_eq!(
            kilobytes("Rss: 12 kB\nPrivate_Clean:      34 kB\n", "Private_Clean:"),
            34
        );
    }
}
