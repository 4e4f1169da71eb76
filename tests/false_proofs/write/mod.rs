//! Writes what was made as the files that users have.

pub mod mesh;
pub mod path;
pub mod robot;
pub mod scene;

/// Numbers as a list in text; every bit is read back.
pub fn words(numbers: &[f64]) -> String {
    numbers
        .iter()
        .map(f64::to_string)
        .collect::<Vec<_>>()
        .join(" ")
}
