//! `taut export`, and `-o`: an answer in the form that another program reads.

mod mcap;
mod picture;
mod surroundings;
mod text;

use std::path::{Path, PathBuf};

use taut::files::ResultFile;
use taut::validation::certificate::FIRST_BY_NUMBERS;

use super::error::CliError;
use super::source::Source;
use surroundings::Surroundings;

/// Write an answer of `taut shorten -o RESULT.json` in another form, without computing it again
///
/// Exit code: 0 written, 64 usage, 65 a bad file or a path that was not proved, 66 an unreadable
/// one.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// The answer
    result: PathBuf,
    /// Where to; its ending says the form: .json, .csv, .yaml (JointTrajectory without times),
    /// .mcap (for viewers)
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// What to write
    #[arg(long, value_enum, default_value_t)]
    what: What,
    /// For .mcap: robot and scene, where the answer only has the labels that a daemon gave them
    #[command(flatten)]
    source: Source,
}

/// Parts of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum What {
    /// The path
    #[default]
    Path,
    /// How far what is executed may stray from it, segment by segment (.csv, .json)
    Corridor,
    /// The certificate, for `taut check --certificate` (.json)
    Certificate,
}

/// A form of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Json,
    Csv,
    Yaml,
    Mcap,
}

impl Form {
    /// The form that a file's ending says.
    ///
    /// # Errors
    /// Another ending, with the valid ones.
    pub(super) fn of(file: &Path) -> Result<Self, CliError> {
        let ending = file
            .extension()
            .map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("json") => Ok(Self::Json),
            Some("csv") => Ok(Self::Csv),
            Some("yaml" | "yml") => Ok(Self::Yaml),
            Some("mcap") => Ok(Self::Mcap),
            _ => Err(CliError::Usage(format!(
                "-o {}: its ending says no form; valid: .json, .csv, .yaml, .mcap",
                file.display()
            ))),
        }
    }
}

/// Writes an answer in another form.
pub(super) fn run(arguments: &Arguments) -> Result<u8, CliError> {
    let form = Form::of(&arguments.out)?;
    let file = &arguments.out;
    let result = ResultFile::read(&arguments.result)?;
    let missing = |what: &str, next: &str| {
        CliError::Choice(format!(
            "{} has no {what}{next}",
            arguments.result.display()
        ))
    };
    let bytes = match (arguments.what, form) {
        (What::Path, Form::Json) => text::json(&result).into_bytes(),
        (What::Path, _) => {
            let is_given = arguments.source.robot.is_some() || arguments.source.problem.is_some();
            let around = match form {
                Form::Mcap if is_given => {
                    Some(Surroundings::given(&arguments.result, &arguments.source)?)
                }
                Form::Mcap => Surroundings::of(&result)?,
                _ => None,
            };
            bytes(&result, form, around.as_ref())?
        }
        (What::Corridor, Form::Csv | Form::Json) => {
            let corridor = result.corridor.as_ref();
            let corridor = corridor
                .ok_or_else(|| missing("corridor", "; ask for it by taut shorten --corridor"))?;
            match form {
                Form::Csv => text::corridor_csv(corridor),
                _ => text::corridor_json(corridor),
            }
            .into_bytes()
        }
        (What::Certificate, Form::Json) => {
            let certificate = result.certificate.as_ref();
            let certificate =
                certificate.ok_or_else(|| missing("certificate", ": its path was not proved"))?;
            format!("{}\n", serde_json::json!(certificate)).into_bytes()
        }
        (What::Corridor, _) => {
            return Err(CliError::Usage(
                "a corridor is written as .csv or .json".to_owned(),
            ));
        }
        (What::Certificate, _) => {
            return Err(CliError::Usage(
                "a certificate is written as .json".to_owned(),
            ));
        }
    };
    save(file, &bytes)?;
    Ok(0)
}

/// Writes an answer in the form that a file's ending says.
///
/// # Errors
/// A path that was not proved, which only JSON tells from one that was; a file that cannot be
/// written.
pub(super) fn write(file: &Path, result: &ResultFile) -> Result<(), CliError> {
    let form = Form::of(file)?;
    let around = if form == Form::Mcap {
        Surroundings::of(result)?
    } else {
        None
    };
    save(file, &bytes(result, form, around.as_ref())?)
}

fn bytes(
    result: &ResultFile,
    form: Form,
    around: Option<&Surroundings>,
) -> Result<Vec<u8>, CliError> {
    if form == Form::Json {
        return Ok((result.json() + "\n").into_bytes());
    }
    check_proof(result).map_err(|text| CliError::Choice(format!("{}: {text}", result.name)))?;
    Ok(match form {
        Form::Csv => text::csv(result).into_bytes(),
        Form::Yaml => text::yaml(result).into_bytes(),
        Form::Json | Form::Mcap => mcap::bytes(result, around)?,
    })
}

/// Checks that the numbers of the path are those that were proved: what is written says so.
fn check_proof(result: &ResultFile) -> Result<(), String> {
    let Some(certificate) = &result.certificate else {
        return Err(
            "the path was not proved; only JSON, which says so, is written of it".to_owned(),
        );
    };
    let version = certificate.checker_version;
    if version < FIRST_BY_NUMBERS && !certificate.unwrapped {
        return Err(format!(
            "it was proved by checker version {version}, whose steps may mean other numbers; check its path again: \
             taut check"
        ));
    }
    let path = taut::path::Path::from_rows(result.variables.len(), result.path.concat());
    match path.is_some_and(|path| path.hash() == certificate.path_hash) {
        true => Ok(()),
        false => Err(
            "its path is not the one that its certificate is about; check it again: taut check"
                .to_owned(),
        ),
    }
}

fn save(file: &Path, bytes: &[u8]) -> Result<(), CliError> {
    std::fs::write(file, bytes).map_err(|source| CliError::Output {
        file: file.display().to_string(),
        source,
    })
}
