//! The table of what other programs read, and whether two readings are the same.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;
use serde_json::Value;

/// Numbers are the same within this, of the size of a surface or of one metre.
const TOLERANCE: f64 = 1e-5;

/// `expected.json`.
#[derive(Deserialize)]
pub struct Table {
    /// Readers by name.
    pub readers: BTreeMap<String, ReaderOf>,
    /// What they read, by file.
    pub files: BTreeMap<String, Readings>,
}

/// A program that reads files.
#[derive(Deserialize)]
pub struct ReaderOf {
    /// Package and version, of the library beneath too.
    #[serde(rename = "version")]
    pub _version: String,
    /// Readers of one family share their code: they count once.
    pub family: String,
}

/// What is read in a file.
#[derive(Deserialize)]
pub struct Readings {
    /// Digest of the file's content.
    pub digest: String,
    /// By aspect, each meaning and whose it is.
    pub meanings: BTreeMap<String, Vec<Meaning>>,
    /// Who refuses it.
    pub refused: BTreeMap<String, String>,
}

/// What some readers read.
#[derive(Deserialize)]
pub struct Meaning {
    /// Readers that read this.
    pub readers: BTreeSet<String>,
    /// What they read.
    pub value: Value,
}

impl Table {
    /// How many readers of their own code a meaning has.
    pub fn independent(&self, meaning: &Meaning) -> usize {
        meaning
            .readers
            .iter()
            .filter_map(|name| self.readers.get(name))
            .map(|r| &r.family)
            .collect::<BTreeSet<_>>()
            .len()
    }

    /// The meaning of most independent readers, at least two and more than any other; `None` where
    /// there is none.
    pub fn common<'a>(&self, meanings: &'a [Meaning]) -> Option<&'a Meaning> {
        let best = meanings
            .iter()
            .max_by_key(|meaning| self.independent(meaning))?;
        let most = self.independent(best);
        let is_alone = meanings
            .iter()
            .filter(|meaning| self.independent(meaning) == most)
            .count()
            == 1;
        (most >= 2 && is_alone).then_some(best)
    }
}

/// The first place where two readings differ.
pub fn difference(ours: &Value, theirs: &Value) -> Option<String> {
    let size = theirs.get("hi").map_or(1.0, |hi| {
        let side =
            |i: usize| hi[i].as_f64().unwrap_or(0.0) - theirs["lo"][i].as_f64().unwrap_or(0.0);
        (side(0).powi(2) + side(1).powi(2) + side(2).powi(2)).sqrt()
    });
    differ(ours, theirs, size, "")
}

fn differ(ours: &Value, theirs: &Value, size: f64, place: &str) -> Option<String> {
    let different = || Some(format!("{place}: {ours} is not {theirs}"));
    match (ours, theirs) {
        (Value::Object(a), Value::Object(b)) => {
            if a.keys().ne(b.keys()) {
                return different();
            }
            a.iter().find_map(|(key, value)| {
                let power = match key.as_str() {
                    "area" => size * size,
                    "volume" => size * size * size,
                    _ => size,
                };
                // Inside is inside, whichever way the surface is turned.
                let solid = |value: &Value| {
                    value
                        .as_f64()
                        .filter(|_| key == "volume")
                        .map(|v| v.abs().into())
                };
                let ours = solid(value);
                let theirs = solid(&b[key]);
                let ours = ours.as_ref().unwrap_or(value);
                let theirs = theirs.as_ref().unwrap_or(&b[key]);
                differ(ours, theirs, power, &format!("{place}.{key}"))
            })
        }
        (Value::Array(a), Value::Array(b)) => {
            if a.len() != b.len() {
                return different();
            }
            a.iter()
                .zip(b)
                .enumerate()
                .find_map(|(i, (a, b))| differ(a, b, size, &format!("{place}[{i}]")))
        }
        (Value::Number(a), Value::Number(b)) => {
            let a = a.as_f64().unwrap_or(f64::NAN);
            let b = b.as_f64().unwrap_or(f64::NAN);
            let near =
                (a - b).abs() <= TOLERANCE * size.max(if size == 1.0 { b.abs() } else { 0.0 });
            if near { None } else { different() }
        }
        _ if ours == theirs => None,
        _ => different(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn readings_differ_by_little_and_surfaces_by_little_of_their_size() {
        let theirs = json!({ "lo": [1e5, 0, 0], "hi": [1e5 + 1.0, 1, 1], "volume": -1.0 });
        assert_eq!(
            difference(
                &json!({ "lo": [1e5, 0, 0], "hi": [1e5 + 1.0, 1, 1], "volume": 1.0 }),
                &theirs
            ),
            None
        );
        for (field, value) in [
            ("lo", json!([1e5 + 1e-3, 0, 0])),
            ("volume", json!(1.001)),
            ("hi", json!([1e5, 1])),
        ] {
            let mut ours = theirs.clone();
            ours[field] = value;
            assert!(
                difference(&ours, &theirs).is_some_and(|text| text.contains(field)),
                "{field}"
            );
        }
        let other = json!({ "arm": [["box", [0.1, 0.2, 0.3], [0, 0, 0, 0, 0, 0, 1]]] });
        assert_eq!(
            difference(
                &json!({ "arm": [["box", [0.1, 0.2, 0.3], [0, 0, 0, 0, 0, 0, 1]]] }),
                &other
            ),
            None
        );
        for ours in [
            json!({}),
            json!({ "arm": [["box", [0.1, 0.2, 0.3002], [0, 0, 0, 0, 0, 0, 1]]] }),
        ] {
            assert!(difference(&ours, &other).is_some(), "{ours}");
        }
        assert!(
            difference(&json!([null, 1.0]), &json!([0.0, 1.0])).is_some(),
            "no limit is not 0"
        );
    }
}
