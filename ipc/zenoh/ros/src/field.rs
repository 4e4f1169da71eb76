//! What a field of a message may be, as serde sees it and as a type description names it.

use serde::de::{Deserialize, Deserializer, Error};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// Added to an element's number where a field holds so many of it.
const ARRAY: u8 = 48;
/// ... at most so many.
const BOUNDED_SEQUENCE: u8 = 96;
/// ... any number.
const SEQUENCE: u8 = 144;
/// The number of what is a message itself.
const NESTED: u8 = 1;

/// A field's type, in the numbers of `type_description_interfaces/msg/FieldType`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldType {
    /// Which type, and whether one of it, an array or a sequence.
    pub id: u8,
    /// Elements of an array, or the most of a bounded sequence; 0 otherwise.
    pub capacity: usize,
    /// The message that it is, such as `geometry_msgs/msg/Pose`; empty otherwise.
    pub nested: &'static str,
}

impl FieldType {
    /// One message.
    #[must_use]
    pub fn message(name: &'static str) -> Self {
        Self {
            id: NESTED,
            capacity: 0,
            nested: name,
        }
    }

    fn plain(id: u8) -> Self {
        Self {
            id,
            capacity: 0,
            nested: "",
        }
    }

    fn many(element: Self, kind: u8, capacity: usize) -> Self {
        Self {
            id: element.id + kind,
            capacity,
            ..element
        }
    }

    /// As a line of a `.msg` file begins.
    #[must_use]
    pub fn words(&self) -> String {
        let (kind, element) = match self.id {
            SEQUENCE.. => (SEQUENCE, self.id - SEQUENCE),
            BOUNDED_SEQUENCE.. => (BOUNDED_SEQUENCE, self.id - BOUNDED_SEQUENCE),
            ARRAY.. => (ARRAY, self.id - ARRAY),
            element => (0, element),
        };
        let name = PLAIN
            .iter()
            .find(|(id, _)| *id == element)
            .map_or_else(
                || self.nested.replace("/msg/", "/"),
                |(_, name)| (*name).to_owned(),
            );
        match kind {
            SEQUENCE => format!("{name}[]"),
            BOUNDED_SEQUENCE => format!("{name}[<={}]", self.capacity),
            ARRAY => format!("{name}[{}]", self.capacity),
            _ => name,
        }
    }
}

/// Fields of each message that is met, by the message's name.
pub type Types = BTreeMap<&'static str, Vec<(&'static str, FieldType)>>;

/// What may stand in a field.
pub trait Field {
    /// Its type; adds to `types` the messages that it is made of.
    fn describe(types: &mut Types) -> FieldType;
}

macro_rules! plain {
    ($($type:ty = $id:literal $name:literal,)*) => {
        const PLAIN: &[(u8, &str)] = &[$(($id, $name)),*];
        $(impl Field for $type {
            fn describe(_: &mut Types) -> FieldType {
                FieldType::plain($id)
            }
        })*
    };
}

plain! {
    i8 = 2 "int8",
    u8 = 3 "uint8",
    i16 = 4 "int16",
    u16 = 5 "uint16",
    i32 = 6 "int32",
    u32 = 7 "uint32",
    i64 = 8 "int64",
    u64 = 9 "uint64",
    f32 = 10 "float32",
    f64 = 11 "float64",
    bool = 15 "bool",
    Byte = 16 "byte",
    String = 17 "string",
}

/// A `byte`, which is no `uint8` in type descriptions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Byte(pub u8);

impl<T: Field> Field for Vec<T> {
    fn describe(types: &mut Types) -> FieldType {
        FieldType::many(T::describe(types), SEQUENCE, 0)
    }
}

impl<T: Field, const N: usize> Field for [T; N] {
    fn describe(types: &mut Types) -> FieldType {
        FieldType::many(T::describe(types), ARRAY, N)
    }
}

/// A sequence of at most `N`; a longer one is neither written nor read.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounded<T, const N: usize>(pub Vec<T>);

impl<T, const N: usize> Default for Bounded<T, N> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Field, const N: usize> Field for Bounded<T, N> {
    fn describe(types: &mut Types) -> FieldType {
        FieldType::many(T::describe(types), BOUNDED_SEQUENCE, N)
    }
}

impl<T: Serialize, const N: usize> Serialize for Bounded<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.len() <= N {
            true => self.0.serialize(serializer),
            false => Err(serde::ser::Error::custom(too_many::<N>(self.0.len()))),
        }
    }
}

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Bounded<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let all = Vec::deserialize(deserializer)?;
        match all.len() <= N {
            true => Ok(Self(all)),
            false => Err(D::Error::custom(too_many::<N>(all.len()))),
        }
    }
}

fn too_many<const N: usize>(len: usize) -> String {
    format!("{len} elements; at most {N}")
}
