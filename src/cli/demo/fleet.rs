//! The planner processes, all at once, and what they say.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, unbounded};
use taut_ipc::own_daemon::{self, OwnDaemon, OwnDaemonError};

use super::progress::Progress;
use super::row::{Message, Row};
use super::shipped;
use crate::cli::error::CliError;

/// How often a signal is looked for.
const TICK: Duration = Duration::from_millis(50);
/// Longer than a planner can take for its search and for waiting, whatever the deadline.
const PATIENCE: Duration = Duration::from_secs(60);

/// Running planners; those that still run when it is dropped are stopped.
pub(super) struct Fleet {
    children: Vec<Child>,
    said: Receiver<(usize, Option<Message>)>,
}

impl Fleet {
    /// Starts a planner for each row.
    pub(super) fn start(
        daemon: &OwnDaemon,
        rows: &[Row],
        deadline: Duration,
    ) -> Result<Self, CliError> {
        let (say, said) = unbounded();
        let mut fleet = Self {
            children: Vec::new(),
            said,
        };
        for (index, row) in rows.iter().enumerate() {
            let mut child = own_daemon::spawn(planner(daemon, row, deadline)?)?;
            let out = child.stdout.take();
            fleet.children.push(child);
            if let Some(out) = out {
                let say = say.clone();
                // Ends when the process does, which closes the pipe.
                std::thread::spawn(move || listen(index, out, &say));
            }
        }
        Ok(fleet)
    }

    /// Fills the rows until every planner is done.
    pub(super) fn watch(
        mut self,
        rows: &mut [Row],
        deadline: Duration,
        stop: &Arc<AtomicBool>,
        progress: &mut Progress,
    ) -> Result<(), CliError> {
        let end = Instant::now() + PATIENCE + deadline;
        let mut listening = rows.len();
        while listening > 0 {
            if stop.load(Ordering::Relaxed) {
                return Err(CliError::Interrupted);
            }
            match self.said.recv_timeout(TICK) {
                Ok((index, Some(message))) => {
                    progress.tell(index, &rows[index], &message);
                    rows[index].take(message);
                }
                Ok((_, None)) => listening -= 1,
                Err(RecvTimeoutError::Timeout) if Instant::now() < end => {}
                Err(_) => break,
            }
        }
        self.end();
        rows.iter_mut().for_each(Row::end);
        Ok(())
    }

    /// Ends and reaps every planner; those that have said their last word end by themselves.
    fn end(&mut self) {
        for child in &mut self.children {
            if !reaped(child) {
                // A child that is not reaped yet is the one that was started, whatever its number.
                let _ = child.kill();
                let _ = child.wait();
            }
        }
        self.children.clear();
    }
}

/// The file of this program.
pub(super) fn this_program() -> Result<PathBuf, OwnDaemonError> {
    std::env::current_exe().map_err(|source| OwnDaemonError::Start {
        program: "taut".into(),
        source,
    })
}

/// The command that plans for a row.
fn planner(daemon: &OwnDaemon, row: &Row, deadline: Duration) -> Result<Command, OwnDaemonError> {
    let mut command = own_daemon::command(&this_program()?, daemon.instance());
    command
        .arg("demo-planner")
        .arg(shipped::problem_file(daemon.folder(), &row.problem))
        .args(["--seed", &row.seed.to_string()])
        .args(["--deadline", &format!("{}us", deadline.as_micros())])
        .stdin(Stdio::null())
        .stdout(Stdio::piped());
    Ok(command)
}

/// A planner that closed its pipe is about to end.
fn reaped(child: &mut Child) -> bool {
    let end = Instant::now() + Duration::from_secs(1);
    while Instant::now() < end {
        if !matches!(child.try_wait(), Ok(None)) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    false
}

impl Drop for Fleet {
    fn drop(&mut self) {
        for child in &mut self.children {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn listen(index: usize, out: ChildStdout, say: &Sender<(usize, Option<Message>)>) {
    for line in BufReader::new(out)
        .lines()
        .map_while(Result::ok)
    {
        // The demo may have ended meanwhile.
        let _ = say.send((index, Some(message(&line))));
    }
    let _ = say.send((index, None));
}

fn message(line: &str) -> Message {
    serde_json::from_str(line).unwrap_or_else(|_| Message::Failed {
        error: format!("unreadable: {line}"),
    })
}
