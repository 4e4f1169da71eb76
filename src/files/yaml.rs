//! YAML texts of one or several documents. Numbers are read as Rust reads them: to the last bit.

use serde::de::DeserializeOwned;

use crate::scene::with_nearest;

/// Nodes of a text: what path limits allow, and far more.
const MOST_NODES: usize = 100_000_000;

/// Whether a file is YAML, by its name.
pub(super) fn is_yaml(file: &std::path::Path) -> bool {
    let known = |extension: &std::ffi::OsStr| {
        ["yaml", "yml"]
            .iter()
            .any(|yaml| extension.eq_ignore_ascii_case(yaml))
    };
    file.extension().is_some_and(known)
}

/// The documents of a text, empty ones left out.
///
/// # Errors
/// What is wrong, with its line.
pub(super) fn documents<T: DeserializeOwned>(text: &str) -> Result<Vec<T>, String> {
    let budget = serde_saphyr::budget! { max_nodes: MOST_NODES, max_events: 4 * MOST_NODES };
    // As YAML 1.2 has it: `y` is a good name of a column, not a boolean.
    let options =
        serde_saphyr::options! { budget: budget, with_snippet: false, strict_booleans: true };
    serde_saphyr::from_multiple_with_options(text, options).map_err(|error| {
        let place = |location: serde_saphyr::Location| {
            format!("line {} column {}: ", location.line(), location.column())
        };
        let line = error.location().map_or(String::new(), place);
        let said = error.without_snippet().to_string();
        let said: Vec<&str> = said
            .lines()
            .map(str::trim)
            .filter(|line| !line.is_empty())
            .collect();
        let hint = match text.contains("'...'") {
            true => "; `ros2 topic echo` cut its lists: use --full-length",
            false => "",
        };
        let said = said.join(" ");
        // The place stands before it.
        let text = said
            .rsplit_once(" at line ")
            .map_or(said.as_str(), |(text, _)| text);
        with_nearest(&format!("{line}{text}{hint}"))
    })
}

/// Lines where the documents of a text begin, from 1; those left out that are empty.
pub(super) fn document_lines(text: &str) -> Vec<usize> {
    let is_content =
        |line: &str| !(line.trim().is_empty() || line.starts_with('#') || line.starts_with("..."));
    let mut starts = Vec::new();
    let mut is_new = true;
    for (index, line) in text.lines().enumerate() {
        let rest = line.strip_prefix("---");
        is_new |= rest.is_some();
        if is_new && is_content(rest.unwrap_or(line)) {
            starts.push(index + 1);
            is_new = false;
        }
    }
    starts
}
