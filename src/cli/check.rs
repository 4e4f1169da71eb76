//! `taut check`: prove paths, change nothing.

use std::io::Write;
use std::path::{Path, PathBuf};

use taut::files::Reader;
use taut::optimize::Mode;

use super::error::{CliError, stdout};
use super::place::{self, Place};
use super::report::{self, Answer};
use super::request::{Rules, Source};
use super::{Format, load};

/// Prove that paths are collision-free, for every instant of their motion
///
/// Exit code: 0 all proved, 1 a collision, 2 not provable, 64 usage, 65 a bad file, 66 an unreadable one,
/// 69 no daemon; of several files, the highest.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Problem files, or bare paths (.json, .csv)
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    rules: Rules,
    #[command(flatten)]
    place: place::Choice,
    /// Format of the answers
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Checks every file; one that cannot be read does not keep the others from being checked.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let mut place = Place::open(&arguments.place)?;
    let mut exit = 0;
    for file in &arguments.files {
        let checked = check(arguments, file, &mut reader, &mut place);
        exit = exit.max(match checked {
            Ok(code) => code,
            Err(error) => error.report(),
        });
    }
    Ok(exit)
}

fn check(arguments: &Arguments, file: &Path, reader: &mut Reader, place: &mut Place) -> Result<u8, CliError> {
    let (source, rules) = (&arguments.source, &arguments.rules);
    let (subject, timed) = place.answer(reader, file, source, rules, Mode::Check, &mut |_, _| {})?;
    let mut out = std::io::stdout().lock();
    match arguments.format {
        Format::Json => writeln!(out, "{}", Answer::new(&subject, Mode::Check, &timed).json()),
        Format::Table => {
            let several = if arguments.files.len() > 1 { format!("{}: ", subject.name) } else { String::new() };
            for warning in subject.warnings.iter().chain(&timed.outcome.warnings) {
                eprintln!("warning: {several}{warning}");
            }
            writeln!(out, "{several}{}   {}", report::verdict(&timed), report::time(timed.time_s))
        }
    }
    .map_err(stdout)?;
    Ok(timed.code.exit_code())
}
