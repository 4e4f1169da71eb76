//! `taut check`: prove paths, change nothing.

use std::io::Write;
use std::path::Path;

use taut::files::Reader;
use taut_ipc::wire::Mode;

use super::arguments::Arguments;
use crate::cli::answer::answer;
use crate::cli::answered::Answered;
use crate::cli::asked::Asked;
use crate::cli::details;
use crate::cli::error::{CliError, stdout};
use crate::cli::format::Format;
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
    write_certificate(arguments, &answered)?;
    let text = match arguments.format {
        Format::Json => report::result(&subject, Mode::Check, &answered).json(),
        Format::Table => table(arguments, &subject, &answered),
    };
    writeln!(std::io::stdout().lock(), "{text}").map_err(stdout)?;
    Ok(answered.code.exit_code())
}

fn write_certificate(arguments: &Arguments, answered: &Answered) -> Result<(), CliError> {
    let certificate = &answered.outcome.certificate;
    let (Some(file), Some(certificate)) = (&arguments.write_certificate, certificate) else {
        return Ok(());
    };
    let text =
        serde_json::to_string(certificate).expect("a certificate holds only strings and numbers");
    std::fs::write(file, text + "\n").map_err(|source| CliError::Output {
        file: file.display().to_string(),
        source,
    })
}

/// The verdict for people, its warnings on standard error. A list of many files stays a line each.
fn table(arguments: &Arguments, subject: &Subject, answered: &Answered) -> String {
    let (several, details) = match arguments.files.len() {
        1 => (String::new(), details::of_check(answered)),
        _ => (format!("{}: ", subject.name), String::new()),
    };
    report::warn(&report::told(subject, answered), &several);
    format!(
        "{several}{}   {}{details}",
        report::verdict(answered),
        report::time(answered.time_s)
    )
}
