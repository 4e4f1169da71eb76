//! `taut top`: what the daemon does, and for whom.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use serde::Serialize;
use taut_ipc::control::{ClientSummary, ControlReply, ControlRequest, Stats};
use taut_ipc::planner::Planner;

use super::error::{CliError, is_lost, stdout, unexpected};
use super::format::Format;
use super::instance::InstanceChoice;
use super::{quantity, report};

/// Puts the cursor at the top of an empty screen.
const CLEAR: &str = "\x1b[H\x1b[2J";

/// Show what the daemon does and what each client has and gets, again and again
///
/// Exit code: 0, or 69 no daemon. Ends with Ctrl-C; a daemon that restarts is waited for.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Show it once and end
    #[arg(long)]
    once: bool,
    /// Time between two looks: 500ms, 2s
    #[arg(long, default_value = "1s", value_parser = quantity::duration)]
    interval: Duration,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output; JSON is an object a line
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Serialize)]
struct View {
    daemon: Stats,
    clients: Vec<ClientSummary>,
}

/// Shows it.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut planner = arguments.instance.connect()?;
    loop {
        match look(&planner) {
            Ok(view) => show(arguments, &view)?,
            Err(error) if arguments.once || !is_lost(&error) => return Err(error),
            Err(_) => {
                eprintln!("the daemon is gone; waiting for the next one");
                planner = wait_for_daemon(arguments)?;
            }
        }
        if arguments.once {
            return Ok(0);
        }
        std::thread::sleep(arguments.interval);
    }
}

fn wait_for_daemon(arguments: &Arguments) -> Result<Planner, CliError> {
    loop {
        std::thread::sleep(arguments.interval);
        match arguments.instance.connect() {
            Err(error) if is_lost(&error) => {}
            other => return other,
        }
    }
}

fn look(planner: &Planner) -> Result<View, CliError> {
    let daemon = match planner.control(&ControlRequest::Stats)? {
        ControlReply::Stats(stats) => stats,
        other => return Err(unexpected(&other)),
    };
    match planner.control(&ControlRequest::Clients)? {
        ControlReply::Clients(clients) => Ok(View { daemon, clients }),
        other => Err(unexpected(&other)),
    }
}

fn show(arguments: &Arguments, view: &View) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    let text = match arguments.format {
        Format::Json => {
            serde_json::to_string(view).expect("control replies hold only plain values") + "\n"
        }
        Format::Table if !arguments.once && out.is_terminal() => format!("{CLEAR}{}", table(view)),
        Format::Table => table(view),
    };
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(stdout)
}

fn time(ns: f64) -> String {
    report::time(ns * 1e-9)
}

fn table(view: &View) -> String {
    let Stats {
        pid,
        daemon_version,
        uptime_ns,
        numbers,
        ..
    } = &view.daemon;
    let number = |name: &str| numbers.get(name).copied().unwrap_or(0.0);
    let per_second: u64 = view
        .clients
        .iter()
        .map(|client| client.answered_per_second)
        .sum();
    let mut text = format!(
        "taut {daemon_version}   pid {pid}   up {}   {} workers   {} running   {} waiting   {} clients\n",
        time(*uptime_ns as f64),
        number("workers"),
        number("requests_running"),
        number("requests_queued"),
        number("clients"),
    );
    text += &format!(
        "{per_second} answers/s   served {}   refused {}   overloaded {}   timed out {}   cancelled {}   crashed {}\n",
        number("requests_answered"),
        number("requests_refused"),
        number("requests_overloaded"),
        number("requests_timed_out"),
        number("requests_cancelled"),
        number("worker_panics"),
    );
    for what in ["latency", "queue", "compute"] {
        let at = |percentile: &str| time(number(&format!("{what}_{percentile}_ns")));
        text += &format!("{what} p50 {} p99 {}   ", at("p50"), at("p99"));
    }
    text += "\n\n     pid  flight      /s    served   refused  quota  cancelled   computed       p50       p99\n";
    for client in &view.clients {
        text += &format!(
            "{:>8}  {:>6}  {:>6}  {:>8}  {:>8}  {:>5}  {:>9}  {:>9}  {:>8}  {:>8}\n",
            client.pid,
            format!("{}/{}", client.in_flight, client.in_flight_quota),
            client.answered_per_second,
            client.served,
            client.refused,
            client.over_quota,
            client.cancelled,
            time(client.computed_ns as f64),
            time(client.latency_p50_ns as f64),
            time(client.latency_p99_ns as f64),
        );
    }
    text
}
