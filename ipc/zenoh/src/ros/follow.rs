//! MoveIt's scene: its changes as they are published, and the whole where one may be missing.

use super::node::{Ros, attached};
use super::refusal::Refusal;
use super::scenes::Scenes;
use crate::network::NetworkError;
use crate::stop::Stop;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use taut_ipc::wire::Code;
use taut_ros::cdr::decode;
use taut_ros::keys::Attachment;
use taut_ros::messages::moveit_msgs::{
    GetPlanningScene, GetPlanningSceneRequest, PlanningScene, PlanningSceneComponents,
};

const CHANGES: &str = "/monitored_planning_scene";
const WHOLE: &str = "/get_planning_scene";
/// All parts of a scene, a bit each.
const ALL: u32 = 0x3ff;
/// How often the whole is asked for, at most.
const AGAIN: Duration = Duration::from_secs(1);
/// How long a look for changes takes.
const LOOK: Duration = Duration::from_millis(50);
/// Changes that wait; where there are more, the whole is fetched.
const MOST: usize = 64;

/// A change as it came.
struct Published {
    bytes: Vec<u8>,
    attachment: Option<Attachment>,
}

/// Follows the scene on a thread of its own until it is to stop.
pub(super) fn start(
    ros: &Arc<Ros>,
    scenes: &Arc<Scenes>,
    stop: &Stop,
) -> Result<JoinHandle<()>, NetworkError> {
    let (inbox, changes) = sync_channel(MOST);
    let is_missed = Arc::new(AtomicBool::new(false));
    let missed = is_missed.clone();
    ros.subscribe::<PlanningScene>(CHANGES, move |sample| {
        let published = Published {
            bytes: sample.payload().to_bytes().into_owned(),
            attachment: attached(sample.attachment()),
        };
        put(&inbox, published, &missed);
    })?;
    ros.declare_client::<GetPlanningScene>(WHOLE)?;
    scenes.set_behind(Some(format!(
        "the scene is not MoveIt's yet: {WHOLE} has not answered"
    )));
    let follower = Follower {
        ros: ros.clone(),
        scenes: scenes.clone(),
        changes,
        is_missed,
        last: None,
        asked: None,
        is_whole: false,
    };
    let stop = stop.clone();
    Ok(std::thread::spawn(move || follower.run(&stop)))
}

/// Never waits: the network's thread reads for others too.
fn put(inbox: &SyncSender<Published>, published: Published, missed: &AtomicBool) {
    if let Err(TrySendError::Full(_)) = inbox.try_send(published) {
        missed.store(true, Ordering::SeqCst);
    }
}

struct Follower {
    ros: Arc<Ros>,
    scenes: Arc<Scenes>,
    changes: Receiver<Published>,
    is_missed: Arc<AtomicBool>,
    /// Of the last change.
    last: Option<Attachment>,
    /// When the whole was asked for last.
    asked: Option<Instant>,
    is_whole: bool,
}

impl Follower {
    fn run(mut self, stop: &Stop) {
        while !stop.is_asked() {
            if self.is_missed.swap(false, Ordering::SeqCst) {
                self.lost("changes came faster than they could be made");
            }
            if !self.is_whole
                && self
                    .asked
                    .is_none_or(|asked| asked.elapsed() >= AGAIN)
            {
                self.asked = Some(Instant::now());
                self.fetch();
            }
            if let Ok(published) = self.changes.recv_timeout(LOOK) {
                self.take(&published);
            }
        }
    }

    /// What is published meanwhile is made on top: each change says where things are, so that those
    /// which the whole has already end where it has them.
    fn fetch(&mut self) {
        let components = PlanningSceneComponents { components: ALL };
        let request = GetPlanningSceneRequest { components };
        let reply = self
            .ros
            .call::<GetPlanningScene>(WHOLE, &request, AGAIN);
        match reply.map(|reply| self.scenes.take(&reply.scene)) {
            Ok(Ok(_)) => self.found(),
            Ok(Err(refusal)) => self.lost(&format!("the whole is refused: {refusal}")),
            Err(reason) => self.lost(&reason),
        }
    }

    fn take(&mut self, published: &Published) {
        let gap = self.has_gap(published.attachment);
        let scene = decode::<PlanningScene>(&published.bytes)
            .map_err(|error| Refusal::new(Code::MalformedRequest, error.to_string()));
        let is_whole = scene.as_ref().is_ok_and(|scene| !scene.is_diff);
        match scene.and_then(|scene| self.scenes.take(&scene)) {
            Ok(_) if is_whole => self.found(),
            Ok(_) if gap => self.lost("a change of it was lost"),
            Ok(_) => {}
            Err(refusal) => self.lost(&format!("a change of it is refused: {refusal}")),
        }
    }

    /// Whether changes before this one are missing, or another node publishes by now.
    fn has_gap(&mut self, attachment: Option<Attachment>) -> bool {
        let last = std::mem::replace(&mut self.last, attachment);
        match (last, attachment) {
            (Some(last), Some(now)) => last.gid != now.gid || last.sequence + 1 != now.sequence,
            _ => false,
        }
    }

    fn found(&mut self) {
        self.is_whole = true;
        self.scenes.set_behind(None);
    }

    fn lost(&mut self, why: &str) {
        self.is_whole = false;
        let why = format!("the scene is not MoveIt's: {why}");
        self.scenes.set_behind(Some(why));
    }
}
