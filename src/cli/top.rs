//! `taut top`: what the daemon does, and for whom.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use serde::Serialize;
use taut_ipc::control::{ClientSummary, ControlReply, ControlRequest, Stats};
use taut_ipc::planner::Planner;

use super::error::{CliError, is_lost, stdout, unexpected};
use super::format::Format;
use super::instance::InstanceChoice;
use super::models::json;
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
            Err(_) => planner = wait_for_daemon(arguments)?,
        }
        if arguments.once {
            return Ok(0);
        }
        std::thread::sleep(arguments.interval);
    }
}

fn wait_for_daemon(arguments: &Arguments) -> Result<Planner, CliError> {
    eprintln!("the daemon is gone; waiting for the next one");
    loop {
        std::thread::sleep(arguments.interval);
        match arguments.instance.connect() {
            Err(error) if is_lost(&error) => {}
            other => return other,
        }
    }
}

fn look(planner: &Planner) -> Result<View, CliError> {
    Ok(View {
        daemon: stats(planner)?,
        clients: clients(planner)?,
    })
}

fn stats(planner: &Planner) -> Result<Stats, CliError> {
    match planner.control(&ControlRequest::Stats)? {
        ControlReply::Stats(stats) => Ok(stats),
        other => Err(unexpected(&other)),
    }
}

fn clients(planner: &Planner) -> Result<Vec<ClientSummary>, CliError> {
    match planner.control(&ControlRequest::Clients)? {
        ControlReply::Clients(clients) => Ok(clients),
        other => Err(unexpected(&other)),
    }
}

fn show(arguments: &Arguments, view: &View) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    let text = match arguments.format {
        Format::Json => json(view) + "\n",
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
    let mut text = state(&view.daemon) + &counts(view) + &network(&view.daemon);
    for what in ["latency", "queue", "compute"] {
        text += &percentiles(&view.daemon, what);
    }
    text += "\n\n     pid  flight      /s    served   refused  quota  cancelled   computed       p50       p99  name\n";
    text.extend(view.clients.iter().map(line));
    text
}

/// A number of the daemon, 0 where it does not tell it.
fn number(daemon: &Stats, name: &str) -> f64 {
    daemon.numbers.get(name).copied().unwrap_or(0.0)
}

fn state(daemon: &Stats) -> String {
    format!(
        "taut {}   pid {}   up {}   {} workers   {} running   {} waiting   {} clients\n",
        daemon.daemon_version,
        daemon.pid,
        time(daemon.uptime_ns as f64),
        number(daemon, "workers"),
        number(daemon, "requests_running"),
        number(daemon, "requests_queued"),
        number(daemon, "clients"),
    )
}

fn counts(view: &View) -> String {
    let number = |name: &str| number(&view.daemon, name);
    let clients = view.clients.iter();
    let per_second: u64 = clients
        .map(|client| client.answered_per_second)
        .sum();
    format!(
        "{per_second} answers/s   served {}   refused {}   overloaded {}   timed out {}   cancelled {}   crashed {}\n",
        number("requests_answered"),
        number("requests_refused"),
        number("requests_overloaded"),
        number("requests_timed_out"),
        number("requests_cancelled"),
        number("worker_panics"),
    )
}

/// Of a daemon that is reached through a network: what was sent again, and what that cost.
fn network(daemon: &Stats) -> String {
    if !daemon
        .numbers
        .contains_key("network_sent_again")
    {
        return String::new();
    }
    let number = |name: &str| number(daemon, name);
    format!(
        "network: {} sent again   {} begun again   {} answered twice\n",
        number("network_sent_again"),
        number("gateway_begun_again"),
        number("network_answered_twice"),
    )
}

fn percentiles(daemon: &Stats, what: &str) -> String {
    let at = |percentile: &str| time(number(daemon, &format!("{what}_{percentile}_ns")));
    format!("{what} p50 {} p99 {}   ", at("p50"), at("p99"))
}

fn line(client: &ClientSummary) -> String {
    format!(
        "{:>8}  {:>6}  {:>6}  {:>8}  {:>8}  {:>5}  {:>9}  {:>9}  {:>8}  {:>8}  {}\n",
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
        client.name,
    )
}
