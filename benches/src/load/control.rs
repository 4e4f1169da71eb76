//! Control messages to the daemon under test.

use std::time::Duration;

use taut_ipc::Client;
use taut_ipc::client::retry;
use taut_ipc::control::{
    ControlReply, ControlRequest, Listing, RobotDescription, SceneSummary, Stats,
};

use crate::error::Error;

/// How long a message may take: large meshes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);
/// How long a message is tried again after its daemon died: a supervised one is back long before.
const RECOVERY: Duration = Duration::from_secs(5);

/// Sends a message, to the next daemon if the first dies; a refusal is an error here.
pub(super) fn control(client: &Client, message: &ControlRequest) -> Result<ControlReply, Error> {
    match retry(RECOVERY, || client.control(message, PATIENCE))? {
        ControlReply::Refused(refusal) => Err(refusal.into()),
        reply => Ok(reply),
    }
}

/// A reply of another kind than the message asks for: daemon and command of different releases.
pub(super) fn unexpected(reply: &ControlReply) -> Error {
    Error::Usage(format!(
        "the daemon answers {reply:?}; use taut-bench and taut of the same release"
    ))
}

/// The robots and scenes that are loaded.
pub(super) fn listing(client: &Client) -> Result<Listing, Error> {
    match control(client, &ControlRequest::List)? {
        ControlReply::Listing(listing) => Ok(listing),
        other => Err(unexpected(&other)),
    }
}

/// The robot that a message asks for.
pub(super) fn robot(client: &Client, message: &ControlRequest) -> Result<RobotDescription, Error> {
    match control(client, message)? {
        ControlReply::Robot(robot) => Ok(*robot),
        other => Err(unexpected(&other)),
    }
}

/// The scene that a message asks for.
pub(super) fn scene(client: &Client, message: &ControlRequest) -> Result<SceneSummary, Error> {
    match control(client, message)? {
        ControlReply::Scene(scene) => Ok(scene),
        other => Err(unexpected(&other)),
    }
}

/// One of the daemon's numbers; 0 where it has none of that name.
pub(super) fn number(client: &Client, name: &str) -> Result<f64, Error> {
    Ok(stats(client)?
        .numbers
        .get(name)
        .copied()
        .unwrap_or(0.0))
}

fn stats(client: &Client) -> Result<Stats, Error> {
    match control(client, &ControlRequest::Stats)? {
        ControlReply::Stats(stats) => Ok(stats),
        other => Err(unexpected(&other)),
    }
}
