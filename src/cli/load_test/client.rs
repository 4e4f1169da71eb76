//! `taut load-client`, hidden: one planner process of a load test. It sends what it is told to,
//! line by line.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Duration;

use crossbeam_channel::bounded;
use taut::files::Reader;
use taut::optimize::Mode;
use taut_ipc::limits::ACTIVE_REQUESTS_PER_CLIENT;
use taut_ipc::wire::{self, Code, RequestFlags};
use taut_ipc::{Client, Instance, monotonic_ns};

use super::asking::Asker;
use super::local::Bench;
use super::orders::{Job, Memory, Order, Pace, Point, Said, Window};
use super::problems::Problem;
use super::process::{self, cpu_ns};
use super::tally::Tally;
use crate::cli::error::CliError;

/// Answers before the memory of a connection is looked at.
const WARM_UP: u64 = 3;
/// How long the first improvement of a stream may take.
const FIRST_IMPROVEMENT: Duration = Duration::from_secs(20);
/// Work of each request of a planner without a daemon.
const COMPUTED_WORK: u64 = 6_000;

/// Obeys standard input until it is closed.
pub(in crate::cli) fn run() -> Result<u8, CliError> {
    process::end_with_parent()?;
    let mut planner = None;
    let mut computing = Vec::new();
    while let Some(line) = next_line() {
        let order: Order = match serde_json::from_str(&line) {
            Ok(order) => order,
            Err(error) => return Ok(failed(&format!("an order cannot be read: {error}"))),
        };
        drop(line);
        match (order, &planner) {
            (Order::Connect(jobs, number), _) => match Planner::connect(jobs, number) {
                Ok((connected, memory)) => {
                    say(&Said::Ready(memory));
                    planner = Some(connected);
                }
                Err(error) => return Ok(failed(&error)),
            },
            (Order::Compute(files), _) => {
                let (memory, planner) = compute(&files)?;
                computing.push(planner);
                say(&Said::Ready(memory));
            }
            (Order::Run(window), Some(planner)) => say(&Said::Done(Box::new(planner.run(&window)))),
            (Order::StayAt(point, window), Some(planner)) => planner.stay_at(point, &window),
            (_, None) => return Ok(failed("the first order has to be to connect")),
        }
    }
    Ok(0)
}

/// A planner without a daemon: robot, scene and optimizer are its own.
fn compute(files: &[PathBuf]) -> Result<(Memory, (Vec<Problem>, Bench)), CliError> {
    let before = process::private_bytes(std::process::id());
    let mut reader = Reader::default();
    let problems: Result<Vec<Problem>, CliError> = files
        .iter()
        .map(|file| Problem::read(&mut reader, file, 0))
        .collect();
    let problems = problems?;
    let mut bench = Bench::default();
    for _ in &problems {
        bench.run(
            &problems,
            Mode::Hybrid,
            COMPUTED_WORK,
            Duration::from_nanos(1),
        );
    }
    let after = process::private_bytes(std::process::id());
    Ok((Memory { before, after }, (problems, bench)))
}

fn failed(error: &str) -> u8 {
    say(&Said::Failed(error.to_owned()));
    1
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
    fn connect(jobs: Vec<Job>, number: u64) -> Result<(Self, Memory), String> {
        let before = process::private_bytes(std::process::id());
        let instance = Instance::from_environment().map_err(|error| error.to_string())?;
        let client = Client::connect(&instance).map_err(|error| error.to_string())?;
        let planner = Self {
            client,
            jobs,
            number,
        };
        let window = Window {
            mode: wire::Mode::Check.into(),
            flags: RequestFlags::WITHOUT_CONTACTS,
            ..Window::closed()
        };
        for _ in 0..WARM_UP {
            planner.asker(&window).ask(0, monotonic_ns());
        }
        let after = process::private_bytes(std::process::id());
        Ok((planner, Memory { before, after }))
    }

    fn asker<'a>(&'a self, window: &'a Window) -> Asker<'a> {
        Asker::new(&self.client, &self.jobs, window, self.number)
    }

    /// Sends until the window is over and every request has ended.
    fn run(&self, window: &Window) -> Tally {
        sleep_until(window.start_ns);
        let start = monotonic_ns();
        let cpu = cpu_ns();
        let mut tally = match window.pace {
            Pace::Closed => self.in_turn(window, |asker| {
                let hint = asker.ask_next();
                sleep_until((monotonic_ns() + hint.as_nanos() as u64).min(window.end_ns));
            }),
            Pace::Cancel { within_ns } => {
                self.in_turn(window, |asker| asker.cancel_next(within_ns))
            }
            Pace::Sleep => self.in_turn(window, |asker| {
                let deadline = monotonic_ns() + window.deadline_ns;
                sleep_until(deadline);
                asker.tally.sent += 1;
                asker
                    .tally
                    .lateness
                    .add(monotonic_ns().saturating_sub(deadline));
            }),
            Pace::Greedy => self.on_all_slots(window),
            Pace::Open { rate_hz } => self.open(window, rate_hz),
        };
        tally.cpu_ns = cpu_ns() - cpu;
        tally.elapsed_ns = monotonic_ns() - start;
        tally
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
                    all.lock().expect("no thread panics").merge(&tally);
                });
            }
        });
        all.into_inner().expect("no thread panics")
    }

    /// Arrivals of a Poisson process; those that find every slot taken are refused as the transport
    /// would.
    fn open(&self, window: &Window, rate_hz: f64) -> Tally {
        let (give, take) = bounded::<(usize, u64)>(0);
        let all = Mutex::new(Tally::default());
        std::thread::scope(|scope| {
            for _ in 0..ACTIVE_REQUESTS_PER_CLIENT {
                let take = take.clone();
                let all = &all;
                scope.spawn(move || {
                    let mut asker = self.asker(window);
                    for (job, arrived_ns) in take {
                        asker.ask(job, arrived_ns);
                    }
                    all.lock().expect("no thread panics").merge(&asker.tally);
                });
            }
            drop(take);
            let mut arrivals = self.asker(window);
            let mut at = monotonic_ns().max(window.start_ns);
            loop {
                at += (-(1.0 - arrivals.random()).ln() / rate_hz * 1e9) as u64;
                if at >= window.end_ns || (window.count != 0 && arrivals.tally.sent >= window.count)
                {
                    break;
                }
                sleep_until(at);
                // Counted here to see the end; asking counts it again.
                arrivals.tally.sent += 1;
                if give.try_send((arrivals.choose(), at)).is_err() {
                    let mut all = all.lock().expect("no thread panics");
                    all.sent += 1;
                    all.refuse(Code::Quota);
                }
            }
            drop(give);
        });
        all.into_inner().expect("no thread panics")
    }

    /// Goes there and stays until the orders end.
    fn stay_at(&self, point: Point, window: &Window) {
        let mut asker = self.asker(window);
        let stay = || {
            say(&Said::At(point));
            next_line()
        };
        let gone = match point {
            Point::Loaned => asker.loan(0).map(|_loan| stay()),
            Point::Sent => asker
                .loan(0)
                .and_then(|loan| loan.send())
                .map(|_pending| stay()),
            Point::Streaming => {
                asker
                    .loan(0)
                    .and_then(|loan| loan.send())
                    .and_then(|mut pending| {
                        let _improvement = pending.next(FIRST_IMPROVEMENT)?;
                        Ok(stay())
                    })
            }
            Point::Anywhere => {
                let waits = std::thread::spawn(next_line);
                say(&Said::At(point));
                while !waits.is_finished() {
                    asker.ask_next();
                }
                Ok(None)
            }
        };
        if let Err(error) = gone {
            failed(&error.to_string());
        }
    }
}

fn sleep_until(at_ns: u64) {
    let left = at_ns.saturating_sub(monotonic_ns());
    if left > 0 {
        std::thread::sleep(Duration::from_nanos(left));
    }
}
