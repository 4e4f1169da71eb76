//! Control messages to gateways.

use super::shared::{Caller, Client};
use crate::call::Gateway;
use crate::names;
use std::hash::{BuildHasher, RandomState};
use std::time::{Duration, Instant};
use taut_ipc::content::{Progress, carry};
use taut_ipc::control::{ControlReply, ControlRequest, Refusal, decode, encode};
use taut_ipc::wire::{Code, Envelope, EnvelopeKind};
use zenoh::Wait;
use zenoh::bytes::ZBytes;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::ConsolidationMode;

/// How long a reply is waited for: large meshes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);
/// How long gateways that are gone or do not answer are waited for.
const RECOVERY: Duration = Duration::from_secs(5);
/// Pause before a message is sent again.
const PAUSE: Duration = Duration::from_millis(50);

/// Which gateways get a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    /// The best.
    Best,
    /// All: whichever answers a request needs the robot.
    All,
}

/// The gateway that was asked is gone, or does not answer.
struct Gone;

impl Caller {
    /// Sends a message and gives its reply; what it names of this machine's files goes along. Robots
    /// are loaded at every gateway that is there; everything else is asked of the best, where scenes
    /// have their home.
    pub fn control(&self, client: &Client, message: &ControlRequest) -> ControlReply {
        let reply = self.at_best(client, message);
        if reach(message) == Reach::All && !matches!(reply, ControlReply::Refused(_)) {
            self.at_others(client, message);
        }
        if let ControlReply::Scene(scene) = &reply {
            self.seen
                .note(scene.scene_id, scene.version, scene.scene_hash);
        }
        reply
    }

    /// The same of one gateway; `None` where it does not answer.
    pub fn control_at(
        &self,
        client: &Client,
        gateway: &Gateway,
        message: &ControlRequest,
    ) -> Option<ControlReply> {
        self.converse(client, gateway, message).ok()
    }

    /// With the best that is there; where that goes, with the next.
    fn at_best(&self, client: &Client, message: &ControlRequest) -> ControlReply {
        let end = Instant::now() + RECOVERY;
        loop {
            let best = self.best();
            let reply = best.map(|gateway| self.converse(client, &gateway, message));
            if let Some(Ok(reply)) = reply {
                return reply;
            }
            if Instant::now() >= end {
                return lost();
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn at_others(&self, client: &Client, message: &ControlRequest) {
        for gateway in self.live.now().into_iter().skip(1) {
            let daemon = &*gateway.name;
            match self.converse(client, &gateway, message) {
                Ok(ControlReply::Refused(refusal)) => {
                    tracing::warn!(daemon, "refused there: {}", refusal.message);
                }
                Ok(_) => {}
                Err(Gone) => tracing::warn!(daemon, "no reply from there"),
            }
        }
    }

    fn converse(
        &self,
        client: &Client,
        gateway: &Gateway,
        message: &ControlRequest,
    ) -> Result<ControlReply, Gone> {
        let mut tell = |message: &ControlRequest| self.tell(client, gateway, message);
        let mut progress = |progress: Progress<'_>| {
            let Progress { file, sent, bytes } = progress;
            tracing::debug!("{}: {sent} of {bytes} bytes", file.display());
        };
        carry(message.clone(), &mut tell, &mut progress)
    }

    /// One message to one gateway, again and again while that is there: under one number it is done
    /// once.
    fn tell(
        &self,
        client: &Client,
        gateway: &Gateway,
        message: &ControlRequest,
    ) -> Result<ControlReply, Gone> {
        let bytes = match encode(message) {
            Ok(bytes) => ZBytes::from(bytes),
            Err(error) => return Ok(refused(Code::ResourceExhausted, error.to_string())),
        };
        let request = RandomState::new().hash_one(0);
        let end = Instant::now() + RECOVERY;
        loop {
            if let Some(reply) = self.ask(client, gateway, request, &bytes) {
                return Ok(reply);
            }
            if Instant::now() >= end || !self.live.now().contains(gateway) {
                return Err(Gone);
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// The reply, if there is one.
    fn ask(
        &self,
        client: &Client,
        gateway: &Gateway,
        request: u64,
        bytes: &ZBytes,
    ) -> Option<ControlReply> {
        let envelope = Envelope {
            request,
            ..Envelope::default()
        };
        let replies = self
            .session
            .get(names::control(&gateway.name))
            .attachment(client.attachment(EnvelopeKind::Control, envelope))
            .payload(bytes.clone())
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .priority(Priority::DataHigh)
            .timeout(PATIENCE)
            .wait()
            .ok()?;
        while let Ok(reply) = replies.recv() {
            if let Ok(sample) = reply.result() {
                return Some(reply_of(&sample.payload().to_bytes()));
            }
        }
        None
    }
}

fn reply_of(bytes: &[u8]) -> ControlReply {
    decode(bytes).unwrap_or_else(|error| refused(Code::MalformedRequest, error.to_string()))
}

fn lost() -> ControlReply {
    let line = "no gateway answers; look with `taut-zenoh doctor`, and send again";
    refused(Code::DaemonLost, line.to_owned())
}

fn refused(code: Code, message: String) -> ControlReply {
    ControlReply::Refused(Refusal::new(code, message))
}

fn reach(message: &ControlRequest) -> Reach {
    match message {
        ControlRequest::LoadRobot { .. }
        | ControlRequest::UnloadRobot { .. }
        | ControlRequest::SelectVariables { .. } => Reach::All,
        _ => Reach::Best,
    }
}
