//! Answers as `taut shorten -o` writes them, to be read again: a path, and what is known of it.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{FileError, read_text};

/// What is read of an answer; the rest is ignored.
#[derive(Clone, Debug, Deserialize)]
pub struct ResultFile {
    /// The file.
    #[serde(skip)]
    pub file: PathBuf,
    /// Label of the problem.
    #[serde(default)]
    pub name: String,
    /// Columns of the path.
    pub variables: Vec<String>,
    /// Weights of the metric, one per velocity coordinate.
    #[serde(default)]
    pub weights: Vec<f64>,
    /// The path, proved or not.
    pub path: Vec<Vec<f64>>,
    /// The path as it was asked about, where the answer has it.
    pub path_before: Option<Vec<Vec<f64>>>,
    /// How far what is executed may stray from the path, where it was asked for.
    pub corridor: Option<CorridorFile>,
    /// The certificate, as it stands.
    pub certificate: Option<serde_json::Value>,
}

/// A corridor: every pair keeps `floor_m` at any q with Σ reach_m |q − p| ≤ slack_m around a p of the segment.
#[derive(Clone, Debug, Deserialize)]
pub struct CorridorFile {
    /// What every pair keeps (m).
    pub floor_m: f64,
    /// Velocity coordinates, in the order of the columns.
    pub coordinates: Vec<CoordinateFile>,
    /// One per segment of the path (m).
    pub slack_m: Vec<f64>,
}

/// A velocity coordinate of a corridor.
#[derive(Clone, Debug, Deserialize)]
pub struct CoordinateFile {
    /// The variable that it belongs to.
    pub variable: String,
    /// `line`, `circle` or `rotation`.
    pub kind: String,
    /// How far bodies move at most against each other (m per rad or m).
    pub reach_m: f64,
}

impl ResultFile {
    /// Reads an answer.
    ///
    /// # Errors
    /// A file that cannot be read, is no answer, or has rows of another length than its columns.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        Self::parse(&read_text(file)?, file)
    }

    /// The same from its text; `file` is what messages call it.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(text: &str, file: &Path) -> Result<Self, FileError> {
        let refuse = |text: String| FileError::Content { file: file.to_owned(), text };
        let mut result: Self = serde_json::from_str(text)
            .map_err(|error| refuse(format!("not an answer of `taut shorten` or `taut check` as JSON: {error}")))?;
        file.clone_into(&mut result.file);
        let columns = result.variables.len();
        for (field, rows) in [("path", Some(&result.path)), ("path_before", result.path_before.as_ref())] {
            let Some(rows) = rows else { continue };
            if rows.is_empty() {
                return Err(refuse(format!("its {field} is empty")));
            }
            if let Some((index, row)) = rows.iter().enumerate().find(|(_, row)| row.len() != columns) {
                return Err(refuse(format!(
                    "{field} row {index} has {} numbers, \"variables\" names {columns}",
                    row.len()
                )));
            }
        }
        if let Some(corridor) = &result.corridor {
            let (got, segments) = (corridor.slack_m.len(), result.path.len().saturating_sub(1).max(1));
            if got != segments {
                return Err(refuse(format!("its corridor has {got} segments, its path {segments}")));
            }
        }
        Ok(result)
    }
}
