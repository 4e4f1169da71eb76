//! Watches: paths that are checked again whenever their scene changes, or their robot.
//!
//! A watch is a request whose stream stays open. Each check is an ordinary job, which comes from
//! the request as the first one did, on its client's account; between two checks the request waits,
//! costs no worker anything and is not counted. The client hears the first verdict, and each one
//! that differs from the last; also that what sensors see has become older than it allows, which no
//! change tells.

use taut_ipc::control::Refusal;
use taut_ipc::wire::{
    Code, Mode, RequestFlags, RequestHeader, ResponseFlags, SceneEvent, SceneEventKind, Status,
};

use super::Service;
use super::effect::InOrder;
use super::event::Ticket;
use super::open_request::{Computing, OpenRequest, Stage};
use crate::daemon::observe::story::Step;
use crate::daemon::translate::{self, Reply};

/// When (ns) a client is told again that could not be told.
const RETELL_NS: u64 = 100_000_000;

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
            Err(refusal) if refusal.code == i32::from(Code::CloudTooOld) => {
                self.clients.left(open.client.id, open.bytes);
                self.too_old(ticket, open, refusal);
            }
            Err(refusal) => self.turn_away(ticket, &open, refusal),
        }
    }

    /// Nothing is known any more of what a watched path moves among, until the next frame.
    fn too_old(&mut self, ticket: Ticket, mut open: OpenRequest, refusal: Refusal) {
        let was_proved = open.was_proved.replace(false) == Some(true);
        if was_proved {
            let reply = self.in_progress(open.header.scene_id, refusal);
            let event = unsafe_event(open.header.request_id, open.header.scene_id, &reply);
            self.in_order(InOrder::Tell(ticket, Box::new(reply), Some(event)));
        }
        self.open.insert(ticket, open);
    }

    /// A refusal after which a watch goes on.
    fn in_progress(&self, scene_id: u64, refusal: Refusal) -> Reply {
        let mut reply = translate::refused(refusal);
        let header = &mut reply.header;
        header.status = Status::Progress.into();
        if let Some(entry) = self.store.scene_of(scene_id) {
            let seen = entry.scene.oldest_frame();
            header.scene_id = scene_id;
            header.scene_hash = entry.scene.hash();
            header.scene_version = entry.version;
            header.world_age_ns = seen.map_or(0, |(_, frame)| frame.age_ns(self.now_ns));
        }
        reply
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
            self.look_by(open.too_old_ns(&self.store));
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
        checked.stamp(&mut reply.header, &self.store, self.now_ns);
        if was_proved {
            reply.header.code = Code::InvalidatedByEnvironmentChange.into();
        }
        let request = open.header.request_id;
        tracing::debug!(request, code = reply.header.code, "a watched path");
        let event = was_proved.then(|| unsafe_event(request, checked.scene_id, &reply));
        self.in_order(InOrder::Tell(ticket, Box::new(reply), event));
    }

    /// What could not be told is told after the next check, which comes soon also where nothing
    /// changes.
    pub(super) fn not_told(&mut self, ticket: Ticket) {
        if let Some(open) = self.open.get_mut(ticket) {
            open.was_proved = open.was_proved.map(|is_proved| !is_proved);
            open.is_untold = true;
            self.look_by(self.now_ns + RETELL_NS);
        }
    }

    /// Has watches looked at by then.
    fn look_by(&mut self, by_ns: u64) {
        self.watches_ns = self.watches_ns.min(by_ns);
    }

    /// Checks the watches again whose clients are to be told of what no change of a scene tells.
    pub(super) fn look_at_watches(&mut self) {
        if self.now_ns < self.watches_ns {
            return;
        }
        self.watches_ns = u64::MAX;
        for ticket in self.open.watching() {
            let Some(open) = self.open.get_mut(ticket) else {
                continue;
            };
            let too_old_ns = open.too_old_ns(&self.store);
            let is_due = std::mem::take(&mut open.is_untold) || too_old_ns <= self.now_ns;
            match is_due
                .then(|| self.open.remove(ticket))
                .flatten()
            {
                Some(open) => self.recheck(ticket, open),
                None => self.look_by(too_old_ns),
            }
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
