//! What a person should know beside a verdict: what it does not cover, and what is merely odd.

use std::collections::HashSet;
use std::fmt;
use std::ops::Deref;

/// A line for people. It reads as its text.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Warning {
    class: WarningClass,
    text: String,
}

/// What a warning means for a verdict.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum WarningClass {
    /// It says what the verdict does not cover, or rests on: every one is told with every answer.
    Uncovered,
    /// It takes nothing from the verdict. Of those of one topic the first is told and the others
    /// are counted.
    Cosmetic {
        /// What such warnings have in common.
        topic: String,
    },
}

impl Warning {
    /// What a verdict does not cover, or rests on.
    pub fn uncovered(text: impl Into<String>) -> Self {
        Self {
            class: WarningClass::Uncovered,
            text: text.into(),
        }
    }

    /// What is odd and takes nothing from a verdict; `topic` is what such warnings have in common.
    pub fn cosmetic(topic: &str, text: impl Into<String>) -> Self {
        Self {
            class: WarningClass::Cosmetic {
                topic: topic.to_owned(),
            },
            text: text.into(),
        }
    }

    /// The same in other words.
    pub fn reworded(&self, text: impl Into<String>) -> Self {
        Self {
            class: self.class.clone(),
            text: text.into(),
        }
    }

    /// The line.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What it means for a verdict.
    pub fn class(&self) -> &WarningClass {
        &self.class
    }

    /// Whether it says what a verdict does not cover.
    pub fn is_uncovered(&self) -> bool {
        self.class == WarningClass::Uncovered
    }
}

impl Deref for Warning {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl PartialEq<&str> for Warning {
    fn eq(&self, text: &&str) -> bool {
        self.text == *text
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// What an answer tells of warnings: each once; first all that say what the verdict does not cover,
/// then one cosmetic one per topic, which counts those that it stands for.
pub fn told<'a>(warnings: impl IntoIterator<Item = &'a Warning>) -> Vec<Warning> {
    let mut uncovered: Vec<Warning> = Vec::new();
    let mut topics: Vec<(&str, Vec<&Warning>)> = Vec::new();
    let mut seen: HashSet<&Warning> = HashSet::new();
    for warning in warnings {
        if !seen.insert(warning) {
            continue;
        }
        match &warning.class {
            WarningClass::Uncovered => uncovered.push(warning.clone()),
            WarningClass::Cosmetic { topic } => {
                match topics
                    .iter_mut()
                    .find(|(known, _)| known == topic)
                {
                    Some((_, alike)) => alike.push(warning),
                    None => topics.push((topic, vec![warning])),
                }
            }
        }
    }
    let counted = |(_, alike): (&str, Vec<&Warning>)| match alike.len() {
        1 => alike[0].clone(),
        count => alike[0].reworded(format!("{} (and {} more like it)", alike[0], count - 1)),
    };
    uncovered
        .into_iter()
        .chain(topics.into_iter().map(counted))
        .collect()
}

/// A number with a space before each three digits.
pub fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let first = digits.len() % 3;
    let (head, tail) = digits.split_at(first);
    let groups = tail.as_bytes().chunks(3);
    let groups = groups.map(|group| String::from_utf8_lossy(group).into_owned());
    let parts = std::iter::once(head.to_owned()).chain(groups);
    let parts: Vec<String> = parts.filter(|part| !part.is_empty()).collect();
    parts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_stand_in_threes() {
        let numbers = [0, 12, 123_456, 1_234_567];
        assert_eq!(numbers.map(grouped), ["0", "12", "123 456", "1 234 567"]);
    }

    #[test]
    fn what_is_not_covered_is_told_in_full_and_first_and_repeated_trifles_are_counted() {
        let trifle = |n: usize| Warning::cosmetic("pairs", format!("pair {n}"));
        let mut warnings: Vec<Warning> = (1..=104).map(trifle).collect();
        warnings.extend([
            Warning::uncovered("no SRDF"),
            Warning::cosmetic("axis", "axis ignored"),
        ]);
        warnings.extend([
            Warning::uncovered("an empty object"),
            Warning::uncovered("no SRDF"),
            trifle(1),
        ]);
        let told = told(&warnings);
        let texts: Vec<&str> = told.iter().map(|warning| &**warning).collect();
        assert_eq!(
            texts,
            [
                "no SRDF",
                "an empty object",
                "pair 1 (and 103 more like it)",
                "axis ignored"
            ]
        );
        assert_eq!(
            told.iter()
                .filter(|warning| warning.is_uncovered())
                .count(),
            2
        );
    }
}
