//! `taut demo`: a daemon of its own, several planner processes at once, a table and a picture.

mod elements;
mod fleet;
mod motion;
mod panel;
mod picture;
pub(super) mod planner;
mod progress;
// The planner is the example's, so that there is one copy of what planner authors read.
mod row;
#[path = "../../../examples/planner/rrt_connect.rs"]
mod rrt_connect;
#[path = "../../../examples/planner/session.rs"]
mod session;
mod shipped;
mod table;
mod view;
mod world;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use serde::Serialize;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use taut_ipc::own_daemon::{OwnDaemon, OwnDaemonError};

use super::error::CliError;
use super::format::{Format, print};
use super::{quantity, report};
use fleet::Fleet;
use progress::Progress;
use row::Row;
use world::World;

/// Exit code where an answer is not proved.
const NOT_PROVED: u8 = 2;

/// Start a daemon and four planners on shipped robots and scenes, and show what becomes of their
/// paths
///
/// Needs no files and leaves nothing behind but the picture. Exit code: 0 all answers proved, 2
/// otherwise, 69 no daemon, 130 interrupted.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Planner processes
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=32))]
    planners: u8,
    /// Seed of the first planner; the others count on
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Time that the daemon gets for each path: 50ms, 1s
    #[arg(long, default_value = "1s", value_parser = quantity::duration)]
    deadline: Duration,
    /// Where to write the picture
    #[arg(long, value_name = "FILE", default_value = "taut-demo.svg")]
    svg: PathBuf,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Serialize)]
struct Report<'a> {
    planners: &'a [Row],
    proved: bool,
    svg: &'a std::path::Path,
    time_s: f64,
}

/// Runs the demo.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let start = Instant::now();
    let stop = stop_on_signals()?;
    let daemon = OwnDaemon::start(&fleet::this_program()?, "demo", &[], shipped::unpack)?;
    let (mut rows, worlds) = read_worlds(arguments, &daemon)?;
    plan(arguments, &daemon, &mut rows, &stop)?;
    daemon.stop()?;
    let picture = picture::draw(&rows, &worlds);
    let written = std::fs::write(&arguments.svg, picture);
    // The table is worth having even where the picture cannot be written.
    let is_proved = show(arguments, &rows, start.elapsed())?;
    written.map_err(CliError::output(&arguments.svg))?;
    Ok(if is_proved { 0 } else { NOT_PROVED })
}

/// Runs a planner for each row and fills the rows.
fn plan(
    arguments: &Arguments,
    daemon: &OwnDaemon,
    rows: &mut [Row],
    stop: &Arc<AtomicBool>,
) -> Result<(), CliError> {
    let mut progress = Progress::new(rows);
    let fleet = Fleet::start(daemon, rows, arguments.deadline)?;
    let watched = fleet.watch(rows, arguments.deadline, stop, &mut progress);
    progress.clear();
    watched
}

/// What Ctrl-C, a closed terminal and `kill` ask for.
fn stop_on_signals() -> Result<Arc<AtomicBool>, OwnDaemonError> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(no_handler)?;
    }
    Ok(stop)
}

fn no_handler(source: std::io::Error) -> OwnDaemonError {
    OwnDaemonError::Start {
        program: "signal handler".into(),
        source,
    }
}

/// A row and a world for each planner, over and over through the shipped problems.
fn read_worlds(
    arguments: &Arguments,
    daemon: &OwnDaemon,
) -> Result<(Vec<Row>, Vec<World>), CliError> {
    let mut rows = Vec::new();
    let mut worlds = Vec::new();
    let names = shipped::PROBLEMS.into_iter().cycle();
    for (index, name) in names
        .take(arguments.planners.into())
        .enumerate()
    {
        let world = World::read(&shipped::problem_file(daemon.folder(), name))?;
        rows.push(Row {
            planner: index + 1,
            problem: name.to_owned(),
            robot: world.robot_name.clone(),
            seed: arguments.seed.wrapping_add(index as u64),
            ..Row::default()
        });
        worlds.push(world);
    }
    Ok((rows, worlds))
}

/// Prints what came of it; says whether all answers are proved.
fn show(arguments: &Arguments, rows: &[Row], time: Duration) -> Result<bool, CliError> {
    let report = Report {
        planners: rows,
        proved: rows.iter().all(|row| row.proved),
        svg: &arguments.svg,
        time_s: time.as_secs_f64(),
    };
    print(&match arguments.format {
        Format::Json => report.json(),
        Format::Table => report.table(),
    })?;
    Ok(report.proved)
}

impl Report<'_> {
    fn json(&self) -> String {
        serde_json::to_string(self).expect("a report holds only strings, booleans and numbers")
            + "\n"
    }
    fn table(&self) -> String {
        let rows = self.planners;
        format!(
            "{}{} of {} proved   {}   picture: {}\n",
            table::table(rows),
            rows.iter().filter(|row| row.proved).count(),
            rows.len(),
            report::time(self.time_s),
            self.svg.display()
        )
    }
}
