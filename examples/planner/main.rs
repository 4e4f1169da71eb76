//! A planner that has its paths shortened: `taut serve` in one terminal, in another
//! `cargo run --release --example planner -- config/problems/arm_window.json`.
//!
//! Options: `--seed N`, `--deadline-ms N`, and `--planners N`, which starts that many processes at
//! once. `rrt_connect.rs` plans, `session.rs` is all that a planner has to add for the daemon.

mod rrt_connect;
mod session;

use std::error::Error;
use std::process::{Command, ExitCode};
use std::time::Duration;

use session::{Query, Step};
use taut_ipc::{Client, Instance};

struct Arguments {
    query: Query,
    planners: u64,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments = arguments()?;
    if arguments.planners > 1 {
        start_several(&arguments)
    } else {
        plan(&arguments.query)
    }
}

fn arguments() -> Result<Arguments, Box<dyn Error>> {
    let mut query = Query {
        problem: "config/problems/arm_window.json".into(),
        seed: 0,
        deadline: Duration::ZERO,
    };
    let mut planners = 1;
    let mut deadline_ms = 1000;
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || {
            words
                .next()
                .and_then(|word| word.parse().ok())
                .ok_or(format!("{word} needs a number"))
        };
        match word.as_str() {
            "--seed" => query.seed = number()?,
            "--deadline-ms" => deadline_ms = number()?,
            "--planners" => planners = number()?,
            option if option.starts_with('-') => {
                return Err(format!(
                    "{option}: valid options are --seed, --deadline-ms, --planners"
                )
                .into());
            }
            file => query.problem = file.into(),
        }
    }
    query.deadline = Duration::from_millis(deadline_ms);
    Ok(Arguments { query, planners })
}

/// Plans once and prints what came of it; the exit code is 0 where the answer is proved.
fn plan(query: &Query) -> Result<ExitCode, Box<dyn Error>> {
    let client = Client::connect(&Instance::from_environment()?)?;
    let seed = query.seed;
    let answer = session::run(&client, query, &mut |step| match step {
        Step::Planned(path, time) => println!(
            "seed {seed}: planned {} waypoints in {time:.1?}",
            path.len()
        ),
        Step::Improved(length) => println!("seed {seed}: length {length:.3}"),
    })?;
    let before = answer.length_before;
    let after = answer.length_after;
    let time = answer.time;
    let waypoints = answer.path.len();
    let verdict = match (answer.proved, answer.clearance_m) {
        (true, Some(metres)) => format!("proved, clearance at least {:.2} mm", metres * 1e3),
        (true, None) => "proved, nothing near".to_owned(),
        (false, _) => format!("{}: {}", answer.code.name(), answer.message),
    };
    println!(
        "seed {seed}: length {before:.3} → {after:.3} in {waypoints} waypoints   {verdict}   {time:.1?}"
    );
    Ok(ExitCode::from(answer.code.exit_code()))
}

/// This program again, once for each seed, all at the same time.
fn start_several(arguments: &Arguments) -> Result<ExitCode, Box<dyn Error>> {
    let query = &arguments.query;
    let mut children = Vec::new();
    for seed in query.seed..query.seed + arguments.planners {
        let mut command = Command::new(std::env::current_exe()?);
        command
            .arg(&query.problem)
            .args(["--seed", &seed.to_string()]);
        command.args(["--deadline-ms", &query.deadline.as_millis().to_string()]);
        children.push(command.spawn()?);
    }
    let mut all_proved = true;
    for mut child in children {
        all_proved &= child.wait()?.success();
    }
    Ok(if all_proved {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(2)
    })
}
