//! `taut record`: the requests of a daemon, with their robots, scenes and answers, in one file.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use taut_ipc::control::{ControlReply, ControlRequest, RecordingState};
use taut_ipc::planner::Planner;

use super::error::{CliError, unexpected};
use super::format::{Format, print_line};
use super::instance::InstanceChoice;
use super::models::json;
use super::quantity;

/// Time between two looks at whether to end.
const LOOK_UP: Duration = Duration::from_millis(50);
/// Time between two questions how it goes: the daemon ends a recording that nobody asks about.
const ASK_EVERY: Duration = Duration::from_millis(500);

/// Record the requests that a daemon gets, with their robots, scenes and answers, to compute them
/// again later
///
/// Ends with Ctrl-C, or after the time given. Exit code: 0, 66 a file that cannot be written, 67 no
/// room on the disk, 69 no daemon. See `taut replay`.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// File to write; one that is there is replaced
    #[arg(long, short, value_name = "FILE", default_value = "run.taut")]
    out: PathBuf,
    /// How long: 500ms, 10s
    #[arg(long = "for", value_name = "TIME", value_parser = quantity::duration)]
    time: Option<Duration>,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Records.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let ends = ends_on_signals()?;
    let planner = arguments.instance.connect()?;
    let file = absolute(&arguments.out)?;
    let start = Instant::now();
    ask(&planner, &file)?;
    eprintln!("recording to {}; end with Ctrl-C", file.display());
    let is_over = || {
        arguments
            .time
            .is_some_and(|time| start.elapsed() >= time)
    };
    keep_asking(&planner, &file, start, || {
        ends.load(Ordering::Relaxed) || is_over()
    })?;
    let state = recording(planner.control_once(&ControlRequest::EndRecording)?)?;
    print_line(&match arguments.format {
        Format::Json => json(&state),
        Format::Table => format!("{}   {}", file.display(), words(&state)),
    })?;
    Ok(0)
}

/// What Ctrl-C and `kill` set.
fn ends_on_signals() -> Result<Arc<AtomicBool>, CliError> {
    let ends = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, ends.clone())
            .map_err(CliError::output("signal handler".as_ref()))?;
    }
    Ok(ends)
}

/// Asks how the recording goes until it is to end, and shows it on a terminal.
fn keep_asking(
    planner: &Planner,
    file: &Path,
    mut asked: Instant,
    is_to_end: impl Fn() -> bool,
) -> Result<(), CliError> {
    let is_terminal = std::io::stderr().is_terminal();
    while !is_to_end() {
        std::thread::sleep(LOOK_UP);
        if asked.elapsed() >= ASK_EVERY {
            asked = Instant::now();
            let state = ask(planner, file)?;
            if is_terminal {
                eprint!("\r{}  ", words(&state));
            }
        }
    }
    if is_terminal {
        eprintln!();
    }
    Ok(())
}

fn ask(planner: &Planner, file: &Path) -> Result<RecordingState, CliError> {
    recording(planner.control_once(&ControlRequest::Record {
        file: file.to_owned(),
    })?)
}

/// The state of a recording, or of a bundle.
pub(super) fn recording(reply: ControlReply) -> Result<RecordingState, CliError> {
    match reply {
        ControlReply::Recording(state) => Ok(state),
        other => Err(unexpected(&other)),
    }
}

/// A file as the daemon, which has another working folder, has to call it.
pub(super) fn absolute(file: &Path) -> Result<PathBuf, CliError> {
    std::path::absolute(file).map_err(CliError::output(file))
}

fn words(state: &RecordingState) -> String {
    format!(
        "{} requests, {} answers, {:.1} MB{}",
        state.requests,
        state.answers,
        state.bytes as f64 / 1e6,
        left_out(state.missed)
    )
}

fn left_out(missed: u64) -> String {
    match missed {
        0 => String::new(),
        missed => format!(", {missed} left out: the disk is too slow"),
    }
}
