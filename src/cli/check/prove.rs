//! `taut check`: prove paths, change nothing.

use std::path::Path;

use taut::files::Reader;
use taut_ipc::wire::Mode;

use super::arguments::Arguments;
use crate::cli::answer::answer;
use crate::cli::answered::Answered;
use crate::cli::asked::Asked;
use crate::cli::details;
use crate::cli::error::CliError;
use crate::cli::format::{Format, print_line};
use crate::cli::load;
use crate::cli::place::Place;
use crate::cli::report;
use crate::cli::subject::Subject;

/// Checks every file.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let asked = arguments.asked()?;
    let place = Place::open(&arguments.place)?;
    Ok(arguments.highest(|file| check(arguments, &asked, file, &mut reader, &place)))
}

fn check(
    arguments: &Arguments,
    asked: &Asked,
    file: &Path,
    reader: &mut Reader,
    place: &Place,
) -> Result<u8, CliError> {
    let is_kept = arguments.format == Format::Json;
    let source = &arguments.source;
    let (subject, answered) = answer(place, reader, file, source, asked, is_kept, &mut |_, _| {})?;
    arguments.write_certificate(answered.outcome.certificate.as_ref())?;
    let text = match arguments.format {
        Format::Json => report::result(&subject, Mode::Check, &answered).json(),
        Format::Table => table(arguments, &subject, &answered),
    };
    print_line(&text)?;
    Ok(answered.code.exit_code())
}

/// The verdict for people, its warnings on standard error. A list of many files stays a line each.
fn table(arguments: &Arguments, subject: &Subject, answered: &Answered) -> String {
    match arguments.files.len() {
        1 => of_one(subject, answered),
        _ => of_several(subject, answered),
    }
}

fn of_one(subject: &Subject, answered: &Answered) -> String {
    report::warn(&report::told(subject, answered), "");
    line(answered) + &details::of_check(answered)
}

fn of_several(subject: &Subject, answered: &Answered) -> String {
    let name = format!("{}: ", subject.name);
    report::warn(&report::told(subject, answered), &name);
    name + &line(answered)
}

fn line(answered: &Answered) -> String {
    let time = report::time(answered.time_s);
    format!("{}   {time}", report::verdict(answered))
}
