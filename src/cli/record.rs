//! `taut record`: the requests of a daemon, with their robots, scenes and answers, in one file.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use taut_ipc::control::{ControlReply, ControlRequest, RecordingState};
use taut_ipc::planner::Planner;

use super::error::{CliError, stdout, unexpected};
use super::format::Format;
use super::instance::InstanceChoice;
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
    let ends = Arc::new(AtomicBool::new(false));
    let failed = |source| CliError::Output {
        file: "signal handler".to_owned(),
        source,
    };
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, ends.clone()).map_err(failed)?;
    }
    let planner = arguments.instance.connect()?;
    let file = absolute(&arguments.out)?;
    let start = Instant::now();
    let mut asked = ask(&planner, &file).map(|_| start)?;
    let is_terminal = std::io::stderr().is_terminal();
    eprintln!("recording to {}; end with Ctrl-C", file.display());
    let is_over = |start: Instant| arguments.time.is_some_and(|time| start.elapsed() >= time);
    while !ends.load(Ordering::Relaxed) && !is_over(start) {
        std::thread::sleep(LOOK_UP);
        if asked.elapsed() >= ASK_EVERY {
            asked = Instant::now();
            let state = ask(&planner, &file)?;
            if is_terminal {
                eprint!("\r{}  ", words(&state));
            }
        }
    }
    if is_terminal {
        eprintln!();
    }
    let state = recording(planner.control_once(&ControlRequest::EndRecording)?)?;
    let text = match arguments.format {
        Format::Json => {
            serde_json::to_string(&state).expect("control replies hold only plain values")
        }
        Format::Table => format!("{}   {}", file.display(), words(&state)),
    };
    writeln!(std::io::stdout().lock(), "{text}").map_err(stdout)?;
    Ok(0)
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
    std::path::absolute(file).map_err(|source| CliError::Output {
        file: file.display().to_string(),
        source,
    })
}

fn words(state: &RecordingState) -> String {
    let RecordingState {
        requests,
        answers,
        missed,
        bytes,
        ..
    } = state;
    let missed = if *missed == 0 {
        String::new()
    } else {
        format!(", {missed} left out: the disk is too slow")
    };
    format!(
        "{requests} requests, {answers} answers, {:.1} MB{missed}",
        *bytes as f64 / 1e6
    )
}
