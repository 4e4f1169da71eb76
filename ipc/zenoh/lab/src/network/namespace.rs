//! A network namespace, named after the process that made it.

use super::ip::ip;
use super::leftovers::NAMESPACES;
use crate::error::Error;

/// A namespace with its loopback up; removed when dropped.
#[derive(Debug)]
pub(super) struct Namespace(String);

impl Namespace {
    /// Makes it.
    pub(super) fn create(host: &str) -> Result<Self, Error> {
        let name = format!("{NAMESPACES}{}-{host}", std::process::id());
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
