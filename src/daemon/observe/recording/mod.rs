//! Recorded runs: requests with their robots and scenes and the answers they got, so that the same
//! answers can be computed again elsewhere, to the last bit (`taut record`, `taut replay`,
//! `taut why --bundle`).
//!
//! The service only hands over what it holds anyway, all of it shared; a thread of its own writes. What would have to wait because the disk is slow is left out and counted. The last
//! answers are remembered for a bundle.

mod counts;
mod read;
mod record;
mod recorder;
mod replay;
#[cfg(test)]
mod tests;
mod write;
mod writing;

use std::sync::Arc;

use taut::optimize::Settings;
use taut::path::Path;
use taut::robot::RobotModel;
use taut::scene::Scene;
use taut::translate::Timing;
use taut_ipc::limits::WIRE_VERSION;
use taut_ipc::wire::{ResponseBody, ResponseHeader};

pub(crate) use counts::Counts;
pub use read::{Recorded, Recording, RecordingError};
pub(crate) use recorder::{Line, Recorder};
pub use replay::{Replay, Verdict};
pub(crate) use writing::start;

use crate::daemon::service::event::Way;
use crate::daemon::service::job::Job;
use crate::daemon::translate::Reply;

/// A request as a worker gets it, without the model that it is computed with.
pub(crate) struct Question {
    /// Its number in the daemon.
    pub number: u64,
    /// Its client's id of it.
    pub request_id: u64,
    pub client: u128,
    pub received_ns: u64,
    pub deadline_ns: Option<u64>,
    pub priority: u32,
    pub robot: Arc<RobotModel>,
    pub scene: Arc<Scene>,
    pub scene_id: u64,
    pub scene_version: u64,
    pub settings: Arc<Settings>,
    pub timing: Option<Arc<Timing>>,
    pub path: Arc<Path>,
    /// Whether it goes to the recording that runs.
    is_recorded: bool,
}

/// What its client was told.
pub(crate) struct Answer {
    pub reply: Reply,
    pub way: Way,
}

impl Answer {
    pub(crate) fn new(reply: &Reply, way: Way) -> Self {
        Self {
            reply: reply.clone(),
            way,
        }
    }

    /// Header and sections, as on the wire; one that is too large for the wire comes without
    /// sections, as nobody got them.
    fn encoded(&self) -> (ResponseHeader, Vec<u8>) {
        let mut header = self.reply.header;
        header.wire_version = WIRE_VERSION;
        header.header_len = size_of::<ResponseHeader>() as u32;
        let mut body = self.reply.body();
        let bytes = laid_out(&mut body, &mut header);
        let mut payload = vec![0; bytes];
        body.write(&header, &mut payload);
        (header, payload)
    }
}

/// Lays sections out, and gives their bytes; of those that are too large there are none then.
fn laid_out(body: &mut ResponseBody<'_>, header: &mut ResponseHeader) -> usize {
    body.lay_out(header).unwrap_or_else(|_| {
        *body = ResponseBody::default();
        header.waypoints = 0;
        body.lay_out(header)
            .expect("nothing fits a payload")
    })
}

impl Question {
    fn of(job: &Job, is_recorded: bool) -> Self {
        Self {
            number: job.id,
            request_id: job.request_id,
            client: job.client.id,
            received_ns: job.received_ns,
            deadline_ns: job.deadline_ns,
            priority: job.priority,
            robot: job.snapshot.robot.clone(),
            scene: job.snapshot.scene.clone(),
            scene_id: job.snapshot.scene_id,
            scene_version: job.snapshot.scene_version,
            settings: job.settings.clone(),
            timing: job.timing.clone(),
            path: job.path.clone(),
            is_recorded,
        }
    }
}
