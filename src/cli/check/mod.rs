//! `taut check`: four commands under one name, by what they prove.

mod against;
mod arguments;
mod certificate;
mod prove;
mod timed;

pub(super) use timed::{code_of_hit, held};
mod watch;

pub(super) use arguments::Arguments;

use super::error::CliError;

/// Does what the flags say.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    arguments.check_counts()?;
    match arguments {
        Arguments {
            certificate: Some(proof),
            ..
        } => certificate::run(arguments, proof),
        Arguments {
            against: Some(answer),
            ..
        } => Ok(arguments.highest(|file| against::run(arguments, file, answer))),
        Arguments { timed: true, .. } => timed::run(arguments),
        Arguments { watch: true, .. } => watch::run(arguments),
        _ => prove::run(arguments),
    }
}
