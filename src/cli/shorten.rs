//! `taut shorten`: pull one path taut.

use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

use taut::optimize::Mode;

use super::choices::Choices;
use super::details;
use super::error::{CliError, stdout};
use super::place::{self, Place};
use super::report;
use super::request::{self, Asked, Rules, Source};
use super::{Format, export, load};

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
    /// Optimizer
    #[arg(long, default_value = Mode::default().name(), value_parser = request::mode())]
    mode: Mode,
    #[command(flatten)]
    rules: Rules,
    #[command(flatten)]
    choices: Choices,
    /// Print each shorter path's length as it is found
    #[arg(long)]
    watch: bool,
    #[command(flatten)]
    place: place::Choice,
    /// Format of the answer
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the answer to this file too; its ending says the form: .json (all of it, for
    /// `taut view` among others), .csv, .yaml (JointTrajectory without times), .mcap (for viewers)
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Shortens the path of a file.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    if let Some(file) = &arguments.out {
        export::Form::of(file)?;
    }
    let mut reader = load::reader(&arguments.source);
    let mut watch = |time: Duration, length: f64| {
        if arguments.watch {
            // On standard error, so that standard output holds the answer alone.
            eprintln!(
                "{:>10}  length {length:.4}",
                report::time(time.as_secs_f64())
            );
        }
    };
    let mut place = Place::open(&arguments.place)?;
    let asked = Asked {
        mode: arguments.mode,
        rules: &arguments.rules,
        choices: &arguments.choices,
    };
    let is_kept = arguments.out.is_some() || arguments.format == Format::Json;
    let (subject, timed) = place.answer(
        &mut reader,
        &arguments.file,
        &arguments.source,
        &asked,
        is_kept,
        &mut watch,
    )?;
    let result = report::result(&subject, arguments.mode, &timed);
    if let Some(file) = &arguments.out {
        match timed.outcome.proved || export::Form::of(file)? == export::Form::Json {
            true => export::write(file, &result)?,
            false => eprintln!(
                "taut: {} is not written: only .json says that its path is not proved",
                file.display()
            ),
        }
    }
    let mut out = std::io::stdout().lock();
    match arguments.format {
        Format::Json => writeln!(out, "{}", result.json()),
        Format::Table => {
            report::warn(&report::told(&subject, &timed), "");
            let outcome = &timed.outcome;
            let time = report::time(timed.time_s);
            let details = details::of_shortening(&subject, &timed);
            writeln!(
                out,
                "{}   {}   {time}{details}",
                report::lengths(outcome),
                report::verdict(&timed)
            )
        }
    }
    .map_err(stdout)?;
    Ok(timed.code.exit_code())
}
