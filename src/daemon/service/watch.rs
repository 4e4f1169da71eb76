//! Watches: paths that are checked again whenever their scene changes, or their robot.
//!
//! A watch is a request whose stream stays open. Each check is an ordinary job, which comes from
//! the request as the first one did, on its client's account; between two checks the request waits,
//! costs no worker anything and is not counted. The client hears the first verdict, and each one
//! that differs from the last.

use taut_ipc::control::Refusal;
use taut_ipc::wire::{
    Code, Mode, RequestFlags, RequestHeader, ResponseFlags, SceneEvent, SceneEventKind, Status,
};

use super::Service;
use super::effect::InOrder;
use super::event::Ticket;
use super::open_request::{Computing, OpenRequest, Stage};
use crate::daemon::observe::story::Step;
use crate::daemon::translate::Reply;

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

impl Service {
    /// Checks the paths again that are watched in this scene or with this robot. Where it is gone,
    /// they end.
    pub(super) fn recheck_watches(&mut self, label_id: u64) {
        for ticket in self.open.watched_about(label_id) {
            if let Some(open) = self.open.remove(ticket) {
                self.recheck(ticket, open);
            }
        }
    }

    fn recheck(&mut self, ticket: Ticket, open: OpenRequest) {
        self.clients
            .enter_again(open.client, open.bytes, self.now_ns);
        match self.admit(&open) {
            Ok(snapshot) => self.have_read(ticket, open, snapshot),
            Err(refusal) => self.turn_away(ticket, &open, refusal),
        }
    }

    /// A watched path has been checked: tells its client if the verdict is another one, and watches
    /// on.
    pub(super) fn watched(&mut self, ticket: Ticket, mut open: OpenRequest, reply: Reply) {
        // Without a path, the reply says why the check cannot be made, now or later.
        if self.is_draining || open.is_hinted || reply.header.waypoints == 0 {
            return self.send_final(ticket, &open, reply);
        }
        let Some(computing) = open.computing().cloned() else {
            return;
        };
        let checked = Step::Checked(computing.scene_version, Box::new(reply.header));
        self.stories.tell(ticket, self.now_ns, checked);
        let is_proved = reply.header.flags & ResponseFlags::PROVED != 0;
        if open.was_proved != Some(is_proved) {
            self.tell_verdict(ticket, &open, &computing, reply);
        }
        open.was_proved = Some(is_proved);
        self.watch_on(ticket, open, &computing);
    }

    /// Waits for the next change, or checks again where the scene has changed in between.
    fn watch_on(&mut self, ticket: Ticket, mut open: OpenRequest, checked: &Computing) {
        open.stage = Stage::Idle;
        if checked.is_newest(&self.store) {
            self.open.insert(ticket, open);
        } else {
            self.recheck(ticket, open);
        }
    }

    /// Tells a client of another verdict, and everybody who listens that its path became unsafe.
    fn tell_verdict(
        &mut self,
        ticket: Ticket,
        open: &OpenRequest,
        checked: &Computing,
        mut reply: Reply,
    ) {
        let was_proved = open.was_proved == Some(true);
        reply.header.status = Status::Progress.into();
        reply.header.flags |= checked.superseded(&self.store);
        if was_proved {
            reply.header.code = Code::InvalidatedByEnvironmentChange.into();
        }
        let request = open.header.request_id;
        tracing::debug!(request, code = reply.header.code, "a watched path");
        let event = was_proved.then(|| unsafe_event(request, checked.scene_id, &reply));
        self.in_order(InOrder::Tell(ticket, Box::new(reply), event));
    }

    /// What could not be told is told after the next check.
    pub(super) fn not_told(&mut self, ticket: Ticket) {
        if let Some(open) = self.open.get_mut(ticket) {
            open.was_proved = open.was_proved.map(|is_proved| !is_proved);
        }
    }

    /// Ends all that wait.
    pub(super) fn end_watches(&mut self) {
        for ticket in self.open.watching() {
            self.end_watch(ticket, "the daemon is stopping; send again to the next one");
        }
    }

    /// Ends a watch between two checks.
    pub(super) fn end_watch(&mut self, ticket: Ticket, why: &str) {
        if let Some(open) = self.open.remove(ticket) {
            self.refuse(ticket, &open, Refusal::new(Code::Preempted, why));
        }
    }
}

fn unsafe_event(subscription: u64, scene_id: u64, reply: &Reply) -> SceneEvent {
    SceneEvent {
        kind: SceneEventKind::PathUnsafe.into(),
        scene_id,
        scene_hash: reply.header.scene_hash,
        scene_version: reply.header.scene_version,
        subscription,
        segment: reply
            .body()
            .refusal
            .map_or(0, |refusal| refusal.segment),
        ..SceneEvent::default()
    }
}
