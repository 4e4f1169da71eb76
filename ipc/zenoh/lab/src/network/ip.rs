//! `ip` of iproute2, which makes namespaces and devices.

use std::process::Command;

use crate::error::Error;

/// Runs `ip` with these arguments, as they would be typed.
pub(super) fn ip(arguments: &str) -> Result<String, Error> {
    let failed = |reason: String| Error::Network {
        what: format!("ip {arguments}"),
        reason,
    };
    let output = Command::new("ip")
        .args(arguments.split(' '))
        .output()
        .map_err(|error| failed(error.to_string()))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(failed(
            String::from_utf8_lossy(&output.stderr)
                .trim()
                .to_owned(),
        )),
    }
}
