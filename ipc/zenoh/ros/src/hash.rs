//! RIHS01, the hash of a type: SHA-256 of its description as JSON, with `", "` and `": "`, defaults left out
//! (ROS 2's REP 2016).

use crate::field::{FieldType, Types};
use crate::message::{Message, Service, of_message, of_service};
use serde::Serialize;
use serde_json::ser::Formatter;
use sha2::{Digest as _, Sha256};
use std::io::{Result, Write};

#[derive(Serialize)]
struct Described<'a> {
    type_description: Description<'a>,
    referenced_type_descriptions: Vec<Description<'a>>,
}

#[derive(Serialize)]
struct Description<'a> {
    type_name: &'a str,
    fields: Vec<Named<'a>>,
}

#[derive(Serialize)]
struct Named<'a> {
    name: &'a str,
    r#type: Typed<'a>,
}

#[derive(Serialize)]
struct Typed<'a> {
    type_id: u8,
    capacity: usize,
    string_capacity: usize,
    nested_type_name: &'a str,
}

impl<'a> Description<'a> {
    fn new(type_name: &'a str, fields: &'a [(&'a str, FieldType)]) -> Self {
        let fields = fields.iter().map(|(name, kind)| Named {
            name,
            r#type: Typed {
                type_id: kind.id,
                capacity: kind.capacity,
                string_capacity: 0,
                nested_type_name: kind.nested,
            },
        });
        Self {
            type_name,
            fields: fields.collect(),
        }
    }
}

/// The hash of a message's type, `RIHS01_` and 64 digits.
#[must_use]
pub fn message_hash<M: Message>() -> String {
    hash(&of_message::<M>())
}

/// The hash of a service's type.
#[must_use]
pub fn service_hash<S: Service>() -> String {
    hash(&of_service::<S>())
}

fn hash((name, types): &(&'static str, Types)) -> String {
    let others = types.iter().filter(|(other, _)| *other != name);
    let described = Described {
        type_description: Description::new(name, &types[name]),
        referenced_type_descriptions: others
            .map(|(other, fields)| Description::new(other, fields))
            .collect(),
    };
    let mut json = Vec::new();
    let mut serializer = serde_json::Serializer::with_formatter(&mut json, Spaced);
    described
        .serialize(&mut serializer)
        .expect("strings and numbers, into memory");
    let digits = Sha256::digest(&json);
    let digits = digits.iter().map(|byte| format!("{byte:02x}"));
    format!("RIHS01_{}", digits.collect::<String>())
}

/// A space behind each comma and colon.
struct Spaced;

impl Spaced {
    fn separate<W: Write + ?Sized>(writer: &mut W, first: bool) -> Result<()> {
        match first {
            true => Ok(()),
            false => writer.write_all(b", "),
        }
    }
}

impl Formatter for Spaced {
    fn begin_array_value<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> Result<()> {
        Self::separate(writer, first)
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> Result<()> {
        Self::separate(writer, first)
    }

    fn begin_object_value<W: Write + ?Sized>(&mut self, writer: &mut W) -> Result<()> {
        writer.write_all(b": ")
    }
}
