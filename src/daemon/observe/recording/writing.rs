//! The thread that writes recordings.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::thread::JoinHandle;

use crossbeam_channel::{Receiver, Sender, unbounded};
use taut_ipc::control::{ControlReply, RecordingState, Refusal};
use taut_ipc::wire::Code;

use super::counts::Counts;
use super::record::RunRecord;
use super::recorder::{Kept, Line};
use super::write::RunWriter;
use crate::daemon::service::event::Ticket;
use crate::daemon::threads::spawn;

/// Hears the answer to a control request.
type Told = Box<dyn Fn(Ticket, ControlReply) + Send>;

/// Starts the thread; it ends when the sender is dropped.
pub(crate) fn start(
    counts: Arc<Counts>,
    told: Told,
) -> std::io::Result<(Sender<Line>, JoinHandle<()>)> {
    let (lines, receiver) = unbounded();
    let mut thread = Writing {
        told,
        run: None,
        counts,
    };
    let joined = spawn("taut-recorder", move || thread.work(&receiver))?;
    Ok((lines, joined))
}

/// What the thread owns.
struct Writing {
    told: Told,
    run: Option<(PathBuf, RunWriter)>,
    counts: Arc<Counts>,
}

impl Writing {
    fn work(&mut self, lines: &Receiver<Line>) {
        lines.iter().for_each(|line| self.take(line));
        // The daemon ends.
        self.end(None);
    }

    fn take(&mut self, line: Line) {
        match line {
            Line::Begin { file, ticket } => {
                let begun = self.begin(&file);
                self.answer(Some(ticket), begun);
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
            Line::End { ticket } => self.end(ticket),
            Line::Bundle {
                file,
                story,
                kept,
                ticket,
            } => self.answer(Some(ticket), bundled(&file, story, &kept)),
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

    fn end(&mut self, ticket: Option<Ticket>) {
        let missed = self.counts.missed.load(Relaxed);
        self.write(|run| run.write(&RunRecord::Ended { missed }));
        let file = self
            .run
            .take()
            .map(|(file, _)| file)
            .unwrap_or_default();
        self.answer(ticket, self.counts.state(&file));
    }

    fn answer(&self, ticket: Option<Ticket>, state: Result<RecordingState, Refusal>) {
        let Some(ticket) = ticket else { return };
        let answer = state.map_or_else(ControlReply::Refused, ControlReply::Recording);
        (self.told)(ticket, answer);
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
