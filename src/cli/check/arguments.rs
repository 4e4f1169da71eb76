//! The flags of `taut check`.

use std::path::{Path, PathBuf};

use taut::validation::Certificate;

use crate::cli::asked::Asked;
use crate::cli::constraints::{self, Constraints};
use crate::cli::error::CliError;
use crate::cli::export::save;
use crate::cli::format::Format;
use crate::cli::motors::Motors;
use crate::cli::options::{Options, flags_of_a_check};
use crate::cli::place;
use crate::cli::report;
use crate::cli::source::Source;
use crate::cli::weights::Weights;

/// Prove that paths are collision-free, for every instant of their motion, or verify a proof
///
/// Exit code: 0 all proved, 1 a collision, 2 not provable, 64 usage, 65 a bad file, 66 an
/// unreadable one, 69 no daemon; of several files, the highest.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// Problem files, or bare paths (.json, .csv, .yaml)
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub source: Source,
    #[command(flatten)]
    options: Options<true>,
    #[command(flatten)]
    constraints: Constraints,
    /// Weights of the metric; the default is the problem's own, or reach where it has none
    #[arg(long, value_enum)]
    weights: Option<Weights>,
    #[command(flatten)]
    pub place: place::Choice,
    /// Verify this proof by the slow and simple reference checker, in this process: a certificate,
    /// or an answer as JSON; one of `shorten` is verified for the path that it holds, with --timed one
    /// of `time` or `check --timed` for the trajectory given
    #[arg(long, value_name = "PROOF", conflicts_with_all = fixed_by_a_proof())]
    pub certificate: Option<PathBuf>,
    /// Write the certificate of the path, or with --timed of the trajectory, to this file
    #[arg(long, value_name = "FILE")]
    pub write_certificate: Option<PathBuf>,
    /// Go on after the verdict: check again whenever the scene changes, and print each other
    /// verdict, until interrupted
    #[arg(long, conflicts_with_all = NOT_WATCHED)]
    pub watch: bool,
    /// With --watch, end after so many verdicts
    #[arg(long, value_name = "NUMBER", requires = "watch", value_parser = clap::value_parser!(u64).range(1..))]
    pub count: Option<u64>,
    /// Prove timed trajectories (.yaml, .json): the curve that ros2_control's
    /// joint_trajectory_controller executes between their points; in this process
    #[arg(long, conflicts_with_all = not_timed())]
    pub timed: bool,
    #[command(flatten)]
    pub motors: Motors,
    /// Only find out whether the timed trajectory stays in the corridor of this answer, which needs
    /// neither robot nor scene; the answer is one of `taut shorten --corridor -o RESULT.json`
    #[arg(long, value_name = "RESULT", requires = "timed", conflicts_with_all = not_against())]
    pub against: Option<PathBuf>,
    /// Format of the answers
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Options that a certificate has the say about, or that make a new one.
fn fixed_by_a_proof() -> Vec<&'static str> {
    let mut fixed = flags_of_a_check(&["deadline"]);
    fixed.extend([
        "weights",
        "instance",
        "write_certificate",
        "limits",
        "acceleration",
        "against",
    ]);
    fixed.extend(constraints::FLAGS);
    fixed
}

/// What a watch has no use for.
const NOT_WATCHED: [&str; 4] = ["local", "deadline", "certificate", "write_certificate"];

/// What a trajectory is not asked: its columns count as they stand, and nothing of it goes to a
/// daemon.
fn not_timed() -> Vec<&'static str> {
    let mut unused = flags_of_a_check(&["deadline", "clearance_m", "strict", "held"]);
    unused.extend(["weights", "instance", "watch", "count"]);
    unused
}

/// What a corridor has the say about.
fn not_against() -> Vec<&'static str> {
    let mut unused = vec!["robot", "problem", "strict", "held", "write_certificate"];
    unused.extend(constraints::FLAGS);
    unused
}

impl Arguments {
    /// What is asked about each path.
    ///
    /// # Errors
    /// A value that the table of options does not have.
    pub(super) fn asked(&self) -> Result<Asked, CliError> {
        Asked::new(&self.options, &self.constraints, self.weights)
    }

    /// Checks that what is about one path has one.
    ///
    /// # Errors
    /// More files than one for a certificate, or for a watch.
    pub(super) fn check_counts(&self) -> Result<(), CliError> {
        let count = self.files.len();
        let certificate = self.certificate.as_ref();
        let what = match certificate.or(self.write_certificate.as_ref()) {
            _ if count == 1 => return Ok(()),
            Some(file) => format!("{} is the certificate of one path", file.display()),
            None if self.watch => "--watch is about one path".to_owned(),
            None => return Ok(()),
        };
        Err(CliError::Usage(format!(
            "{what}, {count} files given; give one"
        )))
    }

    /// Writes a certificate where one is asked for and there is one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write_certificate(
        &self,
        certificate: Option<&Certificate>,
    ) -> Result<(), CliError> {
        match (&self.write_certificate, certificate) {
            (Some(file), Some(certificate)) => {
                save(file, report::certificate(certificate).as_bytes())
            }
            _ => Ok(()),
        }
    }

    /// The highest exit code of all files; one that cannot be read is reported and does not keep
    /// the others from being checked.
    pub(super) fn highest(&self, mut check: impl FnMut(&Path) -> Result<u8, CliError>) -> u8 {
        let files = self.files.iter();
        files
            .map(|file| check(file).unwrap_or_else(|error| error.report()))
            .fold(0, u8::max)
    }
}
