//! Which folder keeps robots and scenes while no daemon runs.

use std::path::PathBuf;

use taut_ipc::{Instance, InstanceError};

use super::config::Config;

/// Why there is none.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// Nobody says where.
    #[error(
        "no folder to keep robots and scenes in: neither STATE_DIRECTORY, XDG_STATE_HOME nor HOME is an absolute path; name one with --state, or use --no-state"
    )]
    Nowhere,
    /// The instance.
    #[error(transparent)]
    Instance(#[from] InstanceError),
}

/// The folder of a configuration and an instance; `None` if nothing is to be kept.
///
/// By default an instance with a root of its own keeps in `state` below it, and goes as a whole
/// with its root. Others keep below the service's state folder (`STATE_DIRECTORY`, from systemd),
/// else the user's (`XDG_STATE_HOME`, else `~/.local/state`, there in `taut`), under the instance's
/// name.
///
/// # Errors
/// No folder is known.
pub fn folder(config: &Config, instance: &Instance) -> Result<Option<PathBuf>, StateError> {
    if let Some(folder) = &config.state {
        return Ok(Some(folder.clone()).filter(|folder| !folder.as_os_str().is_empty()));
    }
    if *instance != Instance::named(instance.name())? {
        return Ok(Some(instance.root().join("state")));
    }
    let absolute = |name: &str| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .filter(|path| path.is_absolute())
    };
    let base = absolute("STATE_DIRECTORY")
        .or_else(|| Some(absolute("XDG_STATE_HOME")?.join("taut")))
        .or_else(|| Some(absolute("HOME")?.join(".local/state/taut")));
    Ok(Some(base.ok_or(StateError::Nowhere)?.join(instance.name())))
}
