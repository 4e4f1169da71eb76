//! `taut-bench load-client`, hidden: one planner process of a load test. It sends what it is told to,
//! line by line.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender, bounded};
use taut::files::Reader;
use taut::optimize::Mode;
use taut_ipc::limits::ACTIVE_REQUESTS_PER_CLIENT;
use taut_ipc::wire::{self, Code, RequestFlags};
use taut_ipc::{Client, ClientError, Instance, monotonic_ns};

use super::asking::Asker;
use super::echo::Caller;
use super::local::Bench;
use super::orders::{Job, Memory, Order, Pace, Point, Said, Window};
use super::problems::Problem;
use super::process::{self, sleep_until};
use super::tally::Tally;
use crate::clock::process_cpu_ns;
use crate::error::Error;

/// Answers before the memory of a connection is looked at.
const WARM_UP: u64 = 3;
/// How long the first improvement of a stream may take.
const FIRST_IMPROVEMENT: Duration = Duration::from_secs(20);
/// Work of each request of a planner without a daemon.
const COMPUTED_WORK: u64 = 6_000;

/// Obeys standard input until it is closed.
pub(crate) fn run() -> Result<u8, Error> {
    process::end_with_parent()?;
    let mut obedient = Obedient::default();
    while let Some(line) = next_line() {
        let order = serde_json::from_str(&line);
        drop(line);
        let said = match order {
            Ok(order) => obedient.obey(order)?,
            Err(error) => Some(Said::Failed(format!("an order cannot be read: {error}"))),
        };
        said.iter().for_each(say);
        if matches!(said, Some(Said::Failed(_))) {
            return Ok(1);
        }
    }
    Ok(0)
}

/// What the orders so far have made of this process.
#[derive(Default)]
struct Obedient {
    asks: Option<Asks>,
    /// Planners without a daemon, kept for their memory.
    computing: Vec<(Vec<Problem>, Bench)>,
}

/// Whom this process asks.
enum Asks {
    Daemon(Planner),
    Echo(Box<Caller>),
}

impl Asks {
    fn run(&self, window: &Window) -> Result<Tally, Error> {
        match self {
            Self::Daemon(planner) => Ok(planner.run(window)),
            Self::Echo(caller) => caller.run(window),
        }
    }
}

impl Obedient {
    /// What there is to say to an order.
    fn obey(&mut self, order: Order) -> Result<Option<Said>, Error> {
        let said = match (order, &self.asks) {
            (Order::Connect(jobs, number), _) => self.connect(jobs, number),
            (Order::Echo, _) => self.connect_to_echo(),
            (Order::Compute(files), _) => return self.compute(&files).map(Some),
            (Order::Run(window), Some(asks)) => asks
                .run(&window)
                .map(|tally| Said::Done(Box::new(tally))),
            (Order::StayAt(point, window), Some(Asks::Daemon(planner))) => {
                let stayed = planner.stay_at(point, &window).err();
                return Ok(stayed.map(|error| Said::Failed(error.to_string())));
            }
            _ => return Ok(Some(Said::Failed("it is connected to nobody".to_owned()))),
        };
        Ok(Some(
            said.unwrap_or_else(|error| Said::Failed(error.to_string())),
        ))
    }

    fn connect(&mut self, jobs: Vec<Job>, number: u64) -> Result<Said, Error> {
        let (planner, memory) = Planner::connect(jobs, number)?;
        self.asks = Some(Asks::Daemon(planner));
        Ok(Said::Ready(memory))
    }

    fn connect_to_echo(&mut self) -> Result<Said, Error> {
        let caller = Caller::open(&Instance::from_environment()?)?;
        self.asks = Some(Asks::Echo(Box::new(caller)));
        Ok(Said::Ready(Memory::default()))
    }

    fn compute(&mut self, files: &[PathBuf]) -> Result<Said, Error> {
        let (memory, planner) = compute(files)?;
        self.computing.push(planner);
        Ok(Said::Ready(memory))
    }
}

/// A planner without a daemon: robot, scene and optimizer are its own.
fn compute(files: &[PathBuf]) -> Result<(Memory, (Vec<Problem>, Bench)), Error> {
    let before = process::private_bytes(std::process::id());
    let mut reader = Reader::default();
    let problems: Result<Vec<Problem>, Error> = files
        .iter()
        .map(|file| Problem::read(&mut reader, file, 0))
        .collect();
    let problems = problems?;
    let mut bench = Bench::default();
    // Each once.
    bench.run(&problems, Mode::Hybrid, COMPUTED_WORK, Duration::ZERO);
    let after = process::private_bytes(std::process::id());
    Ok((Memory { before, after }, (problems, bench)))
}

/// The next line of standard input, which is not locked meanwhile; `None` once it is closed.
fn next_line() -> Option<String> {
    let mut line = String::new();
    let read = std::io::stdin().read_line(&mut line).ok()?;
    (read > 0).then_some(line)
}

/// A parent that is gone does not read; then there is nobody to tell.
fn say(said: &Said) {
    let line = serde_json::to_string(said).expect("a line holds only strings, numbers and lists");
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// The connected client.
struct Planner {
    client: Client,
    jobs: Vec<Job>,
    number: u64,
}

impl Planner {
    /// Connects, and tells what that takes.
    fn connect(jobs: Vec<Job>, number: u64) -> Result<(Self, Memory), Error> {
        let before = process::private_bytes(std::process::id());
        let planner = Self {
            client: Client::connect(&Instance::from_environment()?)?,
            jobs,
            number,
        };
        planner.warm_up();
        let after = process::private_bytes(std::process::id());
        Ok((planner, Memory { before, after }))
    }

    fn warm_up(&self) {
        let window = Window {
            mode: wire::Mode::Check.into(),
            flags: RequestFlags::WITHOUT_CONTACTS,
            ..Window::closed()
        };
        for _ in 0..WARM_UP {
            self.asker(&window).ask(0, monotonic_ns());
        }
    }

    fn asker<'a>(&'a self, window: &'a Window) -> Asker<'a> {
        Asker::new(&self.client, &self.jobs, window, self.number)
    }

    /// Sends until the window is over and every request has ended.
    fn run(&self, window: &Window) -> Tally {
        sleep_until(window.start_ns);
        let start = monotonic_ns();
        let cpu = process_cpu_ns();
        let tally = self.paced(window);
        Tally {
            cpu_ns: process_cpu_ns() - cpu,
            elapsed_ns: monotonic_ns() - start,
            ..tally
        }
    }

    fn paced(&self, window: &Window) -> Tally {
        match window.pace {
            Pace::Closed => self.in_turn(window, |asker| {
                let hint = asker.ask_next();
                sleep_until((monotonic_ns() + hint.as_nanos() as u64).min(window.end_ns));
            }),
            Pace::Cancel { within_ns } => {
                self.in_turn(window, |asker| asker.cancel_next(within_ns))
            }
            Pace::Sleep => self.in_turn(window, |asker| sleep(&mut asker.tally, window)),
            Pace::Greedy => self.on_all_slots(window),
            Pace::Open { rate_hz } => self.open(window, rate_hz),
        }
    }

    fn in_turn(&self, window: &Window, mut once: impl FnMut(&mut Asker)) -> Tally {
        let mut asker = self.asker(window);
        while monotonic_ns() < window.end_ns
            && (window.count == 0 || asker.tally.sent < window.count)
        {
            once(&mut asker);
        }
        asker.tally
    }

    /// A thread for each request that may be in flight.
    fn on_all_slots(&self, window: &Window) -> Tally {
        let all = Mutex::new(Tally::default());
        std::thread::scope(|scope| {
            for _ in 0..ACTIVE_REQUESTS_PER_CLIENT {
                scope.spawn(|| {
                    let tally = self.in_turn(window, |asker| _ = asker.ask_next());
                    all.lock()
                        .expect("no thread panics")
                        .merge(&tally);
                });
            }
        });
        all.into_inner().expect("no thread panics")
    }

    /// Arrivals of a Poisson process; those that find every slot taken are refused as the transport
    /// would.
    fn open(&self, window: &Window, rate_hz: f64) -> Tally {
        let (give, take) = bounded::<Arrival>(0);
        let all = Mutex::new(Tally::default());
        std::thread::scope(|scope| {
            for _ in 0..ACTIVE_REQUESTS_PER_CLIENT {
                let take = take.clone();
                let all = &all;
                scope.spawn(move || {
                    let tally = self.served(window, &take);
                    all.lock()
                        .expect("no thread panics")
                        .merge(&tally);
                });
            }
            drop(take);
            let refused = self.arrive(window, rate_hz, &give);
            drop(give);
            all.lock()
                .expect("no thread panics")
                .merge(&refused);
        });
        all.into_inner().expect("no thread panics")
    }

    /// Sends what arrives.
    fn served(&self, window: &Window, take: &Receiver<Arrival>) -> Tally {
        let mut asker = self.asker(window);
        for (job, arrived_ns) in take {
            asker.ask(job, arrived_ns);
        }
        asker.tally
    }

    /// Lets requests arrive until the window is over; tells of those that nobody takes.
    fn arrive(&self, window: &Window, rate_hz: f64, give: &Sender<Arrival>) -> Tally {
        let mut arrivals = self.asker(window);
        let mut refused = Tally::default();
        let mut count = 0;
        let mut at = monotonic_ns().max(window.start_ns);
        loop {
            at += (-(1.0 - arrivals.random()).ln() / rate_hz * 1e9) as u64;
            if at >= window.end_ns || (window.count != 0 && count >= window.count) {
                return refused;
            }
            sleep_until(at);
            count += 1;
            if give.try_send((arrivals.choose(), at)).is_err() {
                refused.sent += 1;
                refused.refuse(Code::Quota);
            }
        }
    }

    /// Goes there and stays until the orders end.
    fn stay_at(&self, point: Point, window: &Window) -> Result<(), ClientError> {
        let mut asker = self.asker(window);
        match point {
            Point::Loaned => {
                let _loan = asker.loan(0)?;
                stay(point);
            }
            Point::Sent => {
                let _pending = asker.loan(0)?.send()?;
                stay(point);
            }
            Point::Streaming => {
                let mut pending = asker.loan(0)?.send()?;
                let _improvement = pending.next(FIRST_IMPROVEMENT)?;
                stay(point);
            }
            Point::Anywhere => stay_anywhere(&mut asker),
        }
        Ok(())
    }
}

fn stay_anywhere(asker: &mut Asker) {
    let waits = std::thread::spawn(next_line);
    say(&Said::At(Point::Anywhere));
    while !waits.is_finished() {
        asker.ask_next();
    }
}

/// The number of a job, and when it arrived (ns).
type Arrival = (usize, u64);

/// Says where it is and waits for the end of the orders.
fn stay(point: Point) {
    say(&Said::At(point));
    next_line();
}

/// Sleeps to a deadline as if it were a request's.
fn sleep(tally: &mut Tally, window: &Window) {
    let deadline_ns = monotonic_ns() + window.deadline_ns;
    sleep_until(deadline_ns);
    tally.sent += 1;
    let late_ns = monotonic_ns().saturating_sub(deadline_ns);
    tally.lateness.add(late_ns);
}
