//! `taut-zenoh`: daemons of other machines through Zenoh.

use clap::{Parser, Subcommand};
use std::io::IsTerminal;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{self, ExitCode};
use taut_ipc::Instance;
use taut_zenoh::network::{ANY_PORT, LOOPBACK};
use taut_zenoh::stop::Stop;
use taut_zenoh::{Network, attach, doctor, names, ros, serve};
use tracing_subscriber::EnvFilter;

/// Exit code of a command line that is none, as of `taut`.
const USAGE: u8 = 64;
/// Exit code where there is no daemon, no network, or no instance.
const LOST: u8 = 69;

/// Daemons of other machines through Zenoh
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Let other machines reach the daemon of this one
    ///
    /// Which daemon: TAUT_INSTANCE, as for `taut`. It may start later, and again.
    Serve {
        /// Its name on the network [default: this machine's name, and the instance's unless that is main]
        #[arg(long)]
        name: Option<String>,
        /// Where to listen, such as tls/0.0.0.0:7447 [default: tcp/127.0.0.1:7447]
        #[arg(long, value_name = "ENDPOINT")]
        listen: Vec<String>,
        /// A daemon whose scenes are copied
        #[arg(long, value_name = "DAEMON")]
        follow: Vec<String>,
        #[command(flatten)]
        network: NetworkArguments,
    },
    /// Present daemons of other machines as an instance of this one
    ///
    /// Planners and `taut` use it with TAUT_INSTANCE=NAME.
    Attach {
        /// Name of the instance, or name:/root
        instance: String,
        /// A daemon to ask, the best first: scenes have their home there [default: all, by name]
        #[arg(long, value_name = "DAEMON")]
        daemon: Vec<String>,
        #[command(flatten)]
        network: NetworkArguments,
    },
    /// Let ROS 2 nodes that speak rmw_zenoh call the daemon of this machine
    ///
    /// It serves /taut/shorten and /taut/check (moveit_msgs/srv/GetMotionPlan) and
    /// /taut/apply_planning_scene (moveit_msgs/srv/ApplyPlanningScene). Which daemon: TAUT_INSTANCE,
    /// as for `taut`.
    Ros {
        /// Label of the robot that requests are about
        #[arg(long, value_name = "LABEL")]
        robot: String,
        /// Label of the scene around it, which nodes change
        #[arg(long, value_name = "LABEL")]
        scene: String,
        /// ROS_DOMAIN_ID of the nodes
        #[arg(long, default_value_t = 0)]
        domain: u32,
        /// Times that answers are to have, such as acceleration=2/s [default: none]
        #[arg(long, default_value = "", hide_default_value = true)]
        timing: String,
        /// Follow MoveIt's scene: /monitored_planning_scene, after the whole of /get_planning_scene
        #[arg(long)]
        follow: bool,
        /// Where other nodes link to it [default: tcp/127.0.0.1:0, any free port]
        #[arg(long, value_name = "ENDPOINT")]
        listen: Vec<String>,
        #[command(flatten)]
        network: NetworkArguments,
    },
    /// Look whether gateways are there and answer
    Doctor {
        #[command(flatten)]
        network: NetworkArguments,
    },
}

#[derive(clap::Args)]
struct NetworkArguments {
    /// A gateway or router, such as tls/cell-7:7447
    #[arg(long, value_name = "ENDPOINT")]
    connect: Vec<String>,
    /// Zenoh's own configuration, which wins over this program's settings
    #[arg(long, value_name = "FILE.json5")]
    config: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let _ = error.print();
            let code = if error.use_stderr() { USAGE } else { 0 };
            return ExitCode::from(code);
        }
    };
    log(&arguments.command);
    match with_threads().and_then(|()| run(arguments.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("taut-zenoh: {}", failure.message);
            ExitCode::from(failure.exit)
        }
    }
}

/// Zenoh closes a dead link on a thread that reads others, which then waits up to 10 s for bytes that
/// nobody acknowledges (`SO_LINGER`), and ends its sending on a thread that sends for others, which waits
/// for whoever is being kept waiting by that link (`wait_before_close`). By itself it has two threads of
/// the one kind and one of the other. So many links can be lost at once without anybody else noticing.
const THREADS: &str = "(rx: (worker_threads: 128), tx: (worker_threads: 128))";
/// Zenoh reads it, once and from nowhere else.
const RUNTIME: &str = "ZENOH_RUNTIME";

/// Starts this program again, as this process, unless the environment says how many threads there are.
fn with_threads() -> Result<(), Failure> {
    if std::env::var_os(RUNTIME).is_some() {
        return Ok(());
    }
    let failed = |error| Failure {
        exit: LOST,
        message: format!("cannot start anew with {RUNTIME}={THREADS}: {error}; set it yourself"),
    };
    let own = std::env::current_exe().map_err(failed)?;
    let error = process::Command::new(own)
        .args(std::env::args_os().skip(1))
        .env(RUNTIME, THREADS)
        .exec();
    Err(failed(error))
}

struct Failure {
    exit: u8,
    message: String,
}

fn lost(error: impl std::fmt::Display) -> Failure {
    Failure {
        exit: LOST,
        message: error.to_string(),
    }
}

fn usage(message: String) -> Failure {
    Failure {
        exit: USAGE,
        message,
    }
}

fn run(command: Command) -> Result<(), Failure> {
    let stop = Stop::on_signals().map_err(lost)?;
    match command {
        Command::Serve {
            name,
            listen,
            follow,
            network,
        } => {
            let instance = instance()?;
            let name = checked(name.unwrap_or_else(|| default_name(&instance)))?;
            let network = serving(network, listen);
            let options = serve::Options {
                name,
                instance,
                follow,
            };
            serve::serve(&network, &options, &stop).map_err(lost)
        }
        Command::Attach {
            instance,
            daemon,
            network,
        } => {
            let instance = Instance::parse(&instance).map_err(|error| usage(error.to_string()))?;
            let daemons = daemon
                .into_iter()
                .map(checked)
                .collect::<Result<_, _>>()?;
            let options = attach::Options { instance, daemons };
            attach::attach(&attaching(network), &options, &stop).map_err(lost)
        }
        Command::Ros {
            robot,
            scene,
            domain,
            timing,
            follow,
            listen,
            network,
        } => {
            let options = ros::Options {
                instance: instance()?,
                robot,
                scene,
                domain,
                timing,
                follows: follow,
            };
            ros::serve(&among_nodes(network, listen), &options, &stop).map_err(lost)
        }
        Command::Doctor { network } => diagnose(&attaching(network)),
    }
}

fn instance() -> Result<Instance, Failure> {
    Instance::from_environment().map_err(|error| usage(error.to_string()))
}

fn diagnose(network: &Network) -> Result<(), Failure> {
    let report = doctor::doctor(network).map_err(lost)?;
    for line in &report.lines {
        println!("{line}");
    }
    match report.is_healthy {
        true => Ok(()),
        false => Err(Failure {
            exit: 1,
            message: "no daemon of another machine can be used".to_owned(),
        }),
    }
}

/// Loopback unless somebody says otherwise.
fn serving(arguments: NetworkArguments, mut listen: Vec<String>) -> Network {
    if listen.is_empty() && arguments.config.is_none() {
        listen.push(LOOPBACK.to_owned());
    }
    Network {
        listen,
        connect: arguments.connect,
        config: arguments.config,
        ..Network::default()
    }
}

/// As rmw_zenoh's nodes are: linked to their router, and directly to the nodes that it names.
fn among_nodes(arguments: NetworkArguments, mut listen: Vec<String>) -> Network {
    let mut connect = arguments.connect;
    if arguments.config.is_none() {
        if listen.is_empty() {
            listen.push(ANY_PORT.to_owned());
        }
        if connect.is_empty() {
            connect.push(LOOPBACK.to_owned());
        }
    }
    Network {
        listen,
        connect,
        config: arguments.config,
        finds_peers: true,
    }
}

fn attaching(arguments: NetworkArguments) -> Network {
    let mut connect = arguments.connect;
    if connect.is_empty() && arguments.config.is_none() {
        connect.push(LOOPBACK.to_owned());
    }
    Network {
        connect,
        config: arguments.config,
        ..Network::default()
    }
}

fn checked(name: String) -> Result<String, Failure> {
    match names::is_name(&name) {
        true => Ok(name),
        false => Err(usage(format!(
            "daemon name `{name}`: use 1 to {} of A-Z, a-z, 0-9, `.`, `_`, `-`, and not `live`",
            names::NAME_MAX
        ))),
    }
}

fn default_name(instance: &Instance) -> String {
    let host = attach::host();
    match instance.name() {
        taut_ipc::DEFAULT_NAME => host,
        name => format!("{host}-{name}"),
    }
}

fn log(command: &Command) {
    let usual = match command {
        // What it finds is what it prints.
        Command::Doctor { .. } => "error",
        _ => "error,taut_zenoh=info",
    };
    // As for `taut`; RUST_LOG is what users of Zenoh know.
    let filter = EnvFilter::try_from_env("TAUT_LOG")
        .or_else(|_| EnvFilter::try_from_default_env())
        .unwrap_or_else(|_| EnvFilter::new(usual));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .init();
}
