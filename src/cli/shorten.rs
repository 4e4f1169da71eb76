//! `taut shorten`: pull one path taut.

use std::path::{Path, PathBuf};
use std::time::Duration;

use taut::files::ResultFile;

use super::answer::answer;
use super::answered::Answered;
use super::asked::Asked;
use super::constraints::Constraints;
use super::details;
use super::error::CliError;
use super::export;
use super::format::{Format, print_line};
use super::load;
use super::options::Options;
use super::place::{self, Place};
use super::report;
use super::source::Source;
use super::subject::Subject;
use super::times::Times;
use super::weights::Weights;

/// Shorten a path and prove the answer collision-free
///
/// Exit code: 0 proved (shorter or not), 1 the path collides, 2 not provable or out of time, 64
/// usage, 65 a bad file, 66 an unreadable one, 69 no daemon.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Problem file, or bare path (.json, .csv, .yaml)
    file: PathBuf,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    options: Options<false>,
    #[command(flatten)]
    constraints: Constraints,
    #[command(flatten)]
    times: Times,
    /// Weights of the metric; the default is the problem's own, or reach where it has none
    #[arg(long, value_enum)]
    weights: Option<Weights>,
    /// Print each shorter path's length as it is found
    #[arg(long)]
    watch: bool,
    #[command(flatten)]
    place: place::Choice,
    /// Format of the answer
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the answer to this file too; its ending says the form: .json (all of it, for
    /// `taut view` among others), .csv, .yaml (JointTrajectory, with times where these are asked for),
    /// .mcap (for viewers)
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Shortens the path of a file.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    if let Some(file) = &arguments.out {
        export::Form::of(file)?;
    }
    let place = Place::open(&arguments.place)?;
    let asked = Asked::new(
        &arguments.options,
        &arguments.constraints,
        arguments.weights,
    )?
    .timed(arguments.times.text()?);
    let (subject, answered) = answered(arguments, &place, &asked)?;
    let result = report::result(&subject, asked.request.mode, &answered);
    if let Some(file) = &arguments.out {
        write(file, &result, answered.outcome.proved)?;
    }
    let text = match arguments.format {
        Format::Json => result.json(),
        Format::Table => table(&subject, &answered),
    };
    print_line(&text)?;
    Ok(answered.code.exit_code())
}

fn answered(
    arguments: &Arguments,
    place: &Place,
    asked: &Asked,
) -> Result<(Subject, Answered), CliError> {
    let mut watch = |time: Duration, length: f64| {
        if arguments.watch {
            tell(time, length);
        }
    };
    answer(
        place,
        &mut load::reader(&arguments.source),
        &arguments.file,
        &arguments.source,
        asked,
        arguments.out.is_some() || arguments.format == Format::Json,
        &mut watch,
    )
}

/// Tells of a shorter path on standard error, so that standard output holds the answer alone.
fn tell(time: Duration, length: f64) {
    eprintln!(
        "{:>10}  length {length:.4}",
        report::time(time.as_secs_f64())
    );
}

fn write(file: &Path, result: &ResultFile, is_proved: bool) -> Result<(), CliError> {
    if is_proved || export::Form::of(file)? == export::Form::Json {
        return export::write(file, result);
    }
    let name = file.display();
    eprintln!("taut: {name} is not written: only .json says that its path is not proved");
    Ok(())
}

/// The answer for people, its warnings on standard error.
fn table(subject: &Subject, answered: &Answered) -> String {
    report::warn(&report::told(subject, answered), "");
    format!(
        "{}   {}   {}{}",
        report::lengths(&answered.outcome),
        report::verdict(answered),
        report::time(answered.time_s),
        details::of_shortening(subject, answered)
    )
}
