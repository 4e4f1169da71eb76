//! Random messages, of whatever serde can read.

use fastrand::Rng;
use serde::de::value::Error;
use serde::de::{DeserializeSeed, Deserializer, Error as _, SeqAccess, Visitor};

/// Elements of a sequence at most; those that are bounded hold as many.
const MOST: usize = 3;

/// Gives numbers, texts and sequences as they are asked for.
pub struct Random<'a>(pub &'a mut Rng);

macro_rules! number {
    ($($method:ident $visit:ident $random:expr;)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            let random: fn(&mut Rng) -> _ = $random;
            visitor.$visit(random(self.0))
        }
    )*};
}

impl<'de> Deserializer<'de> for Random<'_> {
    type Error = Error;

    number! {
        deserialize_bool visit_bool |rng| rng.bool();
        deserialize_i8 visit_i8 |rng| rng.i8(..);
        deserialize_i16 visit_i16 |rng| rng.i16(..);
        deserialize_i32 visit_i32 |rng| rng.i32(..);
        deserialize_i64 visit_i64 |rng| rng.i64(..);
        deserialize_u8 visit_u8 |rng| rng.u8(..);
        deserialize_u16 visit_u16 |rng| rng.u16(..);
        deserialize_u32 visit_u32 |rng| rng.u32(..);
        deserialize_u64 visit_u64 |rng| rng.u64(..);
        deserialize_f32 visit_f32 |rng| rng.f32() * 200.0 - 100.0;
        deserialize_f64 visit_f64 |rng| rng.f64() * 200.0 - 100.0;
        deserialize_string visit_string |rng| (0..rng.usize(0..9)).map(|_| rng.alphanumeric()).collect();
        deserialize_str visit_string |rng| (0..rng.usize(0..9)).map(|_| rng.alphanumeric()).collect();
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let len = self.0.usize(0..=MOST);
        visitor.visit_seq(Elements {
            rng: self.0,
            left: len,
        })
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(Elements {
            rng: self.0,
            left: len,
        })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(fields.len(), visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::custom("no field of a message"))
    }

    serde::forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf option unit unit_struct tuple_struct map enum identifier ignored_any
    }
}

struct Elements<'a> {
    rng: &'a mut Rng,
    left: usize,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, Error> {
        let Some(left) = self.left.checked_sub(1) else {
            return Ok(None);
        };
        self.left = left;
        seed.deserialize(Random(self.rng)).map(Some)
    }
}
