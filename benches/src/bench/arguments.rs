//! What `taut-bench bench` takes.

use std::path::PathBuf;
use std::time::Duration;

use taut::optimize::Mode;

use super::rules::Rules;
use super::source::Source;
use crate::output::Format;
use crate::values;

/// Shorten every problem of a folder and compare with the recorded answers of others
///
/// Each mode runs on each problem several times, one run after the other in one thread; loading is
/// left out. The runs must agree in every bit; their times are medians. With --deadline they may
/// differ, and the run of median length counts. Runs longer than 2 s are not repeated.
///
/// An answer that is not proved is the path given: it counts with the length 1. Two lengths within
/// 0.1 % tie. The calibration kernel is a fixed piece of arithmetic on a small table; its CPU time
/// relates machines.
///
/// Problems that cannot be read become rows with the reason. Exit code: 0 where all could be read
/// and run, whether their paths are proved or not; 1 where an answer is another than --against has;
/// 65 otherwise.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder with problem files, at any depth
    pub(super) folder: PathBuf,
    /// Optimizers to run, separated by commas; default: all but check
    #[arg(long, value_delimiter = ',', value_parser = values::mode())]
    modes: Vec<Mode>,
    /// Runs of each optimizer on each problem
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) repeat: u16,
    /// Times at which the lengths are compared, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.15ms,1ms,10ms", value_name = "TIMES",
        value_parser = values::duration)]
    pub(super) at: Vec<Duration>,
    /// Shorten the recorded path of this peer instead of the planner's; problems without one are
    /// left out
    #[arg(long, value_name = "NAME")]
    pub(super) from: Option<String>,
    #[command(flatten)]
    pub(super) source: Source,
    #[command(flatten)]
    pub(super) rules: Rules,
    /// Measure the check instead: time to prove each path, to refuse the straight way, and to
    /// sample the path
    #[arg(long, conflicts_with_all = ["modes", "repeat", "at", "from", "svg", "deadline", "seed", "strict", "weights"])]
    pub(super) check: bool,
    /// Shorten each path and give it times: duration over the least that the motors need, CPU, what
    /// proofs cost, and the largest parts of limits on the curve that a controller executes, by
    /// formulas of its own
    #[arg(long, conflicts_with_all = ["modes", "check", "at", "from", "svg", "deadline", "against"])]
    pub(super) time: bool,
    /// With --time: limits of joints, MoveIt's joint_limits.yaml; default: the URDF's velocities (1
    /// where it has none) and --acceleration
    #[arg(long, value_name = "FILE", requires = "time")]
    pub(super) limits: Option<PathBuf>,
    /// With --time: greatest acceleration, as many times the velocity limit per second
    #[arg(long, value_name = "TIMES", default_value_t = 2.0, requires = "time", value_parser = values::rate)]
    pub(super) acceleration: f64,
    /// With --time: work that shortening may take (pairs examined at nodes)
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = 1_000_000,
        requires = "time"
    )]
    pub(super) work: u64,
    /// Only the problems of this list, one SET/NAME a line, with the robot's model (given or
    /// spheres) after it where it is not to be --geometry's; one may stand there twice
    #[arg(long, value_name = "FILE", conflicts_with_all = ["filter", "limit"])]
    pub(super) named: Option<PathBuf>,
    /// Compare every answer's path, verdict, code and length with an earlier run's JSON, whose folder
    /// and options must be these, and print only what differs
    #[arg(long, value_name = "BEFORE.json", conflicts_with_all = ["check", "deadline", "svg", "format"])]
    pub(super) against: Option<PathBuf>,
    /// Only problems whose folder or file name contains this text
    #[arg(long, value_name = "TEXT")]
    pub(super) filter: Option<String>,
    /// At most this many problems of each folder
    #[arg(long, value_name = "N")]
    pub(super) limit: Option<usize>,
    /// Format on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: Format,
    /// Draw remaining length over time into this file, a panel for each folder
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,
    /// Write the whole report as JSON to this file too
    #[arg(long, short, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
}

impl Arguments {
    /// The optimizers to run, each once.
    pub(super) fn modes(&self) -> Vec<Mode> {
        match self.modes.is_empty() {
            true => but_check(),
            false => distinct(&self.modes),
        }
    }
}

fn but_check() -> Vec<Mode> {
    Mode::ALL
        .into_iter()
        .filter(|mode| *mode != Mode::Check)
        .collect()
}

fn distinct(named: &[Mode]) -> Vec<Mode> {
    let mut modes = Vec::new();
    for mode in named {
        if !modes.contains(mode) {
            modes.push(*mode);
        }
    }
    modes
}
