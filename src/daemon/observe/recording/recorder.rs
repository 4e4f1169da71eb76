//! What is remembered of requests, and what is to be written of them.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use taut_ipc::control::{RecordingState, Refusal};
use taut_ipc::wire::Code;

use super::counts::Counts;
use super::{Answer, Question};
use crate::daemon::service::event::Ticket;
use crate::daemon::service::job::Job;

/// Answers that are remembered for a bundle, and the bytes of their paths and answers together.
const REMEMBERED: usize = 256;
const REMEMBERED_BYTES: usize = 4 * 1024 * 1024;
/// How long (ns) a recording goes on of which nobody has asked how it goes.
const PATIENCE_NS: u64 = 5_000_000_000;

/// What the thread that writes is told.
pub(crate) enum Line {
    Begin {
        file: PathBuf,
        ticket: Ticket,
    },
    Asked(Arc<Question>),
    Answered(Arc<Question>, Arc<Answer>),
    Abandoned(u64),
    End {
        ticket: Option<Ticket>,
    },
    Bundle {
        file: PathBuf,
        story: String,
        kept: Vec<Kept>,
        ticket: Ticket,
    },
}

pub(super) type Kept = (Arc<Question>, Arc<Answer>);

/// The recording that runs.
struct Running {
    file: PathBuf,
    asked_about_ns: u64,
}

impl Running {
    fn new(file: PathBuf, now_ns: u64) -> Self {
        Self {
            file,
            asked_about_ns: now_ns,
        }
    }

    fn is_forgotten(&self, now_ns: u64) -> bool {
        now_ns > self.asked_about_ns + PATIENCE_NS
    }
}

/// Remembers answers, and what is to be written of a recording that runs.
#[derive(Default)]
pub(crate) struct Recorder {
    lines: Vec<Line>,
    running: Option<Running>,
    kept: VecDeque<Kept>,
    kept_bytes: usize,
    counts: Arc<Counts>,
}

impl Recorder {
    /// Nothing is recorded; what waits to be written is counted in `counts`.
    pub(crate) fn new(counts: Arc<Counts>) -> Self {
        Self {
            counts,
            ..Self::default()
        }
    }

    /// Takes what is to be written by now.
    pub(crate) fn lines(&mut self) -> std::vec::Drain<'_, Line> {
        self.lines.drain(..)
    }

    fn is_running(&self) -> bool {
        self.running.is_some() && !self.counts.has_failed()
    }

    /// Begins to record to a file, or tells how that goes; `None` where the thread answers the
    /// control request.
    ///
    /// # Errors
    /// Another recording runs.
    pub(crate) fn record(
        &mut self,
        file: PathBuf,
        ticket: Ticket,
        now_ns: u64,
    ) -> Result<Option<RecordingState>, Refusal> {
        let has_failed = self.counts.has_failed();
        let running = self.running.as_mut();
        match running.filter(|running| !has_failed || running.file == file) {
            Some(running) if running.file != file => Err(taken(&running.file)),
            Some(running) => {
                running.asked_about_ns = now_ns;
                self.state(&file).map(Some)
            }
            None => {
                self.begin(file, ticket, now_ns);
                Ok(None)
            }
        }
    }

    /// How the recording to a file goes; one that has failed runs no longer.
    fn state(&mut self, file: &Path) -> Result<RecordingState, Refusal> {
        let state = self.counts.state(file);
        if state.is_err() {
            self.running = None;
        }
        state
    }

    fn begin(&mut self, file: PathBuf, ticket: Ticket, now_ns: u64) {
        self.counts.begin();
        self.running = Some(Running::new(file.clone(), now_ns));
        self.lines.push(Line::Begin { file, ticket });
    }

    /// Ends the recording; the thread that writes answers the control request once all is written.
    ///
    /// # Errors
    /// None runs.
    pub(crate) fn end(&mut self, ticket: Option<Ticket>) -> Result<(), Refusal> {
        match self.running.take() {
            Some(_) => {
                self.lines.push(Line::End { ticket });
                Ok(())
            }
            None => {
                let text = "nothing is being recorded";
                Err(Refusal::new(Code::MalformedRequest, text))
            }
        }
    }

    /// Ends a recording of which nobody has asked how it goes for too long: who wanted it is gone.
    pub(crate) fn end_forgotten(&mut self, now_ns: u64) {
        let running = self.running.as_ref();
        if let Some(forgotten) = running.filter(|running| running.is_forgotten(now_ns)) {
            let file = forgotten.file.display();
            tracing::info!("recording to {file} ends: who asked for it is gone");
            let _ = self.end(None);
        }
    }

    /// Has a request written that is to be recorded.
    fn record_question(&mut self, question: &Arc<Question>) {
        if question.is_recorded {
            self.counts.requests.fetch_add(1, Relaxed);
            self.lines.push(Line::Asked(question.clone()));
        }
    }

    /// A job is given to the workers.
    pub(crate) fn asked(&mut self, job: &Job) -> Arc<Question> {
        let takes = self.takes(size_of_val(job.path.as_flat()));
        let question = Arc::new(Question::of(job, takes));
        self.record_question(&question);
        question
    }

    /// Whether a recording runs to which so many bytes more may be written.
    fn takes(&self, bytes: usize) -> bool {
        self.is_running() && self.counts.takes(bytes as u64)
    }

    /// It has its answer.
    pub(crate) fn answered(&mut self, question: &Arc<Question>, answer: Answer) {
        let answer = Arc::new(answer);
        if question.is_recorded && self.takes(answer.bytes()) {
            self.counts.answers.fetch_add(1, Relaxed);
            self.lines
                .push(Line::Answered(question.clone(), answer.clone()));
        }
        self.keep((question.clone(), answer));
    }

    /// Its client has dropped it.
    pub(crate) fn abandoned(&mut self, question: &Question) {
        if question.is_recorded && self.is_running() {
            self.lines
                .push(Line::Abandoned(question.number));
        }
    }

    fn keep(&mut self, kept: Kept) {
        let bytes = bytes_of(&kept);
        if bytes > REMEMBERED_BYTES {
            return;
        }
        self.kept_bytes += bytes;
        self.kept.push_back(kept);
        while self.is_overfull() {
            self.forget_oldest();
        }
    }

    fn is_overfull(&self) -> bool {
        self.kept.len() > REMEMBERED || self.kept_bytes > REMEMBERED_BYTES
    }

    fn forget_oldest(&mut self) {
        if let Some(oldest) = self.kept.pop_front() {
            self.kept_bytes -= bytes_of(&oldest);
        }
    }

    /// Writes the requests of this id that are remembered to a file; the thread answers the control
    /// request.
    ///
    /// # Errors
    /// None is remembered.
    pub(crate) fn bundle(
        &mut self,
        request_id: u64,
        file: PathBuf,
        story: String,
        ticket: Ticket,
    ) -> Result<(), Refusal> {
        let kept = self.kept_of(request_id);
        if kept.is_empty() {
            return Err(not_remembered(request_id));
        }
        self.lines.push(Line::Bundle {
            file,
            story,
            kept,
            ticket,
        });
        Ok(())
    }

    fn kept_of(&self, request_id: u64) -> Vec<Kept> {
        let kept = self.kept.iter();
        kept.filter(|(question, _)| question.request_id == request_id)
            .cloned()
            .collect()
    }
}

impl Answer {
    pub(super) fn bytes(&self) -> usize {
        let mut header = self.reply.header;
        self.reply
            .body()
            .lay_out(&mut header)
            .unwrap_or(0)
    }
}

fn bytes_of((question, answer): &Kept) -> usize {
    size_of_val(question.path.as_flat())
        + answer.bytes()
        + size_of::<Question>()
        + size_of::<Answer>()
}

fn taken(file: &Path) -> Refusal {
    let file = file.display();
    let text = format!("this daemon records to {file} already; end that `taut record` first");
    Refusal::new(Code::LabelTaken, text)
}

fn not_remembered(request_id: u64) -> Refusal {
    let text = format!(
        "request {request_id:016x} is not remembered whole: it was refused before it was let in, runs still, is larger than {} MiB, or {REMEMBERED} others ended since; `taut record` keeps all that come",
        REMEMBERED_BYTES >> 20
    );
    Refusal::new(Code::InvalidObjectName, text)
}
