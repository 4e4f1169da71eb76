//! The `taut-bench` command: measures taut from outside, by the library's and the wire's public
//! names and by the `taut` binary, whose daemons it starts.
//!
//! `bench` sets the optimizer's answers beside those of others, and one build's beside another's.
//! `load` sends requests from many processes at once, and `load::promises` measures what the service
//! promises that way.

mod bench;
mod clock;
mod error;
mod load;
mod output;
mod program;
#[path = "../../src/cli/demo/shipped.rs"]
mod shipped;
mod statistics;
#[path = "../../src/cli/svg.rs"]
mod svg;
mod units;
mod values;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;

use error::Error;
use load::{client, echo, promises};

/// Measures taut: its answers beside those of others, and what its service promises.
#[derive(Parser)]
#[command(name = "taut-bench", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
#[expect(
    clippy::large_enum_variant,
    reason = "one value, made once and matched at once"
)]
enum Command {
    Bench(bench::Arguments),
    Load(load::Arguments),
    #[command(hide = true)]
    LoadClient,
    #[command(hide = true)]
    LoadEcho,
    Promises(promises::Arguments),
}

fn main() -> ExitCode {
    match Cli::try_parse() {
        Ok(cli) => ExitCode::from(run(cli.command).unwrap_or_else(|error| error.report())),
        Err(error) => refused(&error),
    }
}

fn run(command: Command) -> Result<u8, Error> {
    match command {
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Load(arguments) => load::run(&arguments),
        Command::LoadClient => client::run(),
        Command::LoadEcho => echo::serve(),
        Command::Promises(arguments) => promises::run(&arguments),
    }
}

/// Prints what is wrong with the command line, or what it asks to be told.
fn refused(error: &clap::Error) -> ExitCode {
    use ErrorKind::{
        DisplayHelp, DisplayHelpOnMissingArgumentOrSubcommand as NoCommand, DisplayVersion,
    };
    match error.kind() {
        DisplayHelp | DisplayVersion => {
            // Where even this cannot be written there is nobody to tell.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        NoCommand => eprintln!("{error}"),
        _ => eprintln!("taut-bench: {}", one_line(&error.to_string())),
    }
    ExitCode::from(error::USAGE)
}

/// What clap says on several lines, as one with the next step at its end.
fn one_line(text: &str) -> String {
    let said: Vec<&str> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"))
        .filter(|line| !line.is_empty() && !line.starts_with("tip: to pass"))
        .collect();
    let text = said.join(" ");
    let text = text
        .trim_start_matches("error: ")
        .trim_end_matches("For more information, try '--help'.");
    format!("{}; see --help", text.trim_end())
}
