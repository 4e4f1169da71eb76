//! The I/O thread's side, and the thread that writes.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use crossbeam_channel::{Receiver, Sender, unbounded};
use taut_ipc::control::{ControlReply, RecordingState, Refusal};
use taut_ipc::wire::Code;

use super::record::RunRecord;
use super::write::RunWriter;
use super::{Answer, Question};
use crate::daemon::event::{Event, EventSender};
use crate::daemon::job::Job;
use crate::daemon::threads::spawn;

/// Answers that are remembered for a bundle, and the bytes of their paths and answers together.
const REMEMBERED: usize = 256;
const REMEMBERED_BYTES: usize = 4 * 1024 * 1024;
/// Bytes that may wait to be written; a slow disk does not fill the memory.
const WAITING_BYTES: u64 = 64 * 1024 * 1024;
/// How long (ns) a recording goes on of which nobody has asked how it goes.
const PATIENCE_NS: u64 = 5_000_000_000;

/// What the thread is told.
enum Line {
    Begin {
        file: PathBuf,
        token: u64,
    },
    Asked(Arc<Question>),
    Answered(Arc<Question>, Arc<Answer>),
    Abandoned(u64),
    End {
        token: Option<u64>,
    },
    Bundle {
        file: PathBuf,
        story: String,
        kept: Vec<Kept>,
        token: u64,
    },
}

type Kept = (Arc<Question>, Arc<Answer>);

/// What both sides count.
#[derive(Default)]
struct Counts {
    requests: AtomicU64,
    answers: AtomicU64,
    missed: AtomicU64,
    bytes: AtomicU64,
    waiting: AtomicU64,
    has_failed: AtomicBool,
    failure: Mutex<String>,
}

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

/// What the I/O thread owns.
pub(in crate::daemon) struct Recorder {
    /// Gone once the daemon ends.
    lines: Option<Sender<Line>>,
    running: Option<Running>,
    kept: VecDeque<Kept>,
    kept_bytes: usize,
    counts: Arc<Counts>,
}

impl Recorder {
    /// Starts the thread; it ends when the recorder is closed.
    pub(in crate::daemon) fn start(events: EventSender) -> std::io::Result<(Self, JoinHandle<()>)> {
        let (lines, receiver) = unbounded();
        let recorder = Self::new(lines);
        let mut thread = Writing {
            events,
            run: None,
            counts: recorder.counts.clone(),
        };
        let joined = spawn("taut-recorder", move || thread.work(&receiver))?;
        Ok((recorder, joined))
    }

    fn new(lines: Sender<Line>) -> Self {
        Self {
            lines: Some(lines),
            running: None,
            kept: VecDeque::new(),
            kept_bytes: 0,
            counts: Arc::default(),
        }
    }

    fn send(&self, line: Line) {
        if let Some(lines) = &self.lines {
            // The thread lives until this sender is gone.
            let _ = lines.send(line);
        }
    }

    fn is_running(&self) -> bool {
        self.running.is_some() && !self.counts.has_failed()
    }

    /// Begins to record to a file, or tells how that goes; `None` where the thread answers the
    /// control request.
    ///
    /// # Errors
    /// Another recording runs.
    pub(in crate::daemon) fn record(
        &mut self,
        file: PathBuf,
        token: u64,
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
                self.begin(file, token, now_ns);
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

    fn begin(&mut self, file: PathBuf, token: u64, now_ns: u64) {
        self.counts.begin();
        self.running = Some(Running::new(file.clone(), now_ns));
        self.send(Line::Begin { file, token });
    }

    /// Ends the recording; the thread answers the control request once all is written.
    ///
    /// # Errors
    /// None runs.
    pub(in crate::daemon) fn end(&mut self, token: Option<u64>) -> Result<(), Refusal> {
        match self.running.take() {
            Some(_) => {
                self.send(Line::End { token });
                Ok(())
            }
            None => {
                let text = "nothing is being recorded";
                Err(Refusal::new(Code::MalformedRequest, text))
            }
        }
    }

    /// Ends a recording of which nobody has asked how it goes for too long: who wanted it is gone.
    pub(in crate::daemon) fn end_forgotten(&mut self, now_ns: u64) {
        let running = self.running.as_ref();
        if let Some(forgotten) = running.filter(|running| running.is_forgotten(now_ns)) {
            let file = forgotten.file.display();
            tracing::info!("recording to {file} ends: who asked for it is gone");
            let _ = self.end(None);
        }
    }

    /// Has a request written that is to be recorded.
    fn record_question(&self, question: &Arc<Question>) {
        if question.is_recorded {
            self.counts.requests.fetch_add(1, Relaxed);
            self.send(Line::Asked(question.clone()));
        }
    }

    /// A job is given to the workers.
    pub(in crate::daemon) fn asked(&mut self, job: &Job) -> Arc<Question> {
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
    pub(in crate::daemon) fn answered(&mut self, question: &Arc<Question>, answer: Answer) {
        let answer = Arc::new(answer);
        if question.is_recorded && self.takes(answer.bytes()) {
            self.counts.answers.fetch_add(1, Relaxed);
            self.send(Line::Answered(question.clone(), answer.clone()));
        }
        self.keep((question.clone(), answer));
    }

    /// Its client has dropped it.
    pub(in crate::daemon) fn abandoned(&mut self, question: &Question) {
        if question.is_recorded && self.is_running() {
            self.send(Line::Abandoned(question.number));
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
    pub(in crate::daemon) fn bundle(
        &self,
        request_id: u64,
        file: PathBuf,
        story: String,
        token: u64,
    ) -> Result<(), Refusal> {
        let kept = self.kept_of(request_id);
        if kept.is_empty() {
            return Err(not_remembered(request_id));
        }
        self.send(Line::Bundle {
            file,
            story,
            kept,
            token,
        });
        Ok(())
    }

    fn kept_of(&self, request_id: u64) -> Vec<Kept> {
        let kept = self.kept.iter();
        kept.filter(|(question, _)| question.request_id == request_id)
            .cloned()
            .collect()
    }

    /// Lets the thread end once all is written.
    pub(in crate::daemon) fn close(&mut self) {
        let _ = self.end(None);
        self.lines = None;
    }
}

impl Answer {
    fn bytes(&self) -> usize {
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

impl Counts {
    fn begin(&self) {
        for count in [&self.requests, &self.answers, &self.missed, &self.bytes] {
            count.store(0, Relaxed);
        }
        self.has_failed.store(false, Relaxed);
    }

    fn fail(&self, text: String) {
        tracing::error!("not recorded: {text}");
        *self
            .failure
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = text;
        self.has_failed.store(true, Relaxed);
    }

    /// How the recording goes.
    fn state(&self, file: &Path) -> Result<RecordingState, Refusal> {
        match self.failure() {
            Some(failure) => Err(Refusal::new(
                Code::ResourceExhausted,
                format!("not recorded: {failure}"),
            )),
            None => Ok(RecordingState {
                file: file.to_owned(),
                requests: self.requests.load(Relaxed),
                answers: self.answers.load(Relaxed),
                missed: self.missed.load(Relaxed),
                bytes: self.bytes.load(Relaxed),
            }),
        }
    }

    fn has_failed(&self) -> bool {
        self.has_failed.load(Relaxed)
    }

    fn failure(&self) -> Option<String> {
        let text = || {
            self.failure
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        self.has_failed().then(|| text().clone())
    }

    /// Whether so many bytes more may wait to be written; what may not is counted as missed.
    fn takes(&self, bytes: u64) -> bool {
        let takes = self.waiting.load(Relaxed) + bytes <= WAITING_BYTES;
        match takes {
            true => self.waiting.fetch_add(bytes, Relaxed),
            false => self.missed.fetch_add(1, Relaxed),
        };
        takes
    }

    /// So many bytes wait no longer.
    fn came(&self, bytes: usize) {
        self.waiting.fetch_sub(bytes as u64, Relaxed);
    }
}

/// What the thread owns.
struct Writing {
    events: EventSender,
    run: Option<(PathBuf, RunWriter)>,
    counts: Arc<Counts>,
}

impl Writing {
    fn work(&mut self, lines: &Receiver<Line>) {
        lines.iter().for_each(|line| self.take(line));
    }

    fn take(&mut self, line: Line) {
        match line {
            Line::Begin { file, token } => {
                let begun = self.begin(&file);
                self.answer(Some(token), begun);
            }
            Line::Asked(question) => {
                self.counts
                    .came(size_of_val(question.path.as_flat()));
                self.write(|run| run.request(&question));
            }
            Line::Answered(question, answer) => {
                self.counts.came(answer.bytes());
                self.write(|run| run.answer(question.number, &answer));
            }
            Line::Abandoned(number) => {
                self.write(|run| run.write(&RunRecord::Abandoned { number }))
            }
            Line::End { token } => self.end(token),
            Line::Bundle {
                file,
                story,
                kept,
                token,
            } => self.answer(Some(token), bundled(&file, story, &kept)),
        }
    }

    fn begin(&mut self, file: &Path) -> Result<RecordingState, Refusal> {
        let created = RunWriter::create(file);
        let run = created.map_err(|error| self.not_created(file, &error))?;
        self.run = Some((file.to_owned(), run));
        self.counts.state(file)
    }

    fn not_created(&self, file: &Path, error: &str) -> Refusal {
        let text = format!("{}: {error}", file.display());
        self.counts.fail(text.clone());
        Refusal::new(Code::UnreadableFile, format!("cannot record to {text}"))
    }

    /// Writes to the file that is open; after a failure there is none.
    fn write(&mut self, write: impl FnOnce(&mut RunWriter) -> Result<(), String>) {
        let Some((file, run)) = &mut self.run else {
            return;
        };
        if let Err(error) = write(run) {
            self.counts
                .fail(format!("{}: {error}", file.display()));
            self.run = None;
        } else {
            self.counts.bytes.store(run.bytes, Relaxed);
        }
    }

    fn end(&mut self, token: Option<u64>) {
        let missed = self.counts.missed.load(Relaxed);
        self.write(|run| run.write(&RunRecord::Ended { missed }));
        let file = self
            .run
            .take()
            .map(|(file, _)| file)
            .unwrap_or_default();
        self.answer(token, self.counts.state(&file));
    }

    fn answer(&self, token: Option<u64>, state: Result<RecordingState, Refusal>) {
        let Some(token) = token else { return };
        let answer = state.map_or_else(ControlReply::Refused, ControlReply::Recording);
        self.events
            .send(Event::Written { token, answer });
    }
}

/// One file with a few requests and what the daemon tells of them.
fn write_bundle(file: &Path, story: String, kept: &[Kept]) -> Result<u64, String> {
    let mut run = RunWriter::create(file)?;
    run.write(&RunRecord::Story(story))?;
    for (question, answer) in kept {
        run.request(question)?;
        run.answer(question.number, answer)?;
    }
    run.write(&RunRecord::Ended { missed: 0 })?;
    Ok(run.bytes)
}

/// Writes such a file, and tells of it as of a recording.
fn bundled(file: &Path, story: String, kept: &[Kept]) -> Result<RecordingState, Refusal> {
    let written = write_bundle(file, story, kept);
    let bytes = written.map_err(|error| not_written(file, &error))?;
    let count = kept.len() as u64;
    Ok(RecordingState {
        file: file.to_owned(),
        requests: count,
        answers: count,
        missed: 0,
        bytes,
    })
}

fn not_written(file: &Path, error: &str) -> Refusal {
    let text = format!("cannot write {}: {error}", file.display());
    Refusal::new(Code::ResourceExhausted, text)
}
