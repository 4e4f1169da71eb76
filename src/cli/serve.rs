//! `taut serve`: the daemon.

use std::ffi::OsString;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use taut_ipc::Instance;
use tracing_subscriber::EnvFilter;

use super::error::CliError;
use super::instance::InstanceChoice;
use crate::daemon::config::{Config, check_niceness};
use crate::daemon::live::check_address;
use crate::daemon::serve;
use crate::daemon::supervise::{bind_to_supervisor, supervise};

/// Serve planners: keep robots and scenes loaded and answer their requests
///
/// Ends on SIGINT, SIGTERM and `taut stop`, with an answer for every request that runs. What
/// clients load or change is kept in the state folder: a daemon that was killed comes back with
/// every robot and scene as it was; after one that ended in order, what no client has changed is
/// read again from the configuration's files. TAUT_LOG sets what is logged to standard error: warn
/// (the default), info, debug, or by module. Exit code: 0 stopped, 65 a bad file, 66 an unreadable
/// one, 67 a full disk, 69 the instance cannot be served, 70 a supervised daemon dies again and
/// again.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Configuration; without it everything has its default and nothing is loaded at first
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    instance: InstanceChoice,
    /// Worker threads; the default is the configuration's, or one per core
    #[arg(long, value_name = "N")]
    workers: Option<usize>,
    /// Niceness of the threads that compute and answer, 0 to 19; the default is the configuration's,
    /// or 0
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    niceness: Option<i32>,
    /// Folder that keeps robots and scenes; the default is `state` below a root of one's own
    /// (NAME:/ROOT), else ~/.local/state/taut/NAME
    #[arg(long, value_name = "FOLDER", conflicts_with = "no_state")]
    state: Option<PathBuf>,
    /// Keep nothing: begin with the configuration's robots and scenes only
    #[arg(long)]
    no_state: bool,
    /// Serve a page that shows what runs and the last answers, at this address of this machine
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:8642")]
    http: Option<SocketAddr>,
    /// Start the daemon as a child and start it again when it dies or hangs
    #[arg(long)]
    supervise: bool,
    /// Process that supervises this one
    #[arg(long, hide = true, value_name = "PID", conflicts_with = "supervise")]
    supervised_by: Option<u32>,
}

/// Serves.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let config = configuration(arguments)?;
    let instance = instance(&arguments.instance, &config)?;
    if arguments.supervise {
        let patience = Duration::from_secs_f64(config.watchdog_s);
        return Ok(supervise(&instance, &arguments_of_child(), patience)?);
    }
    if let Some(pid) = arguments.supervised_by {
        bind_to_supervisor(pid)?;
    }
    start_log();
    serve(&config, &instance, &mut std::io::stdout())?;
    Ok(0)
}

/// The configuration of the file, as the arguments change it.
fn configuration(arguments: &Arguments) -> Result<Config, CliError> {
    let mut config = arguments
        .config
        .as_deref()
        .map_or_else(|| Ok(Config::default()), Config::read)?;
    config.workers = arguments.workers.unwrap_or(config.workers);
    if let Some(niceness) = arguments.niceness {
        check_niceness("--niceness", niceness).map_err(CliError::Usage)?;
        config.niceness = niceness;
    }
    config.state = state(arguments).or(config.state);
    if let Some(address) = arguments.http {
        check_address("--http", address).map_err(CliError::Usage)?;
        config.http = Some(address);
    }
    Ok(config)
}

/// The state folder that the arguments name, an empty name where nothing is to be kept.
fn state(arguments: &Arguments) -> Option<PathBuf> {
    match arguments.no_state {
        true => Some(PathBuf::new()),
        false => arguments.state.clone(),
    }
}

/// The arguments of this process, but for the one that it supervises.
fn arguments_of_child() -> Vec<OsString> {
    std::env::args_os()
        .skip(1)
        .filter(|argument| argument != "--supervise")
        .collect()
}

/// The option, else the environment, else the configuration, else the default.
pub(super) fn instance(choice: &InstanceChoice, config: &Config) -> Result<Instance, CliError> {
    if is_named(choice) || config.instance.is_empty() {
        return choice.instance();
    }
    Instance::parse(&config.instance).map_err(|error| CliError::Usage(error.to_string()))
}

fn is_named(choice: &InstanceChoice) -> bool {
    choice.instance.is_some() || std::env::var_os(taut_ipc::INSTANCE_VARIABLE).is_some()
}

fn start_log() {
    let filter = EnvFilter::try_from_env("TAUT_LOG").unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(false)
        .init();
}
