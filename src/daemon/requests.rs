//! A request's way through the I/O thread: let in or refused, given to the workers, told of each
//! improvement, ended.

use std::sync::Arc;

use taut_ipc::control::Refusal;
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingRequest, SendError, ServerError};
use taut_ipc::wire::{Code, RequestHeader, RequestView, ResponseBody, ResponseHeader};

use super::admission::Doorkeeper;
use super::event::{Answered, Way};
use super::event_loop::{EventLoop, ROUND};
use super::job::{Asked, Job, StopCause, StopFlag};
use super::mailbox::Progress;
use super::open_request::{OpenRequest, TurnedAway, superseded};
use super::recording::Answer;
use super::story::{self, story};
use super::translate::{self, Reply};
use super::watch;

impl EventLoop {
    /// Takes requests; tells whether more may be waiting.
    pub(super) fn receive_requests(&mut self) -> Result<bool, ServerError> {
        for _ in 0..ROUND {
            match self.server.receive()? {
                Some(request) => self.received(request),
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn received(&mut self, request: IncomingRequest) {
        self.metrics.received();
        let number = self.next_number();
        let taken = self.take(number, request);
        self.refuse_unless(number, taken);
    }

    /// Tells the client of a request that was turned away.
    pub(super) fn refuse_unless(&mut self, number: u64, taken: Result<(), TurnedAway>) {
        if let Err(TurnedAway { request, refusal }) = taken {
            self.refuse(number, *request, &refusal);
        }
    }

    /// Lets a request in and gives it to the workers.
    fn take(&mut self, number: u64, request: IncomingRequest) -> Result<(), TurnedAway> {
        let now_ns = monotonic_ns();
        let entered = self.enter(&request, now_ns);
        let pid = self.clients.pid(request.client_id());
        let story = story(&self.store, &request, pid, now_ns);
        self.stories.begin(number, story);
        match entered {
            Ok(()) => self.enqueue(number, request, None),
            Err(refusal) => Err(TurnedAway::new(request, refusal)),
        }
    }

    /// Counts a request on its client's account.
    fn enter(&mut self, request: &IncomingRequest, now_ns: u64) -> Result<(), Refusal> {
        let client = request.client_id();
        let server = &self.server;
        let cleaning = &self.cleaning;
        let met = || {
            cleaning.look();
            server.client_pid(client)
        };
        let bytes = request.payload().len();
        self.clients.enter(client, met, bytes, now_ns)
    }

    /// Gives a request to the workers that is counted already; `was_proved` where it is a watch
    /// that was let in before.
    pub(super) fn enqueue(
        &mut self,
        number: u64,
        request: IncomingRequest,
        was_proved: Option<bool>,
    ) -> Result<(), TurnedAway> {
        match self.job(number, &request, was_proved.is_some()) {
            Ok(job) => self.begin(request, job, was_proved),
            Err(refusal) => {
                let bytes = request.payload().len();
                self.clients.left(request.client_id(), bytes);
                return Err(TurnedAway::new(request, refusal));
            }
        }
        Ok(())
    }

    /// Gives a request's job to the workers.
    fn begin(&mut self, request: IncomingRequest, job: Job, was_proved: Option<bool>) {
        tracing::debug!(request = job.request_id, job = job.id, "taken");
        self.tell_let_in(&job);
        let question = self.recorder.asked(&job);
        let open = OpenRequest::new(request, &job, question, was_proved);
        self.open.insert(job.id, open);
        self.prepare(&job);
        self.schedule.push(job);
    }

    fn tell_let_in(&mut self, job: &Job) {
        if let Some(story) = self.stories.of(job.id) {
            story.scene_version = job.snapshot.scene_version;
        }
        let waiting = self.schedule.waiting();
        self.stories
            .tell(job.id, || format!("let in, {waiting} wait"));
    }

    /// Has the model of a job made, where it is not.
    fn prepare(&mut self, job: &Job) {
        let model = &job.snapshot.model;
        if model.is_ready() {
            return;
        }
        if let Some(preparer) = &self.preparer {
            self.stories.tell(job.id, || {
                "waits until robot and scene are put together".to_owned()
            });
            // It ends after this loop only.
            let _ = preparer.send(model.clone());
        }
    }

    fn job(&mut self, id: u64, request: &IncomingRequest, is_again: bool) -> Result<Job, Refusal> {
        let received_ns = monotonic_ns();
        let view = viewed(request, is_again)?;
        let header = &view.header;
        let client = request.client_id();
        let snapshot = self
            .doorkeeper(client, header, is_again)
            .admit(header, received_ns)?;
        let (settings, path) =
            translate::settings_and_path(&view, &snapshot, self.limits.clearance_m)?;
        let job = Job {
            id,
            request_id: header.request_id,
            client,
            snapshot,
            path,
            settings,
            deadline_ns: deadline_ns(header),
            received_ns,
            priority: header.priority,
            stop: Arc::default(),
            asked: self.asked(client, header),
        };
        self.poison.check(|| job.content())?;
        Ok(job)
    }

    fn doorkeeper(
        &mut self,
        client: u128,
        header: &RequestHeader,
        is_again: bool,
    ) -> Doorkeeper<'_> {
        let most_waiting = if is_again {
            // A watch that is in already is not turned away.
            usize::MAX
        } else {
            self.limits.queue
        };
        Doorkeeper {
            store: &mut self.store,
            loading: self.loading.labels(),
            waiting: self.schedule.waiting(),
            most_waiting,
            wait_ns: self
                .schedule
                .wait_ns(client, header.priority, deadline_ns(header)),
            is_draining: self.is_draining,
        }
    }

    fn asked(&self, client: u128, header: &RequestHeader) -> Asked {
        if self.live.is_none() {
            return Asked::default();
        }
        let label = |id| {
            self.store
                .label(id)
                .unwrap_or_default()
                .to_owned()
        };
        Asked {
            robot: label(header.robot_id),
            scene: label(header.scene_id),
            pid: self.clients.pid(client),
        }
    }

    pub(super) fn refuse(&mut self, number: u64, request: IncomingRequest, refusal: &Refusal) {
        tracing::info!(
            request = request.header().request_id,
            code = refusal.code,
            "refused: {}",
            refusal.message
        );
        self.count_refused(number, request.client_id(), refusal);
        let code = Code::try_from(refusal.code).unwrap_or(Code::MalformedRequest);
        if let Err(error) = request.refuse(code, &refusal.message, refusal.retry_after_ms) {
            tracing::warn!("a refusal was not sent: {error}");
        }
    }

    fn count_refused(&mut self, number: u64, client: u128, refusal: &Refusal) {
        self.metrics.ended(refusal.code);
        self.clients.refused(client);
        self.stories.end(number, refusal.code, || {
            format!("refused: {}", refusal.message)
        });
    }

    pub(super) fn send_improvement(&mut self, worker: usize) {
        if let Some(mailbox) = self.mailboxes.get(worker).cloned() {
            mailbox.fetch(|progress| self.send_progress(progress));
        }
    }

    fn send_progress(&mut self, progress: &Progress) {
        if let Some(open) = self.open.get_mut(progress.job) {
            let mut header = progress.header;
            header.flags |= superseded(&self.store, open);
            self.stories
                .tell(progress.job, || story::shorter(&header));
            send_shorter(open, &header, &progress.path);
        }
    }

    pub(super) fn finish(&mut self, answered: Answered) {
        self.note_crash(answered.crashed);
        self.metrics.timed(&answered.reply.header);
        self.note_answer(&answered);
        if let Some(open) = self.close_request(answered.job) {
            self.reply(answered.job, open, answered.reply);
        }
    }

    fn note_crash(&mut self, crashed: Option<u64>) {
        if let Some(content) = crashed {
            self.metrics.panicked();
            self.poison.crashed(content);
        }
    }

    fn reply(&mut self, job: u64, open: OpenRequest, reply: Reply) {
        if watch::is_watch(&open.request) {
            self.watched(job, open, reply);
        } else {
            self.send_final(job, open, reply);
        }
    }

    /// Enters what a job has had, where its client still waits.
    fn note_answer(&mut self, answered: &Answered) {
        let Some(open) = self.open.get(answered.job) else {
            return;
        };
        let reply = &answered.reply;
        self.clients
            .computed(open.request.client_id(), reply.header.compute_ns);
        self.recorder
            .answered(&open.question, Answer::new(reply, answered.way));
        self.note_pauses(answered.job, answered.pauses);
    }

    fn note_pauses(&mut self, job: u64, pauses: u32) {
        if pauses > 0 {
            self.metrics.paused(pauses);
            self.stories
                .tell(job, || format!("made room for others {pauses} times"));
        }
    }

    /// Takes a request out of those that are open.
    fn close_request(&mut self, job: u64) -> Option<OpenRequest> {
        let open = self.open.remove(job)?;
        self.clients
            .left(open.request.client_id(), open.bytes);
        Some(open)
    }

    pub(super) fn send_final(&mut self, job: u64, open: OpenRequest, mut reply: Reply) {
        if reply.header.scene_version != 0 {
            reply.header.flags |= superseded(&self.store, &open);
        }
        self.count_answered(job, &open, &reply.header);
        tracing::debug!(
            request = open.request.header().request_id,
            code = reply.header.code,
            compute_ns = reply.header.compute_ns,
            "answered"
        );
        deliver(open.request, &reply);
    }

    fn count_answered(&mut self, job: u64, open: &OpenRequest, header: &ResponseHeader) {
        let now_ns = monotonic_ns();
        let latency_ns = now_ns.saturating_sub(open.received_ns);
        let client = open.request.client_id();
        self.metrics.ended(header.code);
        self.metrics.answered_after(latency_ns);
        self.clients
            .answered(client, header, latency_ns, now_ns);
        self.stories
            .end(job, header.code, || story::ending(header));
    }

    /// Ends the jobs whose client is gone, and asks those to end whose client wants the best so
    /// far.
    pub(super) fn end_abandoned(&mut self) {
        self.end_abandoned_watches();
        self.cancel_abandoned();
        for (job, stop) in self.open.hinted() {
            self.finish_early(job, &stop);
        }
    }

    fn cancel_abandoned(&mut self) {
        for job in self.open.abandoned() {
            // Dropping the request frees the client's slot at once; the worker ends on its own.
            if let Some(open) = self.close_request(job) {
                self.cancel(job, &open);
            }
        }
    }

    fn cancel(&mut self, job: u64, open: &OpenRequest) {
        self.stop(job, &open.stop, StopCause::Cancelled);
        self.schedule.remove(job);
        self.recorder.abandoned(&open.question);
        self.count_cancelled(job, open.request.client_id());
        tracing::debug!(request = open.request.header().request_id, "cancelled");
    }

    fn count_cancelled(&mut self, job: u64, client: u128) {
        self.metrics.cancelled();
        self.clients.cancelled(client);
        self.stories
            .end(job, Code::Preempted.into(), || {
                "cancelled: the client dropped it or is gone".to_owned()
            });
    }

    fn finish_early(&mut self, job: u64, stop: &StopFlag) {
        match self.schedule.remove(job) {
            Some(job) => self.answer_untouched(&job, StopCause::FinishedEarly),
            None => self.stop(job, stop, StopCause::FinishedEarly),
        }
    }

    /// Asks a job to end, also one that has made room.
    fn stop(&self, job: u64, flag: &StopFlag, cause: StopCause) {
        if flag.set(cause) {
            self.schedule.wake(job);
        }
    }

    /// Nothing waits past its deadline.
    pub(super) fn end_expired(&mut self) {
        for job in self.schedule.take_expired(monotonic_ns()) {
            self.answer_untouched(&job, StopCause::Deadline);
        }
    }

    fn answer_untouched(&mut self, job: &Job, cause: StopCause) {
        let mut reply = self.untouched(job, cause);
        reply.header.queue_ns = monotonic_ns().saturating_sub(job.received_ns);
        if let Some(open) = self.close_request(job.id) {
            let answer = Answer::new(&reply, Way::Untouched);
            self.recorder.answered(&open.question, answer);
            self.send_final(job.id, open, reply);
        }
    }

    /// What the client of a job hears that was not begun.
    fn untouched(&self, job: &Job, cause: StopCause) -> Reply {
        match cause {
            StopCause::Deadline if !job.snapshot.model.is_ready() => self.still_loading(job),
            StopCause::Deadline => translate::expired(&job.snapshot, &job.path),
            cause => translate::preempted(&job.snapshot, &job.path, cause),
        }
    }

    fn still_loading(&self, job: &Job) -> Reply {
        let waited_ms = monotonic_ns().saturating_sub(job.received_ns) / 1_000_000;
        let scene = self
            .store
            .label(job.snapshot.scene_id)
            .unwrap_or_default();
        translate::loading(&job.snapshot, scene, waited_ms)
    }

    /// Ends the daemon: takes nothing new and ends what runs, with the best so far.
    pub(super) fn drain(&mut self) {
        self.is_removed = false;
        self.end_open();
    }

    /// The same, to start anew.
    pub(super) fn drain_removed(&mut self) {
        if !self.is_draining {
            self.is_removed = true;
            self.end_open();
        }
    }

    fn end_open(&mut self) {
        if !std::mem::replace(&mut self.is_draining, true) {
            tracing::info!(open = self.open.len(), "stopping");
            self.end_all();
        }
    }

    fn end_all(&mut self) {
        self.end_waiting();
        self.stop_open();
        self.end_watches();
    }

    fn end_waiting(&mut self) {
        for job in self.schedule.take_all() {
            self.answer_untouched(&job, StopCause::Shutdown);
        }
    }

    fn stop_open(&self) {
        for (job, stop) in self.open.flags() {
            self.stop(job, stop, StopCause::Shutdown);
        }
    }
}

/// A request as its client wrote it; one that is asked again follows the newest version.
fn viewed(request: &IncomingRequest, is_again: bool) -> Result<RequestView<'_>, Refusal> {
    let mut view = request
        .view()
        .map_err(|error| Refusal::new(error.code(), error.to_string()))?;
    watch::check(&view.header)?;
    if is_again {
        watch::follow(&mut view.header);
    }
    Ok(view)
}

fn deadline_ns(header: &RequestHeader) -> Option<u64> {
    Some(header.deadline_ns).filter(|deadline_ns| *deadline_ns != 0)
}

/// Sends an answer; where it has no room, a refusal.
fn deliver(mut request: IncomingRequest, reply: &Reply) {
    let Err(error) = request.send(&reply.header, &reply.body()) else {
        return;
    };
    let id = request.header().request_id;
    tracing::warn!(request = id, "the answer was not sent: {error}");
    if !matches!(error, SendError::TooLarge(_) | SendError::NoMemory(_)) {
        return;
    }
    if let Err(error) = request.refuse(Code::ResourceExhausted, &error.to_string(), 0) {
        tracing::warn!(request = id, "its refusal neither: {error}");
    }
}

/// Sends an improvement; one that does not arrive is followed by others, or by the answer.
fn send_shorter(open: &mut OpenRequest, header: &ResponseHeader, path: &[f64]) {
    let body = ResponseBody {
        path,
        ..ResponseBody::default()
    };
    if let Err(error) = open.request.send(header, &body) {
        let request = open.request.header().request_id;
        tracing::warn!(request, "an improvement was not sent: {error}");
    }
}
