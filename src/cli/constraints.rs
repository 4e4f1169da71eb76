//! What a path must keep besides clearance, as flags.

use std::path::Path;

use taut::constraint::ConstraintsFile;
use taut::files::constraints_of;

use super::error::CliError;

/// The flags' names among those of a command.
pub(super) const FLAGS: [&str; 3] = ["path_constraints", "keep_upright", "keep"];

/// What the flags ask for; all of it must hold, with what the path's file asks for.
#[derive(clap::Args)]
pub(super) struct Constraints {
    /// What the path must keep besides clearance: MoveIt's Constraints as JSON, or a file that is
    /// or has them (.json, .yaml); repeatable
    #[arg(long, value_name = "FILE|JSON")]
    path_constraints: Vec<String>,
    /// Keep an axis of a link upright: hand:x=0.1 keeps hand's x axis within 0.1 rad of +z of the
    /// world; -z is the opposite axis, 5deg an angle in degrees, and hand:x=0.1@start is about
    /// where the axis points at the first waypoint; repeatable
    #[arg(long, value_name = "LINK:AXIS=ANGLE", value_parser = upright)]
    keep_upright: Vec<ConstraintsFile>,
    /// Keep a point of a link in a region (m): "hand@0,0,0.1 in box 0.4,0.4,0.1 at 0.5,0,0.3", "…
    /// in ball RADIUS at …", "… in cylinder RADIUS,LENGTH at …", then "of FRAME" or nothing;
    /// repeatable
    #[arg(long, value_name = "LINK in REGION", value_parser = keep)]
    keep: Vec<ConstraintsFile>,
}

fn upright(words: &str) -> Result<ConstraintsFile, String> {
    of_words("upright", words)
}

fn keep(words: &str) -> Result<ConstraintsFile, String> {
    of_words("keep", words)
}

fn of_words(verb: &str, words: &str) -> Result<ConstraintsFile, String> {
    ConstraintsFile::parse(&format!("{verb} {words}")).map_err(|error| error.to_string())
}

impl Constraints {
    /// All that they ask for.
    ///
    /// # Errors
    /// A file that cannot be read, a text that is no constraint.
    pub(super) fn all(&self) -> Result<ConstraintsFile, CliError> {
        let mut all = ConstraintsFile::default();
        for given in &self.path_constraints {
            all = all.and(of_text_or_file(given)?);
        }
        let words = self.keep_upright.iter().chain(&self.keep);
        Ok(words.fold(all, |all, next| all.and(next.clone())))
    }
}

fn of_text_or_file(given: &str) -> Result<ConstraintsFile, CliError> {
    match given.trim_start().starts_with(['{', '[']) {
        true => ConstraintsFile::parse(given)
            .map_err(|error| CliError::Usage(format!("--path-constraints: {error}"))),
        false => Ok(constraints_of(Path::new(given))?),
    }
}
