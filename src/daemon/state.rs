//! Which folder keeps robots and scenes while no daemon runs.

use std::path::PathBuf;

use taut_ipc::{Instance, InstanceError};

use crate::daemon::config::Config;

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
    match &config.state {
        Some(folder) if folder.as_os_str().is_empty() => Ok(None),
        Some(folder) => Ok(Some(folder.clone())),
        None => usual_folder(instance).map(Some),
    }
}

fn usual_folder(instance: &Instance) -> Result<PathBuf, StateError> {
    if *instance != Instance::named(instance.name())? {
        return Ok(instance.root().join("state"));
    }
    let base = service_folder().or_else(user_folder);
    Ok(base
        .ok_or(StateError::Nowhere)?
        .join(instance.name()))
}

fn service_folder() -> Option<PathBuf> {
    absolute("STATE_DIRECTORY")
}

fn user_folder() -> Option<PathBuf> {
    let state = absolute("XDG_STATE_HOME");
    let state = state.or_else(|| Some(absolute("HOME")?.join(".local/state")))?;
    Some(state.join("taut"))
}

/// A folder that the environment names by an absolute path.
fn absolute(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(std::env::var_os(name)?);
    path.is_absolute().then_some(path)
}
