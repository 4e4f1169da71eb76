//! The command line: one file per subcommand, stable exit codes, one-line errors with the next
//! step.

mod answer;
mod answered;
mod asked;
mod check;
mod constraints;
mod demo;
mod details;
mod doctor;
mod error;
mod export;
mod format;
mod instance;
mod labelled;
mod load;
mod models;
mod motors;
mod options;
mod place;
mod prepare;
mod programs;
mod progress;
mod quantity;
mod record;
mod replay;
mod report;
mod scene;
mod serve;
mod shorten;
mod source;
mod subject;
mod svg;
mod time;
mod times;
mod top;
mod view;
mod weights;
mod why;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;

use error::USAGE;

/// Pulls planners' paths taut and proves every answer collision-free.
#[derive(Parser)]
#[command(name = "taut", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Check(check::Arguments),
    Shorten(shorten::Arguments),
    Time(time::Arguments),
    Export(export::Arguments),
    Bench(programs::Bench),
    Zenoh(programs::Zenoh),
    Demo(demo::Arguments),
    #[command(hide = true)]
    DemoPlanner(demo::planner::Arguments),
    Serve(serve::Arguments),
    Doctor(doctor::Arguments),
    LoadRobot(models::LoadRobot),
    LoadScene(models::LoadScene),
    /// Forget a robot of the daemon; running requests keep it
    UnloadRobot(models::Unload),
    /// Forget a scene of the daemon; running requests keep it
    UnloadScene(models::Unload),
    List(models::List),
    Scene(scene::Arguments),
    Describe(models::Describe),
    Stop(models::Stop),
    Top(top::Arguments),
    View(view::Arguments),
    Why(why::Arguments),
    Record(record::Arguments),
    Replay(replay::Arguments),
}

/// Runs the command line and gives its exit code: 0 proved, 1 collision, 2 not provable, 64 and
/// above an error.
pub fn main() -> ExitCode {
    match Cli::try_parse() {
        Ok(cli) => ExitCode::from(run(cli.command).unwrap_or_else(|error| error.report())),
        Err(error) => unread(&error),
    }
}

fn run(command: Command) -> Result<u8, error::CliError> {
    match command {
        Command::Check(arguments) => check::run(&arguments),
        Command::Shorten(arguments) => shorten::run(&arguments),
        Command::Time(arguments) => time::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Bench(bench) => programs::BENCH.run(&bench.arguments),
        Command::Zenoh(zenoh) => programs::ZENOH.run(&zenoh.arguments),
        Command::Demo(arguments) => demo::run(&arguments),
        Command::DemoPlanner(arguments) => demo::planner::run(&arguments),
        Command::Serve(arguments) => serve::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::LoadRobot(arguments) => models::load_robot(&arguments),
        Command::LoadScene(arguments) => models::load_scene(&arguments),
        Command::UnloadRobot(arguments) => models::unload_robot(&arguments),
        Command::UnloadScene(arguments) => models::unload_scene(&arguments),
        Command::List(arguments) => models::list(&arguments),
        Command::Scene(arguments) => scene::run(&arguments),
        Command::Describe(arguments) => models::describe(&arguments),
        Command::Stop(arguments) => models::stop(&arguments),
        Command::Top(arguments) => top::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Why(arguments) => why::run(&arguments),
        Command::Record(arguments) => record::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
    }
}

/// Prints why there is no command to run: often because help was asked for.
fn unread(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // Where even this cannot be written there is nobody to tell.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => eprintln!("{error}"),
        _ => eprintln!("taut: {}", one_line(error)),
    }
    ExitCode::from(USAGE)
}

/// What clap says on several lines, as one with the next step at its end.
fn one_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let said: Vec<&str> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"))
        .filter(|line| !line.is_empty() && !line.starts_with("tip: to pass"))
        .collect();
    format!("{}; see --help", without_frame(&said.join(" ")))
}

/// What clap says, without how it begins and ends every message.
fn without_frame(said: &str) -> &str {
    said.trim_start_matches("error: ")
        .trim_end_matches("For more information, try '--help'.")
        .trim_end()
}
