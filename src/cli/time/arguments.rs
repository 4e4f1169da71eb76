//! The flags of `taut time`.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use taut::optimize::Settings;
use taut::timing::{Controller, Fixed};

use crate::cli::format::Format;
use crate::cli::motors::Motors;
use crate::cli::quantity;
use crate::cli::source::Source;

/// Give a path times: near the least that the motors allow, proved as they are written, at every instant;
/// in this process
///
/// Shorten at 5 mm, execute at 1 mm: a path that keeps more than it must can be gone along faster. Exit
/// code: 0 proved, 1 a collision, 2 not provable, 64 usage, 65 a bad file, 66 an unreadable one.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A problem file, a bare path (.json, .csv, .yaml), or an answer of `taut shorten -o RESULT.json`
    #[arg(value_name = "PATH|RESULT")]
    pub path: PathBuf,
    #[command(flatten)]
    pub source: Source,
    #[command(flatten)]
    pub motors: Motors,
    /// Part of full speed, above 0 and up to 1: whatever is done takes 1/SPEED times as long
    #[arg(long, value_name = "SPEED", default_value_t = 1.0, value_parser = speed)]
    pub speed: f64,
    /// Who makes a curve of the points: cubic, quintic (points have accelerations, which do not jump), or
    /// linear@250 (straight, so many points a second)
    #[arg(long, value_name = "KIND", default_value_t, value_parser = Controller::from_str)]
    pub controller: Controller,
    /// Waypoints whose positions are passed, to the last bit, counted from 0: 0,3,7-9, or all; the ends
    /// always are
    #[arg(long, value_name = "LIST|all", value_parser = fixed)]
    pub fix: Option<Fixed>,
    /// Velocities of joints when the trajectory begins (rad/s or m/s), 0 of the others:
    /// joint1=0.5,joint3=-0.2
    #[arg(long, value_name = "NAME=VALUE,…", value_delimiter = ',', value_parser = velocity, allow_hyphen_values = true)]
    pub start_velocity: Vec<(String, f64)>,
    /// Clearance to keep: 1mm, 0.001
    #[arg(long, value_name = "LENGTH", default_value_t = Settings::DEFAULT_CLEARANCE_M, value_parser = quantity::metres)]
    pub clearance: f64,
    /// Do not lower the clearance of bodies that the path itself brings closer
    #[arg(long)]
    pub strict: bool,
    /// End after this time with what is proved by then: 20ms, 1.5s
    #[arg(long, value_name = "TIME", value_parser = quantity::duration)]
    pub deadline: Option<Duration>,
    /// Where a joint without a column stands (rad or m); repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = quantity::value)]
    pub held: Vec<(String, f64)>,
    /// Seed of the random choices
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub seed: u64,
    /// Write the trajectory to this file; its ending says the form: .yaml (ROS's JointTrajectory), .json
    /// (the same)
    #[arg(long, short, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write the certificate of the trajectory to this file; `taut check --timed --certificate` verifies
    /// it
    #[arg(long, value_name = "FILE")]
    pub write_certificate: Option<PathBuf>,
    /// Format of the answer
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

fn speed(text: &str) -> Result<f64, String> {
    let speed = text.parse().ok();
    speed
        .filter(|speed| *speed > 0.0 && *speed <= 1.0)
        .ok_or_else(|| "give a number above 0 and up to 1".to_owned())
}

fn fixed(text: &str) -> Result<Fixed, String> {
    if text == "all" {
        return Ok(Fixed::All);
    }
    let numbers = quantity::numbers(text).map_err(|expected| format!("{expected}, or all"))?;
    Ok(Fixed::These(numbers.into_iter().flatten().collect()))
}

fn velocity(text: &str) -> Result<(String, f64), String> {
    quantity::value(text).map_err(|_| "give NAME=VALUE, the value in rad/s or m/s".to_owned())
}
