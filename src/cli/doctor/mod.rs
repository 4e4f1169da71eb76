//! `taut doctor`: looks at everything a daemon and its clients depend on, a line each.

mod check;
mod checks;
mod network;

use std::path::PathBuf;

use serde::Serialize;

use super::error::CliError;
use super::format::{Format, print_line};
use super::instance::InstanceChoice;
use crate::daemon::config::Config;
use check::{Check, Verdict};

/// Check what the daemon and its clients depend on, and say what to do about it
///
/// OK is as it should be, WARN may come to matter, FAIL keeps something from working. Exit code: 0
/// nothing fails, 1 something does, 64 usage, 65 a bad configuration, 66 an unreadable one.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Configuration that the daemon is started with
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Look at gateways of other machines as well, from here, by the program taut-zenoh
    #[arg(long, value_name = "ENDPOINT")]
    connect: Vec<String>,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Serialize)]
struct Report {
    instance: String,
    root: PathBuf,
    healthy: bool,
    checks: Vec<Check>,
}

/// Checks.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let report = report(arguments)?;
    let text = match arguments.format {
        Format::Json => serde_json::to_string(&report).expect("a report holds only strings"),
        Format::Table => table(&report),
    };
    print_line(&text)?;
    Ok(u8::from(!report.healthy))
}

fn report(arguments: &Arguments) -> Result<Report, CliError> {
    let config = arguments
        .config
        .as_deref()
        .map_or_else(|| Ok(Config::default()), Config::read)?;
    let instance = super::serve::instance(&arguments.instance, &config)?;
    let mut checks = checks::all(&instance, &config);
    if !arguments.connect.is_empty() {
        checks.extend(network::look(&arguments.connect));
    }
    Ok(Report {
        instance: instance.name().to_owned(),
        root: instance.root().to_owned(),
        healthy: checks
            .iter()
            .all(|check| check.verdict != Verdict::Fail),
        checks,
    })
}

fn table(report: &Report) -> String {
    report
        .checks
        .iter()
        .map(line)
        .collect::<Vec<_>>()
        .join("\n")
}

fn line(check: &Check) -> String {
    let verdict = match check.verdict {
        Verdict::Ok => "OK",
        Verdict::Warn => "WARN",
        Verdict::Fail => "FAIL",
    };
    format!("{verdict:<4}  {:<14}  {}", check.what, check.seen)
}
