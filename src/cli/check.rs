//! `taut check`: prove paths, change nothing.

use std::io::Write;
use std::path::{Path, PathBuf};

use taut::files::Reader;
use taut::optimize::Mode;

use super::choices::{Choices, Reported};
use super::details;
use super::error::{CliError, stdout};
use super::place::{self, Place};
use super::report;
use super::request::{Asked, Rules, Source};
use super::{Format, against, load, timed, verify, watch};

/// Prove that paths are collision-free, for every instant of their motion, or verify a proof
///
/// Exit code: 0 all proved, 1 a collision, 2 not provable, 64 usage, 65 a bad file, 66 an
/// unreadable one, 69 no daemon; of several files, the highest.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Problem files, or bare paths (.json, .csv, .yaml)
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    rules: Rules,
    #[command(flatten)]
    reported: Reported,
    #[command(flatten)]
    place: place::Choice,
    /// Verify this proof by the slow and simple reference checker, in this process: a certificate,
    /// or an answer as JSON; one of `shorten` is verified for the path that it holds
    #[arg(long, value_name = "PROOF", conflicts_with_all = FIXED_BY_A_PROOF)]
    certificate: Option<PathBuf>,
    /// Write the certificate of the path to this file
    #[arg(long, value_name = "FILE")]
    write_certificate: Option<PathBuf>,
    /// Go on after the verdict: check again whenever the scene changes, and print each other
    /// verdict, until interrupted
    #[arg(long, conflicts_with_all = NOT_WATCHED)]
    watch: bool,
    /// With --watch, end after so many verdicts
    #[arg(long, value_name = "NUMBER", requires = "watch", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Prove timed trajectories (.yaml, .json): the curve that ros2_control's
    /// joint_trajectory_controller executes between their points; in this process
    #[arg(long, conflicts_with_all = NOT_TIMED)]
    timed: bool,
    /// Only find out whether the timed trajectory stays in the corridor of this answer, which needs
    /// neither robot nor scene; the answer is one of `taut shorten --corridor -o RESULT.json`
    #[arg(long, value_name = "RESULT", requires = "timed", conflicts_with_all = ["robot", "problem", "strict", "held"])]
    against: Option<PathBuf>,
    /// Format of the answers
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Options that a certificate has the say about, or that make a new one.
const FIXED_BY_A_PROOF: [&str; 10] = [
    "clearance",
    "strict",
    "unwrapped",
    "keep_goal",
    "weights",
    "seed",
    "held",
    "no_contacts",
    "instance",
    "write_certificate",
];

/// What a watch has no use for.
const NOT_WATCHED: [&str; 4] = ["local", "deadline", "certificate", "write_certificate"];

/// What a trajectory is not asked: its columns count as they stand, and nothing of it goes to a
/// daemon.
const NOT_TIMED: [&str; 11] = [
    "unwrapped",
    "keep_goal",
    "weights",
    "seed",
    "no_contacts",
    "corridor",
    "instance",
    "certificate",
    "write_certificate",
    "watch",
    "count",
];

/// Checks every file; one that cannot be read does not keep the others from being checked.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let proof = arguments.certificate.as_ref();
    if let Some(file) = proof.or(arguments.write_certificate.as_ref())
        && arguments.files.len() > 1
    {
        let text = format!(
            "{} is the certificate of one path, {} files given",
            file.display(),
            arguments.files.len()
        );
        return Err(CliError::Usage(text + "; give one"));
    }
    if let Some(proof) = proof {
        let source = &arguments.source;
        let deadline = arguments.rules.deadline;
        return verify::run(
            &arguments.files[0],
            proof,
            source,
            deadline,
            arguments.format,
        );
    }
    let mut reader = load::reader(&arguments.source);
    if arguments.timed {
        return Ok(highest(&arguments.files, |file| {
            timed(arguments, file, &mut reader)
        }));
    }
    let mut place = Place::open(&arguments.place)?;
    if arguments.watch {
        let [file] = arguments.files.as_slice() else {
            let text = format!(
                "--watch is about one path, {} files given; give one",
                arguments.files.len()
            );
            return Err(CliError::Usage(text));
        };
        let choices = Choices::from(&arguments.reported);
        let asked = Asked {
            mode: Mode::Check,
            rules: &arguments.rules,
            choices: &choices,
        };
        let count = arguments.count;
        let format = arguments.format;
        return watch::run(
            &mut place,
            &mut reader,
            file,
            &arguments.source,
            &asked,
            count,
            format,
        );
    }
    Ok(highest(&arguments.files, |file| {
        check(arguments, file, &mut reader, &mut place)
    }))
}

/// The highest exit code of all files; one that cannot be read is reported and does not keep the
/// others from being checked.
fn highest(files: &[PathBuf], mut check: impl FnMut(&Path) -> Result<u8, CliError>) -> u8 {
    files
        .iter()
        .map(|file| check(file).unwrap_or_else(|error| error.report()))
        .fold(0, u8::max)
}

fn timed(arguments: &Arguments, file: &Path, reader: &mut Reader) -> Result<u8, CliError> {
    let Arguments {
        source,
        rules,
        format,
        ..
    } = arguments;
    match &arguments.against {
        Some(answer) => against::run(file, answer, rules.deadline, *format),
        None => timed::run(
            reader,
            file,
            source,
            rules,
            &Choices::from(&arguments.reported),
            *format,
        ),
    }
}

fn check(
    arguments: &Arguments,
    file: &Path,
    reader: &mut Reader,
    place: &mut Place,
) -> Result<u8, CliError> {
    let choices = Choices::from(&arguments.reported);
    let asked = Asked {
        mode: Mode::Check,
        rules: &arguments.rules,
        choices: &choices,
    };
    let (subject, timed) = place.answer(
        reader,
        file,
        &arguments.source,
        &asked,
        arguments.format == Format::Json,
        &mut |_, _| {},
    )?;
    if let (Some(file), Some(certificate)) =
        (&arguments.write_certificate, &timed.outcome.certificate)
    {
        let text = serde_json::to_string(certificate)
            .expect("a certificate holds only strings and numbers");
        std::fs::write(file, text + "\n").map_err(|source| CliError::Output {
            file: file.display().to_string(),
            source,
        })?;
    }
    let mut out = std::io::stdout().lock();
    match arguments.format {
        Format::Json => writeln!(
            out,
            "{}",
            report::result(&subject, Mode::Check, &timed).json()
        ),
        Format::Table => {
            let is_one = arguments.files.len() == 1;
            let several = if is_one {
                String::new()
            } else {
                format!("{}: ", subject.name)
            };
            // A list of many files stays a line each.
            let details = if is_one {
                details::of_check(&timed)
            } else {
                String::new()
            };
            report::warn(&report::told(&subject, &timed), &several);
            writeln!(
                out,
                "{several}{}   {}{details}",
                report::verdict(&timed),
                report::time(timed.time_s)
            )
        }
    }
    .map_err(stdout)?;
    Ok(timed.code.exit_code())
}
