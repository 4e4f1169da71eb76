//! Client processes on hosts.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use taut_ipc::Instance;

use crate::error::Error;
use crate::network::Host;
use crate::orders::{Asking, Exchange, Job, Mutating, Order, Said, Tally};
use crate::process::Process;
use crate::programs::own;

/// How long a client may take beyond what it is told.
const PATIENCE: Duration = Duration::from_secs(120);

/// One client process; killed when dropped.
#[derive(Debug)]
pub(crate) struct Member {
    process: Process,
    orders: ChildStdin,
    said: Receiver<Said>,
}

impl Member {
    /// A planner of an instance of this host.
    pub(crate) fn planner(host: &Host, instance: &Instance) -> Result<Self, Error> {
        Self::start(host, instance, &Order::Planner)
    }

    /// A planner without a helper process.
    pub(crate) fn direct(host: &Host, connect: &str) -> Result<Self, Error> {
        let order = Order::Direct(connect.to_owned());
        Self::start(host, &host.instance("none")?, &order)
    }

    /// A client of the bare echo.
    pub(crate) fn bare(host: &Host, connect: &str) -> Result<Self, Error> {
        Self::start(
            host,
            &host.instance("none")?,
            &Order::Bare(connect.to_owned()),
        )
    }

    /// A process that sends mutated messages; what comes of them is got by [`Self::mutated`].
    pub(crate) fn mutate(host: &Host, mutating: &Mutating) -> Result<Self, Error> {
        let mut member = Self::launch(host, &host.instance("none")?)?;
        member.tell(&Order::Mutate(mutating.clone()))?;
        Ok(member)
    }

    /// What came of the mutated messages; `None` while they are being sent.
    pub(crate) fn mutated(&mut self, within: Duration) -> Result<Option<Tally>, Error> {
        match self.said.recv_timeout(within) {
            Ok(Said::Done(tally)) => Ok(Some(*tally)),
            Ok(other) => Err(self.unexpected(&other)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(self.process.failed("ended")),
        }
    }

    fn start(host: &Host, instance: &Instance, first: &Order) -> Result<Self, Error> {
        let mut member = Self::launch(host, instance)?;
        member.tell(first)?;
        match member.hear(PATIENCE)? {
            Said::Ready => Ok(member),
            other => Err(member.unexpected(&other)),
        }
    }

    fn launch(host: &Host, instance: &Instance) -> Result<Self, Error> {
        let mut command = host.command(&own()?, instance);
        command
            .arg("client")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut process = Process::start(&format!("a client on {}", host.name()), command)?;
        let (orders, out) = process
            .pipes()
            .expect("it was started with pipes");
        let (say, said) = channel();
        // Ends when the process does, which closes the pipe.
        std::thread::spawn(move || listen(out, &say));
        Ok(Self {
            process,
            orders,
            said,
        })
    }

    /// Lets it load the model of a folder.
    pub(crate) fn load(&mut self, folder: &Path) -> Result<(), Error> {
        self.tell(&Order::Load(folder.to_owned()))?;
        match self.hear(PATIENCE)? {
            Said::Ready => Ok(()),
            other => Err(self.unexpected(&other)),
        }
    }

    /// The process.
    pub(crate) fn process(&self) -> &Process {
        &self.process
    }

    /// Lets it ask; what comes of it is got by [`Self::done`].
    pub(crate) fn begin(&mut self, asking: &Asking) -> Result<(), Error> {
        self.tell(&Order::Ask(asking.clone()))
    }

    /// What came of what it was told last.
    pub(crate) fn done(&mut self, asking: &Asking) -> Result<Tally, Error> {
        let longest = Duration::from_millis(asking.length_ms + asking.patience_ms);
        self.tally(longest + PATIENCE)
    }

    /// Lets it ask, and waits.
    pub(crate) fn ask(&mut self, asking: &Asking) -> Result<Tally, Error> {
        self.begin(asking)?;
        self.done(asking)
    }

    /// Lets it ask the echo, and waits.
    pub(crate) fn exchange(&mut self, exchange: Exchange) -> Result<Tally, Error> {
        self.tell(&Order::Exchange(exchange))?;
        self.tally(PATIENCE)
    }

    /// Lets it hold the answers to a request whose first improvement has come.
    pub(crate) fn hold(&mut self, job: &Job) -> Result<(), Error> {
        self.tell(&Order::Hold(Box::new(job.clone())))?;
        self.at().map(|_| ())
    }

    /// Lets it drop them; tells when (ns, monotonic clock).
    pub(crate) fn cancel(&mut self) -> Result<u64, Error> {
        self.tell(&Order::Cancel)?;
        self.at()
    }

    fn at(&mut self) -> Result<u64, Error> {
        match self.hear(PATIENCE)? {
            Said::At(at) => Ok(at),
            other => Err(self.unexpected(&other)),
        }
    }

    fn tally(&mut self, within: Duration) -> Result<Tally, Error> {
        match self.hear(within)? {
            Said::Done(tally) => Ok(*tally),
            other => Err(self.unexpected(&other)),
        }
    }

    fn tell(&mut self, order: &Order) -> Result<(), Error> {
        let line = serde_json::to_string(order)
            .expect("an order holds only strings, numbers and lists")
            + "\n";
        let written = self.orders.write_all(line.as_bytes());
        written.map_err(|_| self.process.failed("ended"))
    }

    fn hear(&mut self, within: Duration) -> Result<Said, Error> {
        let said = self.said.recv_timeout(within);
        match said {
            Ok(Said::Failed(reason)) => Err(self.process.failed(reason)),
            Ok(said) => Ok(said),
            Err(error) => Err(self
                .process
                .failed(format!("says nothing: {error}"))),
        }
    }

    fn unexpected(&self, said: &Said) -> Error {
        self.process
            .failed(format!("unexpected line {said:?}"))
    }
}

/// Passes on what a client says.
fn listen(out: ChildStdout, say: &Sender<Said>) {
    let lines = BufReader::new(out).lines();
    for line in lines.map_while(Result::ok) {
        let said = serde_json::from_str(&line)
            .unwrap_or_else(|error| Said::Failed(format!("unreadable line: {error}")));
        // The member may be gone meanwhile.
        let _ = say.send(said);
    }
}

/// So many planners of an instance of this host.
pub(crate) fn planners(
    host: &Host,
    instance: &Instance,
    count: usize,
) -> Result<Vec<Member>, Error> {
    (0..count)
        .map(|_| Member::planner(host, instance))
        .collect()
}

/// Lets all of them ask at once; what came of each.
pub(crate) fn all(members: &mut [Member], asking: &Asking) -> Result<Vec<Tally>, Error> {
    begin(members, asking)?;
    finish(members, asking)
}

/// The first half of [`all`].
pub(crate) fn begin(members: &mut [Member], asking: &Asking) -> Result<(), Error> {
    members
        .iter_mut()
        .try_for_each(|member| member.begin(asking))
}

/// The second half.
pub(crate) fn finish(members: &mut [Member], asking: &Asking) -> Result<Vec<Tally>, Error> {
    members
        .iter_mut()
        .map(|member| member.done(asking))
        .collect()
}
