//! Control messages to gateways.

use super::shared::{Caller, Client};
use crate::call::Gateway;
use crate::names;
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::time::{Duration, Instant};
use taut_ipc::content::{Parcel, Progress};
use taut_ipc::control::{ControlReply, ControlRequest, Refusal, Stats, decode, encode};
use taut_ipc::wire::{Code, Envelope, EnvelopeKind, label_id};
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

/// The gateway that was asked is gone, or does not answer.
pub(super) struct Gone;

impl Caller {
    /// Sends a message to the best gateway, where scenes have their home, and gives its reply; what it
    /// names of this machine's files goes along. Robots go to every gateway that is there.
    pub fn control(
        self: &Arc<Self>,
        client: &Arc<Client>,
        message: &ControlRequest,
    ) -> ControlReply {
        let mut parcel = Parcel::of(message.clone());
        let Some((best, mut reply)) = self.at_best(client, &mut parcel) else {
            return self.lost();
        };
        match &mut reply {
            ControlReply::Robot(robot) => self.loaded(client, &best, robot.robot_id, parcel),
            ControlReply::Done => self.unloaded(client, &best, message),
            ControlReply::Scene(scene) => {
                self.seen
                    .note(scene.scene_id, scene.version, scene.scene_hash);
                self.loaded(client, &best, scene.scene_id, parcel);
            }
            ControlReply::Stats(stats) => self.add_counts(stats),
            _ => {}
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
        let mut parcel = Parcel::of(message.clone());
        self.converse(client, gateway, &mut parcel).ok()
    }

    /// With the best that is there; where that goes, with the next.
    fn at_best(
        self: &Arc<Self>,
        client: &Arc<Client>,
        parcel: &mut Parcel,
    ) -> Option<(Gateway, ControlReply)> {
        let end = Instant::now() + RECOVERY;
        loop {
            if let Some(best) = self.best()
                && let Ok(reply) = self.converse(client, &best, parcel)
            {
                match self.has_brought(client, &best, parcel.message(), &reply) {
                    false => return Some((best, reply)),
                    // However long that took.
                    true => continue,
                }
            }
            if Instant::now() >= end {
                return None;
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn unloaded(&self, client: &Client, best: &Gateway, message: &ControlRequest) {
        match message {
            ControlRequest::UnloadScene { label } => {
                self.models.forget(label_id(label));
                self.seen.forget(label_id(label));
            }
            ControlRequest::UnloadRobot { label } => {
                self.models.forget(label_id(label));
                let live = self.live.now();
                for gateway in live.iter().filter(|gateway| *gateway != best) {
                    self.control_at(client, gateway, message);
                }
            }
            _ => {}
        }
    }

    fn add_counts(&self, stats: &mut Stats) {
        let (resent, late) = self.counts();
        let counts = [
            ("network_sent_again", resent),
            ("network_answered_twice", late),
        ];
        stats
            .numbers
            .extend(counts.map(|(name, count)| (name.to_owned(), count as f64)));
    }

    pub(super) fn converse(
        &self,
        client: &Client,
        gateway: &Gateway,
        parcel: &mut Parcel,
    ) -> Result<ControlReply, Gone> {
        let mut tell = |message: &ControlRequest| self.tell(client, gateway, message);
        let mut progress = |progress: Progress<'_>| {
            let Progress { file, sent, bytes } = progress;
            tracing::debug!("{}: {sent} of {bytes} bytes", file.display());
        };
        parcel.send(&mut tell, &mut progress)
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

    fn lost(&self) -> ControlReply {
        refused(Code::DaemonLost, self.live.nobody())
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

fn refused(code: Code, message: String) -> ControlReply {
    ControlReply::Refused(Refusal::new(code, message))
}
