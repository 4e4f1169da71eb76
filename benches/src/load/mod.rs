//! `taut-bench load`: client processes that send as planners do, and what became of their requests.
//!
//! [`site`] has the daemon under test and what is sent to it, [`fleet`] the processes that send it, each
//! of which runs [`client`] and is told what to do by [`orders`]; a [`tally`] is what came of it.

mod asking;
mod bare;
pub(crate) mod client;
mod control;
pub(crate) mod echo;
mod fleet;
mod interrupt;
mod jobs;
mod local;
mod orders;
mod problems;
mod process;
pub(crate) mod promises;
mod report;
mod rounds;
mod site;
mod tally;
mod times;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use taut::optimize::Mode;
use taut_ipc::Instance;

use crate::error::Error;
use crate::output::{Format, json, print, progress_bar};
use crate::values;
use fleet::Fleet;
use orders::{Memory, Pace, Window, wire_mode};
use report::Report;
use site::{Setup, Site};
use tally::Tally;

/// How often the progress bar moves.
const TICK: Duration = Duration::from_millis(100);

/// Send requests from many processes at once and report what became of them
///
/// Each client is a process of its own that waits in blocking calls. Without --rate each sends its
/// next request when the last is answered; with --rate requests arrive at random (Poisson) whether
/// or not earlier ones are answered, and latency counts from the arrival. Overhead is the time from
/// sending to the answer less waiting and computing in the daemon. Equal requests must have equal
/// answers where no deadline cuts in, and every request must come to an end.
///
/// Exit code: 0 every request came to its end, 1 one was lost or answered wrongly, 69 no daemon,
/// 130 interrupted.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Client processes
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=120))]
    clients: u8,
    /// How long they send
    #[arg(long, default_value = "5s", value_parser = values::duration)]
    duration: Duration,
    /// Requests per second of all clients together, arriving at random
    #[arg(long, value_name = "R", value_parser = values::rate)]
    rate: Option<f64>,
    /// Problem files whose paths are sent; the default are shipped ones
    #[arg(long, value_name = "FILE", num_args = 1..)]
    problems: Vec<PathBuf>,
    /// Cut the paths' segments until each path has at least this many waypoints
    #[arg(long, default_value_t = 0, value_name = "N")]
    waypoints: usize,
    /// Optimizer
    #[arg(long, default_value = "hybrid", value_parser = values::mode())]
    mode: Mode,
    /// Counted work of each request, so that all take as long whatever they find; 0 = the
    /// optimizer's own end
    #[arg(long, default_value_t = DEFAULT_BUDGET, value_name = "WORK")]
    budget: u64,
    /// Time of each request: 20ms, 1s; none without it
    #[arg(long, value_parser = values::duration)]
    deadline: Option<Duration>,
    /// Start a daemon for the test, which ends with it
    #[arg(long, conflicts_with = "instance")]
    spawn_daemon: bool,
    /// Its worker threads; 0 = one per core
    #[arg(long, default_value_t = 0, value_name = "N", requires = "spawn_daemon")]
    workers: usize,
    /// Seed of arrivals and choices
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Instance of the daemon: NAME, or NAME:/ROOT; the default is TAUT_INSTANCE
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Work of a request that is to take some milliseconds.
const DEFAULT_BUDGET: u64 = 6_000;

/// Runs the test.
pub(crate) fn run(arguments: &Arguments) -> Result<u8, Error> {
    interrupt::listen()?;
    let site = arguments.site()?;
    let report = report(arguments, &site)?;
    print(&match arguments.format {
        Format::Json => json(&report),
        Format::Table => report.table(),
    })?;
    Ok(u8::from(!report.is_sound()))
}

fn report(arguments: &Arguments, site: &Site) -> Result<Report, Error> {
    let clients = usize::from(arguments.clients);
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, clients)?;
    let memory: Vec<Memory> = fleet
        .0
        .iter()
        .map(|member| member.memory)
        .collect();
    let pid = site.serving()?;
    let before = process::cpu_ns_of(pid);
    let tallies = watched(&mut fleet, arguments.window(), arguments.duration)?;
    let spent = process::cpu_ns_of(pid).saturating_sub(before);
    match site.pid() == Some(pid) {
        true => Ok(Report::new(&tallies, &memory, spent, arguments.seed)),
        false => Err(site.gone()),
    }
}

impl Arguments {
    fn site(&self) -> Result<Site, Error> {
        let setup = Setup {
            workers: self.workers,
            files: self.problems.clone(),
            waypoints: self.waypoints,
            ..Setup::default()
        };
        match self.spawn_daemon {
            true => Site::own(&setup),
            false => Site::existing(self.instance()?, &setup),
        }
    }

    /// The option, else the environment, else the default.
    fn instance(&self) -> Result<Instance, Error> {
        let instance = match &self.instance {
            Some(text) => Instance::parse(text),
            None => Instance::from_environment(),
        };
        instance.map_err(|error| Error::Usage(error.to_string()))
    }

    fn window(&self) -> Window {
        let clients = f64::from(self.clients);
        let pace = self
            .rate
            .map_or(Pace::Closed, |rate| Pace::Open {
                rate_hz: rate / clients,
            });
        Window {
            seed: self.seed,
            pace,
            mode: wire_mode(self.mode),
            budget: self.budget,
            deadline_ns: self
                .deadline
                .map_or(0, |time| time.as_nanos() as u64),
            ..Window::closed()
        }
    }
}

/// Runs a window under a progress bar.
fn watched(fleet: &mut Fleet, window: Window, length: Duration) -> Result<Vec<Tally>, Error> {
    let bar = progress_bar(length.as_millis() as u64);
    bar.set_message("ms");
    fleet.begin(window, length)?;
    let start = Instant::now();
    while start.elapsed() < length {
        interrupt::check()?;
        bar.set_position(start.elapsed().as_millis() as u64);
        std::thread::sleep(TICK.min(length.saturating_sub(start.elapsed())));
    }
    let tallies = fleet.finish(length);
    bar.finish_and_clear();
    tallies
}
