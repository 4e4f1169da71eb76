//! Where a cloud comes from, so that texts can say it and it can be made again.

use crate::warning::Warning;

/// The file of a cloud, and what was made of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The file as the scene calls it.
    pub file: String,
    /// What was made of it.
    pub making: Making,
}

/// What is made of a file of points, or of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Making {
    /// Balls about points.
    Points {
        /// Their radius (m), before thinning makes them thicker.
        radius: f64,
        /// Edge of the cells (m) that keep one point each.
        thin: Option<f64>,
    },
    /// The cells of an octomap.
    Map {
        /// What unknown space is.
        unknown: Unknown,
    },
}

/// What unknown space of a map is to a verdict. Nothing but the user can say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Nothing: paths may cross it.
    Free,
    /// As solid as what is occupied.
    Obstacle,
}

impl Unknown {
    /// Both, with their words.
    pub const WORDS: [(&str, Self); 2] = [("free", Self::Free), ("obstacle", Self::Obstacle)];

    /// The one of a word.
    pub fn named(word: &str) -> Option<Self> {
        let found = Self::WORDS
            .iter()
            .find(|(known, _)| *known == word);
        found.map(|(_, unknown)| *unknown)
    }

    /// Its word.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize].0
    }
}

/// What is known of a cloud besides its cells; no part of its content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Its file, if it is all that was made of one.
    pub source: Option<Source>,
    /// Number of the first cell that nobody has seen: those before it are occupied.
    pub unknown_from: Option<usize>,
    /// What is odd about it, or does not follow from it, a line each.
    pub warnings: Vec<Warning>,
}
