//! `taut check`: prove paths, change nothing.

use std::io::Write;
use std::path::PathBuf;

use taut::optimize::{Mode, Workspace};

use super::error::{CliError, stdout};
use super::report::{self, Answer};
use super::request::{Rules, Source};
use super::{Format, code::Code, load, run as runner};

/// Prove that paths are collision-free, for every instant of their motion
///
/// Exit code: 0 all proved, 1 a collision, 2 not provable, 64 usage, 65 a bad file, 66 an unreadable one;
/// of several files, the highest.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Problem files, or bare paths (.json, .csv)
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    rules: Rules,
    /// Work in this process, without a daemon
    #[arg(long)]
    local: bool,
    /// Format of the answers
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Checks every file; one that cannot be read does not keep the others from being checked.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let mut reader = load::reader(&arguments.source);
    let mut workspace = Workspace::default();
    let mut exit = 0;
    for file in &arguments.files {
        let loaded = load::load(&mut reader, file, &arguments.source, false);
        let checked = loaded.and_then(|loaded| check(arguments, &loaded, &mut workspace));
        exit = exit.max(match checked {
            Ok(code) => code,
            Err(error) => error.report(),
        });
    }
    Ok(exit)
}

fn check(arguments: &Arguments, loaded: &load::Loaded, workspace: &mut Workspace) -> Result<u8, CliError> {
    let nv = loaded.model.robot().space().nv();
    let settings = arguments.rules.settings(Mode::Check, loaded.weights.as_ref(), nv).map_err(CliError::Usage)?;
    let timed = runner::run(loaded, &settings, arguments.rules.deadline, workspace, &mut |_, _| {})?;
    let mut out = std::io::stdout().lock();
    match arguments.format {
        Format::Json => writeln!(out, "{}", Answer::new(loaded, Mode::Check, &timed).json()),
        Format::Table => {
            let several = if arguments.files.len() > 1 { format!("{}: ", loaded.name) } else { String::new() };
            for warning in loaded.warnings.iter().chain(&timed.outcome.warnings) {
                eprintln!("warning: {several}{warning}");
            }
            writeln!(out, "{several}{}   {}", report::verdict(&timed.outcome), report::time(timed.time_s))
        }
    }
    .map_err(stdout)?;
    Ok(Code::of(&timed.outcome).exit_code())
}
