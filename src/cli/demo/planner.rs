//! `taut demo-planner`, hidden: one planner process, which writes what happens as lines of JSON.

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

use taut_ipc::{Client, Instance};

use super::row::Message;
use super::session::{self, Answer, Query, Step};
use crate::cli::error::CliError;
use crate::cli::quantity;

/// One planner of the demo
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// Problem file
    problem: PathBuf,
    /// Seed of the planner
    #[arg(long)]
    seed: u64,
    /// Time that the daemon gets
    #[arg(long, value_parser = quantity::duration)]
    deadline: Duration,
}

/// Plans, has the path shortened and says so.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let (last, exit) = match answer(arguments) {
        Ok(answer) => {
            let exit = answer.code.exit_code();
            (answered(answer), exit)
        }
        Err(error) => (failed(&*error), 1),
    };
    say(&last);
    Ok(exit)
}

fn answer(arguments: &Arguments) -> Result<Answer, Box<dyn Error>> {
    let query = Query {
        problem: arguments.problem.clone(),
        seed: arguments.seed,
        deadline: arguments.deadline,
    };
    let client = Client::connect(&Instance::from_environment()?)?;
    session::run(&client, &query, &mut |step| say(&message(step)))
}

fn answered(answer: Answer) -> Message {
    Message::Answered {
        code: answer.code.name().to_owned(),
        message: answer.message,
        proved: answer.proved,
        length_before: answer.length_before,
        length_after: answer.length_after,
        clearance_m: answer.clearance_m,
        time_s: answer.time.as_secs_f64(),
        rows: answer.path.as_flat().to_vec(),
    }
}

fn failed(error: &dyn Error) -> Message {
    Message::Failed {
        error: error.to_string(),
    }
}

fn message(step: Step) -> Message {
    match step {
        Step::Planned(path, time) => Message::Planned {
            time_s: time.as_secs_f64(),
            waypoints: path.len(),
            rows: path.as_flat().to_vec(),
        },
        Step::Improved(length) => Message::Improved { length },
    }
}

/// A demo that is gone does not read; then there is nobody to tell.
fn say(message: &Message) {
    let line =
        serde_json::to_string(message).expect("a message holds only strings, booleans and numbers");
    let _ = writeln!(std::io::stdout(), "{line}");
}
