//! A request's way through the I/O thread: let in or refused, given to the workers, told of each
//! improvement, ended.

use std::sync::Arc;

use taut_ipc::control::Refusal;
use taut_ipc::monotonic_ns;
use taut_ipc::server::{IncomingRequest, SendError, ServerError};
use taut_ipc::wire::{Code, RequestHeader};

use super::admission::Doorkeeper;
use super::event::{Answered, Way};
use super::event_loop::{EventLoop, ROUND};
use super::job::{Asked, Job, StopCause, StopFlag};
use super::mailbox::Progress;
use super::open_request::{OpenRequest, superseded};
use super::recording::Answer;
use super::story::{self, story};
use super::translate::{self, Reply};
use super::watch;

impl EventLoop {
    /// Takes requests; tells whether more may be waiting.
    pub(super) fn receive_requests(&mut self) -> Result<bool, ServerError> {
        for _ in 0..ROUND {
            let Some(request) = self.server.receive()? else {
                return Ok(false);
            };
            self.metrics.received();
            let number = self.next_number();
            if let Err((request, refusal)) = self.take(number, request) {
                self.refuse(number, *request, &refusal);
            }
        }
        Ok(true)
    }

    /// Lets a request in and gives it to the workers.
    fn take(
        &mut self,
        number: u64,
        request: IncomingRequest,
    ) -> Result<(), (Box<IncomingRequest>, Refusal)> {
        let now_ns = monotonic_ns();
        let client = request.client_id();
        let bytes = request.payload().len();
        let server = &self.server;
        let janitor = &self.janitor;
        let met = || {
            janitor.look();
            server.client_pid(client)
        };
        let entered = self.clients.enter(client, met, bytes, now_ns);
        self.stories.begin(
            number,
            story(&self.store, &request, self.clients.pid(client), now_ns),
        );
        match entered {
            Ok(()) => self.enqueue(number, request, None),
            Err(refusal) => Err((Box::new(request), refusal)),
        }
    }

    /// Gives a request to the workers that is counted already; `was_proved` where it is a watch
    /// that was let in before.
    pub(super) fn enqueue(
        &mut self,
        number: u64,
        request: IncomingRequest,
        was_proved: Option<bool>,
    ) -> Result<(), (Box<IncomingRequest>, Refusal)> {
        let now_ns = monotonic_ns();
        let client = request.client_id();
        let bytes = request.payload().len();
        let job = match self.job(number, &request, now_ns, was_proved.is_some()) {
            Ok(job) => job,
            Err(refusal) => {
                self.clients.left(client, bytes);
                return Err((Box::new(request), refusal));
            }
        };
        let scene_id = job.snapshot.scene_id;
        let scene_version = job.snapshot.scene_version;
        tracing::debug!(request = job.request_id, job = number, "taken");
        if let Some(story) = self.stories.of(number) {
            story.scene_version = scene_version;
        }
        let waiting = self.schedule.waiting();
        self.stories
            .tell(number, || format!("let in, {waiting} wait"));
        let stop = job.stop.clone();
        let received_ns = now_ns;
        let question = self.recorder.asked(&job);
        let open = OpenRequest {
            request,
            stop,
            bytes,
            received_ns,
            scene_id,
            scene_version,
            question,
            was_proved,
        };
        self.open.insert(number, open);
        if let Some(preparer) = self
            .preparer
            .as_ref()
            .filter(|_| !job.snapshot.model.is_ready())
        {
            self.stories.tell(number, || {
                "waits until robot and scene are put together".to_owned()
            });
            // It ends after this loop only.
            let _ = preparer.send(job.snapshot.model.clone());
        }
        self.schedule.push(job);
        Ok(())
    }

    fn job(
        &mut self,
        id: u64,
        request: &IncomingRequest,
        received_ns: u64,
        is_again: bool,
    ) -> Result<Job, Refusal> {
        let mut view = request
            .view()
            .map_err(|error| Refusal::new(error.code(), error.to_string()))?;
        watch::check(&view.header)?;
        if is_again {
            watch::follow(&mut view.header);
        }
        let client = request.client_id();
        let header = &view.header;
        let deadline_ns = Some(header.deadline_ns).filter(|deadline| *deadline != 0);
        let mut doorkeeper = Doorkeeper {
            store: &mut self.store,
            loading: &self.loading,
            waiting: self.schedule.waiting(),
            // A watch that is in already is not turned away.
            most_waiting: if is_again {
                usize::MAX
            } else {
                self.queue_limit
            },
            wait_ns: self.schedule.wait_ns(client, header.priority, deadline_ns),
            is_draining: self.is_draining,
        };
        let snapshot = doorkeeper.admit(header, received_ns)?;
        let (settings, path) =
            translate::settings_and_path(&view, &snapshot, self.default_clearance_m)?;
        let job = Job {
            id,
            request_id: header.request_id,
            client,
            snapshot,
            path,
            settings,
            deadline_ns,
            received_ns,
            priority: header.priority,
            stop: Arc::default(),
            asked: self.asked(client, header),
        };
        self.poison.check(|| job.content())?;
        Ok(job)
    }

    fn asked(&self, client: u128, header: &RequestHeader) -> Asked {
        if self.live.is_none() {
            return Asked::default();
        }
        let label = |id| self.store.label(id).unwrap_or_default().to_owned();
        Asked {
            robot: label(header.robot_id),
            scene: label(header.scene_id),
            pid: self.clients.pid(client),
        }
    }

    pub(super) fn refuse(&mut self, number: u64, request: IncomingRequest, refusal: &Refusal) {
        let client = request.client_id();
        tracing::info!(
            request = request.header().request_id,
            code = refusal.code,
            "refused: {}",
            refusal.message
        );
        self.metrics.ended(refusal.code);
        self.clients.refused(client);
        self.stories.end(number, refusal.code, || {
            format!("refused: {}", refusal.message)
        });
        let code = Code::try_from(refusal.code).unwrap_or(Code::MalformedRequest);
        if let Err(error) = request.refuse(code, &refusal.message, refusal.retry_after_ms) {
            tracing::warn!("a refusal was not sent: {error}");
        }
    }

    pub(super) fn send_improvement(&mut self, worker: usize) {
        let Some(mailbox) = self.mailboxes.get(worker).cloned() else {
            return;
        };
        mailbox.fetch(|progress: &Progress| {
            let Some(open) = self.open.get_mut(&progress.job) else {
                return;
            };
            let mut header = progress.header;
            header.flags |= superseded(&self.store, open);
            let body = taut_ipc::wire::ResponseBody {
                path: &progress.path,
                ..Default::default()
            };
            self.stories.tell(progress.job, || {
                format!(
                    "shorter: {:.6} after {} iterations",
                    header.length_after, header.iterations
                )
            });
            if let Err(error) = open.request.send(&header, &body) {
                tracing::warn!(
                    request = open.request.header().request_id,
                    "an improvement was not sent: {error}"
                );
            }
        });
    }

    pub(super) fn finish(&mut self, answered: Answered) {
        let Answered {
            job,
            reply,
            way,
            pauses,
            crashed,
        } = answered;
        if let Some(content) = crashed {
            self.metrics.panicked();
            self.poison.crashed(content);
        }
        self.metrics.timed(&reply.header);
        let Some(open) = self.open.get(&job) else {
            return;
        };
        self.clients
            .computed(open.request.client_id(), reply.header.compute_ns);
        self.recorder.answered(
            &open.question,
            Answer {
                reply: reply.clone(),
                way,
            },
        );
        if pauses > 0 {
            self.metrics.paused(pauses);
            self.stories
                .tell(job, || format!("made room for others {pauses} times"));
        }
        match self.close_request(job) {
            Some(open) if watch::is_watch(&open.request) => self.watched(job, open, reply),
            Some(open) => self.send_final(job, open, reply),
            None => {}
        }
    }

    /// Takes a request out of those that are open.
    fn close_request(&mut self, job: u64) -> Option<OpenRequest> {
        let open = self.open.remove(&job)?;
        self.clients.left(open.request.client_id(), open.bytes);
        Some(open)
    }

    pub(super) fn send_final(&mut self, job: u64, mut open: OpenRequest, mut reply: Reply) {
        if reply.header.scene_version != 0 {
            reply.header.flags |= superseded(&self.store, &open);
        }
        let now_ns = monotonic_ns();
        let latency_ns = now_ns.saturating_sub(open.received_ns);
        self.metrics.ended(reply.header.code);
        self.metrics.answered_after(latency_ns);
        self.clients
            .answered(open.request.client_id(), &reply.header, latency_ns, now_ns);
        self.stories
            .end(job, reply.header.code, || story::ending(&reply.header));
        let request = open.request.header().request_id;
        tracing::debug!(
            request,
            code = reply.header.code,
            compute_ns = reply.header.compute_ns,
            "answered"
        );
        let Err(error) = open.request.send(&reply.header, &reply.body()) else {
            return;
        };
        tracing::warn!(request, "the answer was not sent: {error}");
        let code = match error {
            SendError::TooLarge(_) | SendError::NoMemory(_) => Code::ResourceExhausted,
            _ => return,
        };
        let refused = open.request.refuse(code, &error.to_string(), 0);
        if let Err(error) = refused {
            tracing::warn!(request, "its refusal neither: {error}");
        }
    }

    /// Ends the jobs whose client is gone, and asks those to end whose client wants the best so
    /// far.
    pub(super) fn end_abandoned(&mut self) {
        self.end_abandoned_watches();
        let gone: Vec<u64> = self
            .open
            .iter()
            .filter(|(_, open)| !open.request.is_connected())
            .map(|(job, _)| *job)
            .collect();
        for job in gone {
            // Dropping the request frees the client's slot at once; the worker ends on its own.
            let Some(open) = self.close_request(job) else {
                continue;
            };
            self.stop(job, &open.stop, StopCause::Cancelled);
            self.schedule.remove(job);
            self.metrics.cancelled();
            self.clients.cancelled(open.request.client_id());
            self.recorder.abandoned(&open.question);
            self.stories.end(job, Code::Preempted.into(), || {
                "cancelled: the client dropped it or is gone".to_owned()
            });
            tracing::debug!(request = open.request.header().request_id, "cancelled");
        }
        let hinted = self
            .open
            .iter()
            .filter(|(_, open)| open.request.has_disconnect_hint());
        let hinted: Vec<(u64, Arc<StopFlag>)> = hinted
            .map(|(job, open)| (*job, open.stop.clone()))
            .collect();
        for (job, stop) in hinted {
            if let Some(job) = self.schedule.remove(job) {
                self.answer_untouched(&job, StopCause::FinishedEarly);
            } else {
                self.stop(job, &stop, StopCause::FinishedEarly);
            }
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
        let mut reply = match cause {
            StopCause::Deadline if !job.snapshot.model.is_ready() => {
                let waited_ms = monotonic_ns().saturating_sub(job.received_ns) / 1_000_000;
                let scene = self.store.label(job.snapshot.scene_id).unwrap_or_default();
                translate::loading(&job.snapshot, scene, waited_ms)
            }
            StopCause::Deadline => translate::expired(&job.snapshot, &job.path),
            cause => translate::preempted(&job.snapshot, &job.path, cause),
        };
        reply.header.queue_ns = monotonic_ns().saturating_sub(job.received_ns);
        if let Some(open) = self.close_request(job.id) {
            self.recorder.answered(
                &open.question,
                Answer {
                    reply: reply.clone(),
                    way: Way::Untouched,
                },
            );
            self.send_final(job.id, open, reply);
        }
    }

    /// Takes nothing new and ends what runs, with the best so far.
    pub(super) fn drain(&mut self) {
        if std::mem::replace(&mut self.is_draining, true) {
            return;
        }
        tracing::info!(open = self.open.len(), "stopping");
        for job in self.schedule.take_all() {
            self.answer_untouched(&job, StopCause::Shutdown);
        }
        self.open
            .iter()
            .for_each(|(job, open)| self.stop(*job, &open.stop, StopCause::Shutdown));
        self.end_watches();
    }
}
