//! A network namespace, named after the process that made it.

use std::path::Path;

use super::ip::ip;
use crate::error::Error;

/// How all names begin; the process and the host follow.
const PREFIX: &str = "taut-lab-";

/// A namespace with its loopback up; removed when dropped.
#[derive(Debug)]
pub(super) struct Namespace(String);

impl Namespace {
    /// Makes it.
    pub(super) fn create(host: &str) -> Result<Self, Error> {
        let name = format!("{PREFIX}{}-{host}", std::process::id());
        ip(&format!("netns add {name}"))?;
        let namespace = Self(name);
        ip(&format!("-n {} link set lo up", namespace.0))?;
        Ok(namespace)
    }

    /// What `ip` calls it.
    pub(super) fn name(&self) -> &str {
        &self.0
    }
}

impl Drop for Namespace {
    fn drop(&mut self) {
        // Nobody is left to tell; the next lab removes what is left.
        let _ = ip(&format!("netns delete {}", self.0));
    }
}

/// Removes namespaces of labs that were killed.
pub(super) fn sweep() -> Result<(), Error> {
    for name in ip("netns list")?.lines() {
        let name = name.split(' ').next().unwrap_or_default();
        if maker(name).is_some_and(|pid| !is_alive(pid)) {
            // Another lab may sweep it as well.
            let _ = ip(&format!("netns delete {name}"));
        }
    }
    Ok(())
}

/// The process that a namespace is named after; `None` where it is no lab's.
fn maker(name: &str) -> Option<u32> {
    let rest = name.strip_prefix(PREFIX)?;
    rest.split('-').next()?.parse().ok()
}

fn is_alive(pid: u32) -> bool {
    Path::new(&format!("/proc/{pid}")).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_namespace_tells_who_made_it() {
        assert_eq!(maker("taut-lab-17-a"), Some(17));
        assert_eq!(maker("taut-lab-x-a"), None);
        assert_eq!(maker("blue"), None);
    }
}
