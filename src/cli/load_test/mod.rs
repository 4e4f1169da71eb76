//! `taut load`: client processes that send as planners do, and what became of their requests.

mod asking;
pub(super) mod bare;
pub(super) mod client;
mod error;
mod fleet;
mod interrupt;
mod local;
mod orders;
mod problems;
mod process;
pub(super) mod promises;
mod report;
mod site;
mod tally;

use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use taut::optimize::Mode;

pub(super) use error::LoadError;

use super::bench::rules;
use super::error::{CliError, stdout};
use super::instance::InstanceChoice;
use super::{Format, progress_bar, quantity};
use fleet::Fleet;
use orders::{Memory, Pace, Window};
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
pub(super) struct Arguments {
    /// Client processes
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=120))]
    clients: u8,
    /// How long they send
    #[arg(long, default_value = "5s", value_parser = quantity::duration)]
    duration: Duration,
    /// Requests per second of all clients together, arriving at random
    #[arg(long, value_name = "R", value_parser = rate)]
    rate: Option<f64>,
    /// Problem files whose paths are sent; the default are shipped ones
    #[arg(long, value_name = "FILE", num_args = 1..)]
    problems: Vec<PathBuf>,
    /// Cut the paths' segments until each path has at least this many waypoints
    #[arg(long, default_value_t = 0, value_name = "N")]
    waypoints: usize,
    /// Optimizer
    #[arg(long, default_value = "hybrid", value_parser = rules::mode())]
    mode: Mode,
    /// Counted work of each request, so that all take as long whatever they find; 0 = the
    /// optimizer's own end
    #[arg(long, default_value_t = DEFAULT_BUDGET, value_name = "WORK")]
    budget: u64,
    /// Time of each request: 20ms, 1s; none without it
    #[arg(long, value_parser = quantity::duration)]
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
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Work of a request that is to take some milliseconds.
const DEFAULT_BUDGET: u64 = 6_000;

fn rate(text: &str) -> Result<f64, String> {
    let rate = text
        .parse()
        .ok()
        .filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    rate.ok_or_else(|| "give requests per second, more than 0".to_owned())
}

/// Runs the test.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    interrupt::listen()?;
    let setup = Setup {
        workers: arguments.workers,
        files: arguments.problems.clone(),
        waypoints: arguments.waypoints,
        ..Setup::default()
    };
    let site = match arguments.spawn_daemon {
        true => Site::own(&setup)?,
        false => Site::existing(arguments.instance.instance()?, &setup)?,
    };
    let clients = usize::from(arguments.clients);
    let mut fleet = Fleet::start(site.instance(), &site.jobs, 0, clients)?;
    let memory: Vec<Memory> = fleet.0.iter().map(|member| member.memory).collect();
    let pid = site.pid().ok_or_else(|| site.gone())?;
    let cpu = process::cpu_ns_of(pid);
    let tallies = watched(&mut fleet, arguments.window(), arguments.duration)?;
    let spent = process::cpu_ns_of(pid).saturating_sub(cpu);
    if site.pid() != Some(pid) {
        return Err(site.gone().into());
    }
    drop(fleet);
    let report = Report::new(&tallies, &memory, spent, arguments.seed);
    let text = match arguments.format {
        Format::Json => {
            serde_json::to_string(&report).expect("a report holds only numbers and maps") + "\n"
        }
        Format::Table => report.table(),
    };
    std::io::stdout()
        .lock()
        .write_all(text.as_bytes())
        .map_err(stdout)?;
    Ok(u8::from(!report.is_sound()))
}

impl Arguments {
    fn window(&self) -> Window {
        let clients = f64::from(self.clients);
        let pace = self.rate.map_or(Pace::Closed, |rate| Pace::Open {
            rate_hz: rate / clients,
        });
        Window {
            seed: self.seed,
            pace,
            mode: wire_mode(self.mode),
            budget: self.budget,
            deadline_ns: self
                .deadline
                .map_or(0, |deadline| deadline.as_nanos() as u64),
            ..Window::closed()
        }
    }
}

/// Number of a mode on the wire.
fn wire_mode(mode: Mode) -> u32 {
    mode as u32
}

/// Runs a window under a progress bar.
fn watched(fleet: &mut Fleet, window: Window, length: Duration) -> Result<Vec<Tally>, LoadError> {
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
