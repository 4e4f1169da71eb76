//! Looks at the network as a planner's machine sees it.

use crate::call::Gateway;
use crate::caller::{Caller, Client};
use crate::network::{Network, NetworkError};
use std::time::{Duration, Instant};
use taut_ipc::control::{ControlReply, ControlRequest, Stats};

/// How long gateways are looked for: a link that failed is tried again within a second.
const PATIENCE: Duration = Duration::from_secs(3);
/// After the first is found, how long others are looked for.
const OTHERS: Duration = Duration::from_millis(300);

/// What was found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// A line each.
    pub lines: Vec<String>,
    /// Whether planners can work.
    pub is_healthy: bool,
}

/// Connects, and asks every gateway that is there.
///
/// # Errors
/// [`NetworkError`]: a session that cannot be opened.
pub fn doctor(network: &Network) -> Result<Report, NetworkError> {
    let caller = Caller::open(network, &[])?;
    let client = caller.client("doctor".to_owned())?;
    let gateways = found(&caller);
    let mut report = Report::default();
    for (name, reason) in caller.live.unfit() {
        report
            .lines
            .push(format!("FAIL  {name}: its daemon cannot be used: {reason}"));
    }
    if gateways.is_empty() && report.lines.is_empty() {
        report.lines.push(nobody(network));
    }
    for gateway in &gateways {
        let (is_well, line) = look(&caller, &client, gateway);
        report.is_healthy |= is_well;
        report.lines.push(line);
        let namesakes = gateways
            .iter()
            .filter(|other| other.name == gateway.name);
        if namesakes.count() > 1 {
            let name = &gateway.name;
            let line =
                format!("WARN  {name}: two daemons have this name; give one another by --name");
            report.lines.push(line);
        }
    }
    Ok(report)
}

fn found(caller: &Caller) -> Vec<Gateway> {
    let end = Instant::now() + PATIENCE;
    while caller.best().is_none() && caller.live.unfit().is_empty() && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(OTHERS);
    caller.live.now()
}

fn nobody(network: &Network) -> String {
    let endpoints = network.connect.join(", ");
    format!(
        "FAIL  no gateway within {PATIENCE:?} at {endpoints}; is `taut-zenoh serve` running there, with a daemon of the same release beside it (see its log), does it listen at that address, and do both sides' certificates fit?"
    )
}

fn look(caller: &Caller, client: &Client, gateway: &Gateway) -> (bool, String) {
    let name = &gateway.name;
    // The first opens the port.
    caller.control_at(client, gateway, &ControlRequest::List);
    let start = Instant::now();
    let reply = caller.control_at(client, gateway, &ControlRequest::Stats);
    let round_trip = start.elapsed();
    match reply {
        Some(ControlReply::Stats(stats)) => {
            let version = &stats.daemon_version;
            let line = format!(
                "OK    {name}: taut {version}, answers in {round_trip:.1?}; {}",
                counted(&stats)
            );
            (true, line)
        }
        Some(ControlReply::Refused(refusal)) => {
            (false, format!("FAIL  {name}: {}", refusal.message))
        }
        Some(_) => (
            false,
            format!("FAIL  {name}: an odd reply; use the same release on both sides"),
        ),
        None => (
            false,
            format!("FAIL  {name}: it is announced and does not answer; look at its log"),
        ),
    }
}

/// What the gateway counted since its start.
fn counted(stats: &Stats) -> String {
    let count = |name: &str| stats.numbers.get(name).copied().unwrap_or(0.0);
    format!(
        "{} requests, {} of them begun elsewhere before, {} came again and were known",
        count("gateway_requests"),
        count("gateway_begun_again"),
        count("gateway_known"),
    )
}
