//! Scenes and diffs as YAML: ours, or MoveIt's planning scenes as `ros2 topic echo` and
//! MotionBenchMaker write them.

use super::yaml;
use crate::scene::diff_file::DiffFile;
use crate::scene::scene_file::SceneFile;

/// The JSON of a scene file for a YAML text.
///
/// # Errors
/// What is wrong, with its line and column where they are known.
pub(super) fn json(text: &str) -> Result<String, String> {
    let mut documents: Vec<SceneFile> = yaml::documents(text)?;
    match documents.len() {
        1 => serde_json::to_string(&documents.swap_remove(0)).map_err(|error| error.to_string()),
        0 => Err("it holds no YAML document; a scene is one".to_owned()),
        count => {
            let lines: Vec<String> = yaml::document_lines(text)
                .iter()
                .map(usize::to_string)
                .collect();
            let lines = lines.join(", ");
            Err(format!(
                "it holds {count} YAML documents (from lines {lines}); a scene is one: keep the one that is meant"
            ))
        }
    }
}

/// The JSON of a diff for a YAML text, whose documents are made one after the other.
///
/// # Errors
/// As [`json`].
pub(super) fn diff_json(text: &str) -> Result<String, String> {
    let diff = DiffFile::of(yaml::documents(text)?).map_err(|error| error.to_string())?;
    Ok(diff.text())
}
