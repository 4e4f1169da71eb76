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
    let refuse = |text| Err(Refusal::new(Code::MalformedRequest, text));
    if header.flags & RequestFlags::WATCH == 0 {
        Ok(())
    } else if header.mode != u32::from(Mode::Check) {
        refuse(wrong_mode(header.mode))
    } else if header.deadline_ns != 0 {
        refuse(no_deadline(header.deadline_ns))
    } else {
        Ok(())
    }
}

fn wrong_mode(mode: u32) -> String {
    let check = u32::from(Mode::Check);
    format!("mode {mode} with the flag watch; valid: {check}, check")
}

fn no_deadline(deadline_ns: u64) -> String {
    format!(
        "deadline_ns {deadline_ns} with the flag watch, which ends when it is dropped; valid: 0"
    )
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
        for (number, watch) in self.watches.take_about(label_id) {
            self.recheck(number, watch);
        }
    }

    fn recheck(&mut self, number: u64, watch: Watch) {
        let Watch { request, is_proved } = watch;
        let client = request.client_id();
        let server = &self.server;
        let met = || server.client_pid(client);
        self.clients
            .enter_again(client, met, request.payload().len(), monotonic_ns());
        let taken = self.enqueue(number, request, Some(is_proved));
        self.refuse_unless(number, taken);
    }

    /// A watched path has been checked: tells its client if the verdict is another one, and watches
    /// on.
    pub(super) fn watched(&mut self, number: u64, mut open: OpenRequest, reply: Reply) {
        // Without a path, the reply says why the check cannot be made, now or later.
        if self.is_draining || open.request.has_disconnect_hint() || reply.header.waypoints == 0 {
            return self.send_final(number, open, reply);
        }
        self.stories
            .tell(number, || checked(&open, &reply));
        let is_proved = reply.header.flags & ResponseFlags::PROVED != 0;
        let told =
            open.was_proved == Some(is_proved) || self.tell_watch(&mut open, reply, is_proved);
        // What could not be told is told after the next check.
        self.watch_on(number, open, if told { is_proved } else { !is_proved });
    }

    /// Waits for the next change, or checks again where the scene has changed in between.
    fn watch_on(&mut self, number: u64, open: OpenRequest, is_proved: bool) {
        let is_newest = self.store.scene_version(open.scene_id) == Some(open.scene_version);
        let watch = Watch {
            request: open.request,
            is_proved,
        };
        if is_newest {
            self.watches.insert(number, watch);
        } else {
            self.recheck(number, watch);
        }
    }

    /// Sends a verdict; whether it was sent.
    fn tell_watch(&mut self, open: &mut OpenRequest, mut reply: Reply, is_proved: bool) -> bool {
        let was_proved = open.was_proved == Some(true);
        reply.header.status = Status::Progress.into();
        reply.header.flags |= superseded(&self.store, open);
        if was_proved {
            reply.header.code = Code::InvalidatedByEnvironmentChange.into();
        }
        let was_sent = send_verdict(open, &reply);
        if was_sent && was_proved && !is_proved {
            self.publish_unsafe(open, &reply);
        }
        was_sent
    }

    /// Tells everybody who listens that a watched path became unsafe.
    fn publish_unsafe(&self, open: &OpenRequest, reply: &Reply) {
        let event = unsafe_event(open, reply);
        if let Err(error) = self.server.publish_scene_event(&event) {
            tracing::warn!(
                request = event.subscription,
                "that a watched path became unsafe was not published: {error}"
            );
        }
    }

    /// Ends the watches whose client is gone, or wants no more.
    pub(super) fn end_abandoned_watches(&mut self) {
        for (number, _) in self.watches.take_abandoned() {
            self.metrics.cancelled();
            self.stories
                .end(number, Code::Preempted.into(), || {
                    "the client dropped the watch or is gone".to_owned()
                });
        }
        let ended = self.watches.take_ended();
        self.end(ended, "the client wants no more");
    }

    /// Ends all that wait.
    pub(super) fn end_watches(&mut self) {
        let watches = self.watches.take_all();
        self.end(
            watches,
            "the daemon is stopping; send again to the next one",
        );
    }

    fn end(&mut self, watches: Vec<(u64, Watch)>, why: &str) {
        for (number, watch) in watches {
            self.refuse(number, watch.request, &Refusal::new(Code::Preempted, why));
        }
    }
}

/// What the story of a watch says of a check.
fn checked(open: &OpenRequest, reply: &Reply) -> String {
    let version = open.scene_version;
    let ending = story::ending(&reply.header);
    format!("watched: in version {version} {ending}")
}

/// Sends a verdict to its client; whether it was sent.
fn send_verdict(open: &mut OpenRequest, reply: &Reply) -> bool {
    let request = open.request.header().request_id;
    tracing::debug!(request, code = reply.header.code, "a watched path");
    let sent = open.request.send(&reply.header, &reply.body());
    if let Err(error) = &sent {
        tracing::warn!(request, "the verdict of a watch was not sent: {error}");
    }
    sent.is_ok()
}

fn unsafe_event(open: &OpenRequest, reply: &Reply) -> SceneEvent {
    SceneEvent {
        kind: SceneEventKind::PathUnsafe.into(),
        scene_id: open.scene_id,
        scene_hash: reply.header.scene_hash,
        scene_version: reply.header.scene_version,
        subscription: open.request.header().request_id,
        segment: reply
            .body()
            .refusal
            .map_or(0, |refusal| refusal.segment),
        ..SceneEvent::default()
    }
}
