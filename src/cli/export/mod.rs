//! `taut export`, and `-o`: an answer in the form that another program reads.

mod mcap;
mod picture;
mod surroundings;
mod text;
mod trajectory;

use std::path::{Path, PathBuf};

use taut::files::ResultFile;
use taut::validation::Certificate;
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
    /// Where to; its ending says the form: .json, .csv, .yaml (JointTrajectory,
    /// with times where the answer has them), .mcap (for viewers)
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
            .unwrap_or_default()
            .to_string_lossy();
        match ending.to_lowercase().as_str() {
            "json" => Ok(Self::Json),
            "csv" => Ok(Self::Csv),
            "yaml" | "yml" => Ok(Self::Yaml),
            "mcap" => Ok(Self::Mcap),
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
    let result = ResultFile::read(&arguments.result)?;
    let bytes = match arguments.what {
        What::Path => path(arguments, form, &result)?,
        What::Corridor => corridor(&arguments.result, form, &result)?,
        What::Certificate => certificate(&arguments.result, form, &result)?,
    };
    save(&arguments.out, &bytes)?;
    Ok(0)
}

fn path(arguments: &Arguments, form: Form, result: &ResultFile) -> Result<Vec<u8>, CliError> {
    let source = &arguments.source;
    let is_given = source.robot.is_some() || source.problem.is_some();
    let around = match form {
        Form::Json => return Ok(text::json(result).into_bytes()),
        Form::Mcap if is_given => Some(Surroundings::given(&arguments.result, source)?),
        Form::Mcap => Surroundings::of(result)?,
        Form::Csv | Form::Yaml => None,
    };
    bytes(result, form, around.as_ref())
}

fn corridor(answer: &Path, form: Form, result: &ResultFile) -> Result<Vec<u8>, CliError> {
    let write = match form {
        Form::Csv => text::corridor_csv,
        Form::Json => text::corridor_json,
        Form::Yaml | Form::Mcap => {
            return Err(not_written("a corridor is written as .csv or .json"));
        }
    };
    let corridor = result
        .corridor
        .as_ref()
        .ok_or_else(|| has_no(answer, "corridor; ask for it by taut shorten --corridor"))?;
    Ok(write(corridor).into_bytes())
}

fn certificate(answer: &Path, form: Form, result: &ResultFile) -> Result<Vec<u8>, CliError> {
    if form != Form::Json {
        return Err(not_written("a certificate is written as .json"));
    }
    let certificate = result
        .certificate
        .as_ref()
        .ok_or_else(|| has_no(answer, "certificate: its path was not proved"))?;
    Ok(format!("{}\n", serde_json::json!(certificate)).into_bytes())
}

fn not_written(why: &str) -> CliError {
    CliError::Usage(why.to_owned())
}

fn has_no(answer: &Path, what: &str) -> CliError {
    CliError::Choice(format!("{} has no {what}", answer.display()))
}

/// Writes an answer in the form that a file's ending says.
///
/// # Errors
/// A path that was not proved, which only JSON tells from one that was; a file that cannot be
/// written.
pub(super) fn write(file: &Path, result: &ResultFile) -> Result<(), CliError> {
    let form = Form::of(file)?;
    let around = match form {
        Form::Mcap => Surroundings::of(result)?,
        _ => None,
    };
    save(file, &bytes(result, form, around.as_ref())?)
}

fn bytes(
    result: &ResultFile,
    form: Form,
    around: Option<&Surroundings>,
) -> Result<Vec<u8>, CliError> {
    if form != Form::Json {
        check_proof(result).map_err(|text| CliError::Choice(format!("{}: {text}", result.name)))?;
    }
    match form {
        Form::Json => Ok((result.json() + "\n").into_bytes()),
        Form::Csv => Ok(text::csv(result).into_bytes()),
        Form::Yaml => Ok(match trajectory::of(result) {
            Some(found) => trajectory::yaml(result, found),
            None => text::yaml(result),
        }
        .into_bytes()),
        Form::Mcap => mcap::bytes(result, around),
    }
}

/// Checks that the numbers of the path are those that were proved: what is written says so.
fn check_proof(result: &ResultFile) -> Result<(), String> {
    let certificate = result
        .certificate
        .as_ref()
        .ok_or("the path was not proved; only JSON, which says so, is written of it")?;
    check_version(certificate)?;
    match is_about(certificate, result) {
        true => Ok(()),
        false => Err(
            "its path is not the one that its certificate is about; check it again: taut check"
                .to_owned(),
        ),
    }
}

/// Whether a certificate is about the path of an answer.
fn is_about(certificate: &Certificate, result: &ResultFile) -> bool {
    taut::path::Path::from_rows(result.variables.len(), result.path.concat())
        .is_some_and(|path| path.hash() == certificate.path_hash)
}

/// Checks that a certificate is about numbers that mean what they say.
fn check_version(certificate: &Certificate) -> Result<(), String> {
    let version = certificate.checker_version;
    if version >= FIRST_BY_NUMBERS || certificate.unwrapped {
        return Ok(());
    }
    Err(format!(
        "it was proved by checker version {version}, whose steps may mean other numbers; check its path again: \
         taut check"
    ))
}

pub(super) fn save(file: &Path, bytes: &[u8]) -> Result<(), CliError> {
    std::fs::write(file, bytes).map_err(CliError::output(file))
}
