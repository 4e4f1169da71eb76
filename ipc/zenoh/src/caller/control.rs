//! Control messages to gateways.

use super::{Caller, Client};
use crate::call::Gateway;
use crate::message::Refused;
use crate::names;
use std::hash::{BuildHasher, RandomState};
use std::time::{Duration, Instant};
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

impl Caller {
    /// Sends a message and gives its reply. Robots are loaded at every gateway that is there;
    /// everything else is asked of the best, where scenes have their home.
    pub fn control(&self, client: &Client, message: &ControlRequest) -> ControlReply {
        let bytes = match encode(message) {
            Ok(bytes) => bytes,
            Err(error) => {
                let code = Code::ResourceExhausted;
                return ControlReply::Refused(Refusal::new(code, error.to_string()));
            }
        };
        // Sent again under the same number it is done once.
        let request = RandomState::new().hash_one(0);
        let reply = self.at_best(client, request, &bytes);
        if reach(message) == Reach::All && !matches!(reply, ControlReply::Refused(_)) {
            self.at_others(client, request, &bytes);
        }
        self.note(&reply);
        reply
    }

    fn note(&self, reply: &ControlReply) {
        if let ControlReply::Scene(scene) = reply {
            self.seen
                .note(scene.scene_id, scene.version, scene.scene_hash);
        }
    }

    fn at_best(&self, client: &Client, request: u64, bytes: &[u8]) -> ControlReply {
        let end = Instant::now() + RECOVERY;
        loop {
            let gateway = self.best();
            let reply = gateway
                .as_ref()
                .and_then(|gateway| self.ask(client, gateway, request, bytes));
            if let Some(reply) = reply {
                return reply;
            }
            if Instant::now() >= end {
                return lost();
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn at_others(&self, client: &Client, request: u64, bytes: &[u8]) {
        for gateway in self.live.now().into_iter().skip(1) {
            let daemon = &*gateway.name;
            match self.ask(client, &gateway, request, bytes) {
                Some(ControlReply::Refused(refusal)) => {
                    tracing::warn!(daemon, "refused there: {}", refusal.message);
                }
                Some(_) => {}
                None => tracing::warn!(daemon, "no reply from there"),
            }
        }
    }

    /// The reply of one gateway; `None` where it is gone.
    fn ask(
        &self,
        client: &Client,
        gateway: &Gateway,
        request: u64,
        bytes: &[u8],
    ) -> Option<ControlReply> {
        let envelope = Envelope {
            request,
            ..Envelope::default()
        };
        let replies = self
            .session
            .get(names::control(&gateway.name))
            .attachment(client.attachment(EnvelopeKind::Control, envelope))
            .payload(ZBytes::from(bytes))
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
    decode(bytes).unwrap_or_else(|error| {
        ControlReply::Refused(Refusal::new(Code::MalformedRequest, error.to_string()))
    })
}

fn lost() -> ControlReply {
    let refused = Refused::new(
        Code::DaemonLost,
        "no gateway answers; look with `taut-zenoh doctor`, and send again",
    );
    ControlReply::Refused(Refusal::new(refused.code, refused.message))
}

fn reach(message: &ControlRequest) -> Reach {
    match message {
        ControlRequest::LoadRobot { .. }
        | ControlRequest::UnloadRobot { .. }
        | ControlRequest::SelectVariables { .. } => Reach::All,
        _ => Reach::Best,
    }
}
