//! The client processes, and the pipes to them.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, unbounded};
use rustix::process::{Pid, Signal, kill_process};
use taut_ipc::own_daemon::spawn;
use taut_ipc::{Instance, monotonic_ns};

use super::interrupt;
use super::orders::{Job, Memory, Order, Point, Said, Window};
use super::tally::Tally;
use crate::error::Error;
use crate::program;

/// Time from the order to the beginning, so that all begin together.
const LEAD: Duration = Duration::from_millis(20);
/// How long a client may take beyond its window, with every request ending by its own patience.
const PATIENCE: Duration = Duration::from_secs(90);
/// How often a signal is looked for.
const TICK: Duration = Duration::from_millis(100);

/// One client process; killed when dropped.
pub(super) struct Member {
    number: usize,
    child: Child,
    orders: Option<ChildStdin>,
    said: Receiver<Said>,
    /// Its private memory when it had connected.
    pub memory: Memory,
}

impl Member {
    /// Starts it and lets it connect.
    pub(super) fn start(instance: &Instance, jobs: &[Job], number: usize) -> Result<Self, Error> {
        let mut member = Self::launch(instance, number)?;
        member.tell(&Order::Connect(jobs.to_vec(), number as u64))?;
        member.memory = member.ready()?;
        Ok(member)
    }

    /// Starts a planner without a daemon and lets it read its problems.
    fn computing(instance: &Instance, files: &[PathBuf], number: usize) -> Result<Self, Error> {
        let mut member = Self::launch(instance, number)?;
        member.tell(&Order::Compute(files.to_vec()))?;
        member.memory = member.ready()?;
        Ok(member)
    }

    /// Starts a client of the echo and lets it connect.
    fn of_echo(instance: &Instance, number: usize) -> Result<Self, Error> {
        let mut member = Self::launch(instance, number)?;
        member.tell(&Order::Echo)?;
        member.ready()?;
        Ok(member)
    }

    fn launch(instance: &Instance, number: usize) -> Result<Self, Error> {
        let mut command = program::again(instance)?;
        command
            .arg("load-client")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .process_group(0);
        let mut child = spawn(command)?;
        let (say, said) = unbounded();
        let out = child.stdout.take();
        // Ends when the process does, which closes the pipe.
        std::thread::spawn(move || listen(out, &say));
        Ok(Self {
            number,
            orders: child.stdin.take(),
            child,
            said,
            memory: Memory::default(),
        })
    }

    /// Its process.
    pub(super) fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Sends it a line.
    pub(super) fn tell(&mut self, order: &Order) -> Result<(), Error> {
        let line = serde_json::to_string(order)
            .expect("an order holds only strings, numbers and lists")
            + "\n";
        let written = self
            .orders
            .as_mut()
            .map(|orders| orders.write_all(line.as_bytes()));
        match written {
            Some(Ok(())) => Ok(()),
            _ => Err(self.ended()),
        }
    }

    fn failed(&self, reason: String) -> Error {
        Error::Process {
            number: self.number,
            reason,
        }
    }

    fn ended(&self) -> Error {
        self.failed("it ended".to_owned())
    }

    fn unexpected(&self, said: &Said) -> Error {
        self.failed(format!("unexpected line {said:?}"))
    }

    fn hear(&self, within: Duration) -> Result<Said, Error> {
        let end = Instant::now() + within;
        loop {
            interrupt::check()?;
            match self.said.recv_timeout(TICK) {
                Ok(Said::Failed(reason)) => return Err(self.failed(reason)),
                Ok(said) => return Ok(said),
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended()),
                Err(RecvTimeoutError::Timeout) if Instant::now() >= end => {
                    return Err(Error::Silent(self.number));
                }
                Err(RecvTimeoutError::Timeout) => (),
            }
        }
    }

    fn ready(&self) -> Result<Memory, Error> {
        match self.hear(PATIENCE)? {
            Said::Ready(memory) => Ok(memory),
            other => Err(self.unexpected(&other)),
        }
    }

    /// Waits for what came of a window of this length.
    pub(super) fn done(&self, window: Duration) -> Result<Tally, Error> {
        match self.hear(window + PATIENCE)? {
            Said::Done(tally) => Ok(*tally),
            other => Err(self.unexpected(&other)),
        }
    }

    /// Sends it to a point of a request and waits until it is there.
    pub(super) fn stay_at(&mut self, point: Point, window: Window) -> Result<(), Error> {
        self.tell(&Order::StayAt(point, window))?;
        match self.hear(PATIENCE)? {
            Said::At(_) => Ok(()),
            other => Err(self.unexpected(&other)),
        }
    }

    /// Sends it a signal.
    pub(super) fn signal(&self, signal: Signal) {
        // A child that is not reaped yet keeps its number, so that this cannot meet another
        // process.
        let _ = kill_process(Pid::from_child(&self.child), signal);
    }

    /// Ends it at once (SIGKILL).
    pub(super) fn kill(mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Lets it end by itself, by closing its orders.
    pub(super) fn let_go(mut self) -> Result<(), Error> {
        drop(self.orders.take());
        let end = Instant::now() + PATIENCE;
        while matches!(self.child.try_wait(), Ok(None)) {
            interrupt::check()?;
            if Instant::now() >= end {
                return Err(Error::Silent(self.number));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }
}

impl Drop for Member {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Passes on what a client says.
fn listen(out: Option<ChildStdout>, say: &Sender<Said>) {
    let lines = out
        .into_iter()
        .flat_map(|out| BufReader::new(out).lines());
    for line in lines.map_while(Result::ok) {
        let said = serde_json::from_str(&line)
            .unwrap_or_else(|error| Said::Failed(format!("unreadable line: {error}")));
        // The member may be gone meanwhile.
        let _ = say.send(said);
    }
}

/// Connected clients.
pub(super) struct Fleet(pub Vec<Member>);

impl Fleet {
    /// Starts so many, numbered from `first`.
    pub(super) fn start(
        instance: &Instance,
        jobs: &[Job],
        first: usize,
        count: usize,
    ) -> Result<Self, Error> {
        // All processes come up at once; each then connects.
        let members: Result<Vec<Member>, Error> = (first..first + count)
            .map(|number| Member::launch(instance, number))
            .collect();
        let mut members = members?;
        for member in &mut members {
            let number = member.number as u64;
            member.tell(&Order::Connect(jobs.to_vec(), number))?;
        }
        for member in &mut members {
            member.memory = member.ready()?;
        }
        Ok(Self(members))
    }

    /// So many planners without a daemon, each with these problems.
    pub(super) fn computing(
        instance: &Instance,
        files: &[PathBuf],
        count: usize,
    ) -> Result<Self, Error> {
        let members = (0..count).map(|number| Member::computing(instance, files, number));
        Ok(Self(members.collect::<Result<_, Error>>()?))
    }

    /// So many clients of the echo.
    pub(super) fn of_echo(instance: &Instance, count: usize) -> Result<Self, Error> {
        let members = (0..count).map(|number| Member::of_echo(instance, number));
        Ok(Self(members.collect::<Result<_, Error>>()?))
    }

    /// Lets every client send for so long; tells what came of each.
    pub(super) fn run(&mut self, window: Window, length: Duration) -> Result<Vec<Tally>, Error> {
        self.begin(window, length)?;
        self.finish(length)
    }

    /// The first half of [`Self::run`]: the window begins soon.
    pub(super) fn begin(&mut self, window: Window, length: Duration) -> Result<Window, Error> {
        let window = timed(window, length);
        for member in &mut self.0 {
            member.tell(&Order::Run(window))?;
        }
        Ok(window)
    }

    /// The second half.
    pub(super) fn finish(&mut self, length: Duration) -> Result<Vec<Tally>, Error> {
        self.0
            .iter()
            .map(|member| member.done(length))
            .collect()
    }
}

/// A window that begins soon.
fn timed(window: Window, length: Duration) -> Window {
    let start_ns = monotonic_ns() + LEAD.as_nanos() as u64;
    Window {
        start_ns,
        end_ns: start_ns + length.as_nanos() as u64,
        ..window
    }
}
