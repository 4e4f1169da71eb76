//! `taut-zenoh-lab`: what the service across machines promises, measured between hosts that are network
//! namespaces of this machine.

mod bare;
mod client;
mod daemon;
mod error;
mod fleet;
mod gateway;
mod jobs;
mod model;
mod mutate;
mod network;
mod orders;
mod process;
mod programs;
mod promises;
mod random;
mod row;
mod statistics;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;

use error::Error;

/// What the service across machines promises, measured
#[derive(Parser)]
#[command(name = "taut-zenoh-lab", version)]
enum Cli {
    Promises(promises::Arguments),
    #[command(hide = true)]
    Client,
    #[command(hide = true)]
    Echo(bare::Arguments),
}

fn main() -> ExitCode {
    match Cli::try_parse() {
        Ok(cli) => ExitCode::from(run(cli).unwrap_or_else(|error| report(&error))),
        Err(error) => refused(&error),
    }
}

fn run(cli: Cli) -> Result<u8, Error> {
    match cli {
        Cli::Promises(arguments) => promises::run(&arguments),
        Cli::Client => client::run(),
        Cli::Echo(arguments) => bare::serve(&arguments),
    }
}

fn report(error: &Error) -> u8 {
    eprintln!("taut-zenoh-lab: {error}");
    error.exit_code()
}

/// Prints what is wrong with the command line, or what it asks to be told.
fn refused(error: &clap::Error) -> ExitCode {
    // Where even this cannot be written there is nobody to tell.
    let _ = error.print();
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => ExitCode::SUCCESS,
        _ => ExitCode::from(error::USAGE),
    }
}
