//! `taut serve`: the daemon.

use std::path::PathBuf;

use taut_ipc::Instance;
use tracing_subscriber::EnvFilter;

use super::connect::InstanceChoice;
use super::error::CliError;
use crate::daemon::config::Config;
use crate::daemon::serve;

/// Serve planners: keep robots and scenes loaded and answer their requests
///
/// Ends on SIGINT, SIGTERM and `taut stop`, with an answer for every request that runs. TAUT_LOG sets what is
/// logged to standard error: warn (the default), info, debug, or by module. Exit code: 0 stopped, 65 a bad file,
/// 66 an unreadable one, 69 the instance cannot be served.
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
}

/// Serves.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut config = arguments.config.as_deref().map_or_else(|| Ok(Config::default()), Config::read)?;
    config.workers = arguments.workers.unwrap_or(config.workers);
    start_log();
    serve(&config, &instance(&arguments.instance, &config)?, &mut std::io::stdout())?;
    Ok(0)
}

/// The option, else the environment, else the configuration, else the default.
fn instance(choice: &InstanceChoice, config: &Config) -> Result<Instance, CliError> {
    let named = choice.instance.is_some() || std::env::var_os(taut_ipc::INSTANCE_VARIABLE).is_some();
    if named || config.instance.is_empty() {
        return choice.instance();
    }
    Instance::parse(&config.instance).map_err(|error| CliError::Usage(error.to_string()))
}

fn start_log() {
    let filter = EnvFilter::try_from_env("TAUT_LOG").unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(false).init();
}
