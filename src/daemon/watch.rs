//! Watches: paths that are checked again whenever their scene changes, or their robot.
//!
//! A watch is a request whose stream stays open. Each check is an ordinary job, which comes from
//! the request as the first one did, on its client's account; between two checks the request waits
//! here, costs no worker anything and is not counted. The client hears the first verdict, and each
//! one that differs from the last.

use taut_ipc::control::Refusal;
use taut_ipc::monotonic_ns;
use taut_ipc::server::IncomingRequest;
use taut_ipc::wire::{
    Code, Mode, RequestFlags, RequestHeader, ResponseFlags, SceneEvent, SceneEventKind, Status,
};

use super::event_loop::EventLoop;
use super::open_request::{OpenRequest, Watch, superseded};
use super::story;
use super::translate::Reply;

/// Whether a request is a watch.
pub(super) fn is_watch(request: &IncomingRequest) -> bool {
    request.header().flags & RequestFlags::WATCH != 0
}

/// Refuses a watch that would optimize or end by itself.
pub(super) fn check(header: &RequestHeader) -> Result<(), Refusal> {
    if header.flags & RequestFlags::WATCH == 0 {
        return Ok(());
    }
    let text = if header.mode != u32::from(Mode::Check) {
        format!(
            "mode {} with the flag watch; valid: {}, check",
            header.mode,
            u32::from(Mode::Check)
        )
    } else if header.deadline_ns != 0 {
        format!(
            "deadline_ns {} with the flag watch, which ends when it is dropped; valid: 0",
            header.deadline_ns
        )
    } else {
        return Ok(());
    };
    Err(Refusal::new(Code::MalformedRequest, text))
}

/// After the first check, a watch is about the newest version, whatever its client expected at
/// first.
pub(super) fn follow(header: &mut RequestHeader) {
    header.scene_hash = 0;
    header.scene_version = 0;
}

impl EventLoop {
    /// Checks the paths again that are watched in this scene or with this robot. Where it is gone,
    /// they end.
    pub(super) fn recheck_watches(&mut self, label_id: u64) {
        let about = |watch: &Watch| {
            [
                watch.request.header().scene_id,
                watch.request.header().robot_id,
            ]
            .contains(&label_id)
        };
        let about: Vec<u64> = self
            .watches
            .iter()
            .filter(|(_, watch)| about(watch))
            .map(|(number, _)| *number)
            .collect();
        for number in about {
            if let Some(watch) = self.watches.remove(&number) {
                self.recheck(number, watch);
            }
        }
    }

    fn recheck(&mut self, number: u64, watch: Watch) {
        let Watch { request, is_proved } = watch;
        let client = request.client_id();
        let bytes = request.payload().len();
        let server = &self.server;
        self.clients
            .enter_again(client, || server.client_pid(client), bytes, monotonic_ns());
        if let Err((request, refusal)) = self.enqueue(number, request, Some(is_proved)) {
            self.refuse(number, *request, &refusal);
        }
    }

    /// A watched path has been checked: tells its client if the verdict is another one, and watches
    /// on.
    pub(super) fn watched(&mut self, number: u64, mut open: OpenRequest, reply: Reply) {
        // Without a path, the reply says why the check cannot be made, now or later.
        if self.is_draining || open.request.has_disconnect_hint() || reply.header.waypoints == 0 {
            return self.send_final(number, open, reply);
        }
        let is_proved = reply.header.flags & ResponseFlags::PROVED != 0;
        let version = open.scene_version;
        self.stories.tell(number, || {
            format!(
                "watched: in version {version} {}",
                story::ending(&reply.header)
            )
        });
        let told =
            open.was_proved == Some(is_proved) || self.tell_watch(&mut open, reply, is_proved);
        // What could not be told is told after the next check.
        let watch = Watch {
            request: open.request,
            is_proved: if told { is_proved } else { !is_proved },
        };
        if self.store.scene_version(open.scene_id) == Some(version) {
            self.watches.insert(number, watch);
        } else {
            self.recheck(number, watch);
        }
    }

    /// Sends a verdict; whether it was sent.
    fn tell_watch(&mut self, open: &mut OpenRequest, mut reply: Reply, is_proved: bool) -> bool {
        let request = open.request.header().request_id;
        reply.header.status = Status::Progress.into();
        reply.header.flags |= superseded(&self.store, open);
        if open.was_proved == Some(true) {
            reply.header.code = Code::InvalidatedByEnvironmentChange.into();
        }
        tracing::debug!(request, code = reply.header.code, "a watched path");
        if let Err(error) = open.request.send(&reply.header, &reply.body()) {
            tracing::warn!(request, "the verdict of a watch was not sent: {error}");
            return false;
        }
        if open.was_proved == Some(true) && !is_proved {
            let event = SceneEvent {
                kind: SceneEventKind::PathUnsafe.into(),
                scene_id: open.scene_id,
                scene_hash: reply.header.scene_hash,
                scene_version: reply.header.scene_version,
                subscription: request,
                segment: reply.body().refusal.map_or(0, |refusal| refusal.segment),
                ..SceneEvent::default()
            };
            if let Err(error) = self.server.publish_scene_event(&event) {
                tracing::warn!(
                    request,
                    "that a watched path became unsafe was not published: {error}"
                );
            }
        }
        true
    }

    /// Ends the watches whose client is gone, or wants no more.
    pub(super) fn end_abandoned_watches(&mut self) {
        let gone: Vec<u64> = self
            .watches
            .extract_if(.., |_, watch| !watch.request.is_connected())
            .map(|(number, _)| number)
            .collect();
        for number in gone {
            self.metrics.cancelled();
            self.stories.end(number, Code::Preempted.into(), || {
                "the client dropped the watch or is gone".to_owned()
            });
        }
        let ended: Vec<_> = self
            .watches
            .extract_if(.., |_, watch| watch.request.has_disconnect_hint())
            .collect();
        self.end(ended, "the client wants no more");
    }

    /// Ends all that wait.
    pub(super) fn end_watches(&mut self) {
        let watches = std::mem::take(&mut self.watches);
        self.end(
            watches,
            "the daemon is stopping; send again to the next one",
        );
    }

    fn end(&mut self, watches: impl IntoIterator<Item = (u64, Watch)>, why: &str) {
        for (number, watch) in watches {
            self.refuse(number, watch.request, &Refusal::new(Code::Preempted, why));
        }
    }
}
