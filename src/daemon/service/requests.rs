//! A request's way through the service: let in or refused, given to the workers, told of each
//! improvement, ended.

use std::sync::Arc;

use taut::store::{Missing, PreparedModel, Snapshot};
use taut_ipc::control::{Refusal, Story};
use taut_ipc::wire::{Code, RequestHeader, ResponseHeader};

use super::Service;
use super::admission::{Doorkeeper, stopping};
use super::client::Client;
use super::effect::{Effect, InOrder};
use super::event::{Answered, Asked as Arrival, Ticket, Way};
use super::job::{Asked, Job, StopCause};
use super::open_request::{Computing, OpenRequest, Stage};
use super::watch;
use crate::daemon::observe::recording::Answer;
use crate::daemon::observe::story::{Step, story};
use crate::daemon::translate::{self, Question, Reply};

impl Service {
    /// Lets a request in, or refuses it.
    pub(super) fn asked(&mut self, arrival: Arrival) {
        let Arrival {
            ticket,
            client,
            header,
            bytes,
            checked,
        } = arrival;
        self.metrics.received();
        let entered = self.clients.enter(client, bytes, self.now_ns);
        let story = Story {
            pid: client.pid,
            client: self.clients.name(client.id).to_owned(),
            ..story(&self.store, &header, self.now_ns)
        };
        self.stories.begin(ticket, story);
        let open = OpenRequest {
            client,
            header,
            bytes,
            is_hinted: false,
            was_proved: None,
            is_untold: false,
            stage: Stage::Idle,
        };
        if let Err(refusal) = entered {
            return self.refuse(ticket, &open, refusal);
        }
        match checked.and_then(|()| self.admit(&open)) {
            Ok(snapshot) => self.have_read(ticket, open, snapshot),
            Err(refusal) => self.turn_away(ticket, &open, refusal),
        }
    }

    /// What a request is computed with.
    pub(super) fn admit(&mut self, open: &OpenRequest) -> Result<Snapshot, Refusal> {
        watch::check(&open.header)?;
        let mut header = open.header;
        if open.is_again() {
            watch::follow(&mut header);
        }
        let now_ns = self.now_ns;
        let snapshot = self
            .doorkeeper(open.client, &header, open.is_again())
            .admit(&header, now_ns)?;
        self.check_warm(&snapshot, deadline_ns(&header))?;
        Ok(snapshot)
    }

    /// Refuses what cannot be made by then, and has it made for the next request.
    fn check_warm(&mut self, snapshot: &Snapshot, deadline_ns: Option<u64>) -> Result<(), Refusal> {
        let missing = snapshot.model.missing();
        match missing.zip(deadline_ns) {
            Some((missing, deadline_ns))
                if self.now_ns + missing.least_left_ns(self.now_ns) > deadline_ns =>
            {
                self.have_made(&snapshot.model);
                Err(self.loading(snapshot, &missing))
            }
            _ => Ok(()),
        }
    }

    fn loading(&self, snapshot: &Snapshot, missing: &Missing) -> Refusal {
        let scene = self.store.label(snapshot.scene_id);
        translate::loading(snapshot, scene.unwrap_or_default(), missing, self.now_ns)
    }

    fn doorkeeper(
        &mut self,
        client: Client,
        header: &RequestHeader,
        is_again: bool,
    ) -> Doorkeeper<'_> {
        let most_waiting = if is_again {
            // A watch that is in already is not turned away.
            usize::MAX
        } else {
            self.limits.queue
        };
        let deadline_ns = deadline_ns(header);
        Doorkeeper {
            store: &mut self.store,
            loading: self.loading.labels(),
            waiting: self.schedule.waiting(),
            most_waiting,
            wait_ns: self
                .schedule
                .wait_ns(client.id, header.priority, deadline_ns),
            is_draining: self.is_draining,
        }
    }

    /// Has the payload of a request copied out and checked.
    pub(super) fn have_read(&mut self, ticket: Ticket, mut open: OpenRequest, snapshot: Snapshot) {
        let snapshot = Box::new(snapshot);
        self.effects.push(Effect::Read {
            ticket,
            snapshot: snapshot.clone(),
            clearance_m: self.limits.clearance_m,
        });
        open.stage = Stage::Reading(self.now_ns, snapshot);
        self.open.insert(ticket, open);
    }

    /// Gives a request to the workers whose payload has been read.
    pub(super) fn read(&mut self, ticket: Ticket, read: Result<Question, Refusal>) {
        // Its client may be gone meanwhile.
        let Some(open) = self.open.remove(ticket) else {
            return;
        };
        match read.and_then(|question| self.job(ticket, &open, question)) {
            Ok(job) => self.begin(open, job),
            Err(refusal) => self.turn_away(ticket, &open, refusal),
        }
    }

    fn job(&self, ticket: Ticket, open: &OpenRequest, question: Question) -> Result<Job, Refusal> {
        let Stage::Reading(received_ns, snapshot) = &open.stage else {
            unreachable!("a payload is read once for each time that this is asked for")
        };
        if self.is_draining {
            return Err(stopping());
        }
        let header = &open.header;
        let job = Job {
            id: ticket,
            request_id: header.request_id,
            client: open.client,
            snapshot: (**snapshot).clone(),
            path: question.path,
            settings: question.settings,
            timing: question.timing,
            deadline_ns: deadline_ns(header),
            received_ns: *received_ns,
            priority: header.priority,
            stop: Arc::default(),
            asked: self.as_people_call_it(open),
        };
        self.poison.check(|| job.content())?;
        Ok(job)
    }

    fn as_people_call_it(&self, open: &OpenRequest) -> Asked {
        if !self.shows {
            return Asked::default();
        }
        let label = |id| {
            let label = self.store.label(id);
            label.unwrap_or_default().to_owned()
        };
        Asked {
            robot: label(open.header.robot_id),
            scene: label(open.header.scene_id),
            pid: open.client.pid,
        }
    }

    /// Gives a request's job to the workers.
    fn begin(&mut self, mut open: OpenRequest, job: Job) {
        let client = self.clients.name(open.client.id);
        tracing::debug!(request = job.request_id, job = job.id, client, "taken");
        self.tell_let_in(&job);
        let question = self.recorder.asked(&job);
        open.stage = Stage::Computing(Computing::new(&job, question));
        let is_hinted = open.is_hinted;
        let ticket = job.id;
        self.open.insert(ticket, open);
        self.wait_for_model(&job);
        self.schedule.push(job, self.now_ns);
        if is_hinted {
            self.finish_early(ticket);
        }
    }

    fn tell_let_in(&mut self, job: &Job) {
        let version = job.snapshot.scene_version;
        let waiting = self.schedule.waiting();
        self.stories
            .let_in(job.id, self.now_ns, version, waiting);
        let constraints = job.settings.constraints.names();
        if !constraints.is_empty() {
            self.stories
                .tell(job.id, self.now_ns, Step::MustKeep(constraints));
        }
    }

    /// Has the model of a job made, where it is not.
    fn wait_for_model(&mut self, job: &Job) {
        let model = &job.snapshot.model;
        if !model.is_ready() {
            self.stories
                .tell(job.id, self.now_ns, Step::WaitsForModel);
            self.have_made(model);
        }
    }

    /// Has a model made ahead of its requests, unless somebody does.
    pub(super) fn have_made(&mut self, model: &Arc<PreparedModel>) {
        if model.claim() {
            self.in_order(InOrder::Prepare(model.clone()));
        }
    }

    /// Refuses a request that is on its client's account.
    pub(super) fn turn_away(&mut self, ticket: Ticket, open: &OpenRequest, refusal: Refusal) {
        self.clients.left(open.client.id, open.bytes);
        self.refuse(ticket, open, refusal);
    }

    pub(super) fn refuse(&mut self, ticket: Ticket, open: &OpenRequest, refusal: Refusal) {
        let request = open.header.request_id;
        tracing::info!(request, code = refusal.code, "refused: {}", refusal.message);
        self.metrics.ended(refusal.code);
        self.clients.refused(open.client.id);
        self.stories.end(
            ticket,
            self.now_ns,
            refusal.code,
            Step::Refused(refusal.message.clone()),
        );
        self.effects
            .push(Effect::Refuse(ticket, refusal));
    }

    /// Tells a client of a shorter path.
    pub(super) fn improved(&mut self, ticket: Ticket, mut header: Box<ResponseHeader>) {
        let Some(computing) = self.open.computing(ticket) else {
            return;
        };
        computing.stamp(&mut header, &self.store, self.now_ns);
        self.stories
            .tell(ticket, self.now_ns, Step::Shorter(header.clone()));
        self.effects
            .push(Effect::Improve(ticket, header));
    }

    /// A job asks whether it is to make room.
    pub(super) fn may_pause(&mut self, ticket: Ticket) {
        if self.schedule.makes_room(ticket, self.now_ns) {
            self.effects.push(Effect::Pause(ticket));
        }
    }

    /// A job is done.
    pub(super) fn answered(&mut self, answered: Answered) {
        let turn = self
            .schedule
            .finish(answered.ticket, self.now_ns);
        self.note_crash(answered.crashed);
        self.metrics.timed(&answered.reply.header);
        self.note_pauses(answered.ticket, turn.map_or(0, |turn| turn.pauses));
        self.note_answer(&answered);
        if let Some(open) = self.close_request(answered.ticket) {
            self.reply(answered.ticket, open, answered.reply);
        }
    }

    fn note_crash(&mut self, crashed: Option<u64>) {
        if let Some(content) = crashed {
            self.metrics.panicked();
            self.poison.crashed(content);
        }
    }

    fn note_pauses(&mut self, ticket: Ticket, pauses: u32) {
        if pauses > 0 && self.open.get(ticket).is_some() {
            self.metrics.paused(pauses);
            self.stories
                .tell(ticket, self.now_ns, Step::Paused(pauses));
        }
    }

    /// Enters what a job has had, where its client still waits.
    fn note_answer(&mut self, answered: &Answered) {
        let Some(open) = self.open.get(answered.ticket) else {
            return;
        };
        let reply = &answered.reply;
        self.clients
            .computed(open.client.id, reply.header.compute_ns);
        if let Some(computing) = open.computing() {
            self.recorder
                .answered(&computing.question, Answer::new(reply, answered.way));
        }
    }

    /// Takes a request out of those that are open.
    fn close_request(&mut self, ticket: Ticket) -> Option<OpenRequest> {
        let open = self.open.remove(ticket)?;
        if !open.is_watching() {
            self.clients.left(open.client.id, open.bytes);
        }
        Some(open)
    }

    fn reply(&mut self, ticket: Ticket, open: OpenRequest, reply: Reply) {
        if open.is_watch() {
            self.watched(ticket, open, reply);
        } else {
            self.send_final(ticket, &open, reply);
        }
    }

    pub(super) fn send_final(&mut self, ticket: Ticket, open: &OpenRequest, mut reply: Reply) {
        let Some(computing) = open.computing() else {
            return;
        };
        if reply.header.scene_version != 0 {
            computing.stamp(&mut reply.header, &self.store, self.now_ns);
        }
        let latency_ns = self
            .now_ns
            .saturating_sub(computing.received_ns);
        self.count_answered(ticket, open.client, latency_ns, &reply.header);
        tracing::debug!(
            request = open.header.request_id,
            code = reply.header.code,
            compute_ns = reply.header.compute_ns,
            "answered"
        );
        self.effects
            .push(Effect::Answer(ticket, Box::new(reply)));
    }

    fn count_answered(
        &mut self,
        ticket: Ticket,
        client: Client,
        latency_ns: u64,
        header: &ResponseHeader,
    ) {
        self.metrics.ended(header.code);
        self.metrics.answered_after(latency_ns);
        self.clients
            .answered(client.id, header, latency_ns, self.now_ns);
        self.stories.end(
            ticket,
            self.now_ns,
            header.code,
            Step::Answered(Box::new(*header)),
        );
    }

    /// Ends a request whose client is gone.
    pub(super) fn gone(&mut self, ticket: Ticket) {
        let Some(open) = self.close_request(ticket) else {
            return;
        };
        let job = open.computing().cloned();
        if let Some(job) = job {
            // Dropping the request frees the client's place at once; the worker ends on its own.
            self.stop(ticket, &job, StopCause::Cancelled);
            self.schedule.remove(ticket, self.now_ns);
            self.recorder.abandoned(&job.question);
        }
        self.count_cancelled(ticket, &open);
        self.effects.push(Effect::Drop(ticket));
        tracing::debug!(request = open.header.request_id, "cancelled");
    }

    fn count_cancelled(&mut self, ticket: Ticket, open: &OpenRequest) {
        self.metrics.cancelled();
        if !open.is_watching() {
            self.clients.cancelled(open.client.id);
        }
        let dropped = Step::Dropped(open.is_watching());
        self.stories
            .end(ticket, self.now_ns, Code::Preempted.into(), dropped);
    }

    /// Ends a request early whose client wants the best so far.
    pub(super) fn hinted(&mut self, ticket: Ticket) {
        let Some(open) = self.open.get_mut(ticket) else {
            return;
        };
        open.is_hinted = true;
        if open.is_watching() {
            self.end_watch(ticket, "the client wants no more");
        } else {
            self.finish_early(ticket);
        }
    }

    fn finish_early(&mut self, ticket: Ticket) {
        let Some(computing) = self.open.computing(ticket).cloned() else {
            return;
        };
        match self.schedule.remove(ticket, self.now_ns) {
            Some(job) => self.answer_untouched(&job, StopCause::FinishedEarly),
            None => self.stop(ticket, &computing, StopCause::FinishedEarly),
        }
    }

    /// Asks a job to end, also one that has made room.
    pub(super) fn stop(&mut self, ticket: Ticket, job: &Computing, cause: StopCause) {
        if job.stop.set(cause) && self.schedule.is_paused(ticket) {
            self.effects.push(Effect::Look(ticket));
        }
    }

    /// Nothing waits past its deadline.
    pub(super) fn end_expired(&mut self) {
        for job in self.schedule.take_expired(self.now_ns) {
            self.answer_untouched(&job, StopCause::Deadline);
        }
    }

    pub(super) fn answer_untouched(&mut self, job: &Job, cause: StopCause) {
        let mut reply = self.untouched(job, cause);
        reply.header.queue_ns = self.now_ns.saturating_sub(job.received_ns);
        if let Some(open) = self.close_request(job.id) {
            if let Some(computing) = open.computing() {
                let answer = Answer::new(&reply, Way::Untouched);
                self.recorder
                    .answered(&computing.question, answer);
            }
            self.send_final(job.id, &open, reply);
        }
    }

    /// What the client of a job hears that was not begun.
    fn untouched(&self, job: &Job, cause: StopCause) -> Reply {
        let snapshot = &job.snapshot;
        match (cause, snapshot.model.missing()) {
            (StopCause::Deadline, Some(missing)) => {
                translate::refused(self.loading(snapshot, &missing))
            }
            (StopCause::Deadline, None) => translate::expired(snapshot, &job.path),
            (cause, _) => translate::preempted(snapshot, &job.path, cause),
        }
    }
}

fn deadline_ns(header: &RequestHeader) -> Option<u64> {
    Some(header.deadline_ns).filter(|deadline_ns| *deadline_ns != 0)
}
