//! Paddings and scales by name as JSON has them: MoveIt's list, or a map.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::numbers::Finite;

/// Paddings (m) by name.
pub type Paddings = Numbers<false>;
/// Scales by name.
pub type Scales = Numbers<true>;

/// Numbers by name, `padding` or `scale` in MoveIt's list.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(transparent)]
pub struct Numbers<const SCALES: bool>(pub(super) BTreeMap<String, f64>);

impl<const SCALES: bool> Numbers<SCALES> {
    const FIELD: &'static str = if SCALES { "scale" } else { "padding" };

    pub(super) fn of<'a>(numbers: impl Iterator<Item = (&'a str, f64)>) -> Self {
        Self(
            numbers
                .map(|(name, number)| (name.to_owned(), number))
                .collect(),
        )
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn add<E: Error>(&mut self, name: String, number: f64) -> Result<(), E> {
        match self.0.insert(name.clone(), number) {
            None => Ok(()),
            Some(before) => {
                let field = Self::FIELD;
                Err(E::custom(format!(
                    "link_{field} gives {name:?} both {before} and {number}; give it one"
                )))
            }
        }
    }
}

impl<'de, const SCALES: bool> Deserialize<'de> for Numbers<SCALES> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumbersVisitor)
    }
}

struct NumbersVisitor<const SCALES: bool>;

/// Only one of the two is there; which one, the list says.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    link_name: String,
    padding: Option<Finite>,
    scale: Option<Finite>,
}

impl<'de, const SCALES: bool> Visitor<'de> for NumbersVisitor<SCALES> {
    type Value = Numbers<SCALES>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let field = Numbers::<SCALES>::FIELD;
        let unit = if SCALES { "factors" } else { "lengths (m)" };
        write!(
            f,
            "a list of {{ \"link_name\": …, \"{field}\": … }} or a map from names to {unit}"
        )
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut numbers = Numbers::default();
        while let Some(Entry {
            link_name,
            padding,
            scale,
        }) = list.next_element()?
        {
            let number = if SCALES { scale } else { padding };
            let number = number.ok_or_else(|| A::Error::missing_field(Numbers::<SCALES>::FIELD))?;
            numbers.add(link_name, number.0)?;
        }
        Ok(numbers)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut numbers = Numbers::default();
        while let Some((name, Finite(number))) = map.next_entry()? {
            numbers.add(name, number)?;
        }
        Ok(numbers)
    }
}
