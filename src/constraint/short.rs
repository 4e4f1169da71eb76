//! Constraints in few words, and as texts travel: the one reader of a request's constraints.

use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::json;

use super::{ConstraintError, ConstraintsFile};

const VALID: &str = "valid: MoveIt's Constraints in JSON, a list of such, \"upright LINK:AXIS=ANGLE\" with AXIS one of \
     x, y, z, -x, -y, -z and ANGLE in rad or such as 5deg, then @start or nothing, or \"keep LINK in REGION\" with \
     LINK or LINK@X,Y,Z and REGION one of box X,Y,Z; ball RADIUS; cylinder RADIUS,LENGTH; then at X,Y,Z (m), and of \
     FRAME or nothing";

/// MoveIt's message, few words, or a list of these, wherever constraints are written.
impl<'de> Deserialize<'de> for ConstraintsFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Text)
    }
}

impl Serialize for ConstraintsFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // What is derived, as a message.
        Self::serialize(self, serializer)
    }
}

struct Text;

impl<'de> Visitor<'de> for Text {
    type Value = ConstraintsFile;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("MoveIt's Constraints, few words, or a list of these")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ConstraintsFile, A::Error> {
        // What is derived, of a message.
        ConstraintsFile::deserialize(MapAccessDeserializer::new(map))
    }

    fn visit_str<E: Error>(self, words: &str) -> Result<ConstraintsFile, E> {
        of_words(words.trim()).map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<ConstraintsFile, A::Error> {
        let mut all = ConstraintsFile::default();
        while let Some(next) = list.next_element()? {
            all = all.and(next);
        }
        Ok(all)
    }

    fn visit_unit<E: Error>(self) -> Result<ConstraintsFile, E> {
        Ok(ConstraintsFile::default())
    }
}

impl ConstraintsFile {
    /// Reads MoveIt's `Constraints` in JSON, a list of such, or few words: `upright hand:x=0.1` (the
    /// link's x axis within 0.1 rad of +z of the world; `-z`: the opposite axis; `@start` behind it:
    /// of where it points at the first waypoint), `keep hand@0,0,0.1 in box 0.4,0.4,0.1 at
    /// 0.5,0,0.3` (a point of the link, a region with its whole extents or radius and length, and
    /// its centre). Of several, all must hold.
    ///
    /// # Errors
    /// A text that is none of these.
    pub fn parse(text: &str) -> Result<Self, ConstraintError> {
        match text.trim_start().chars().next() {
            None => Ok(Self::default()),
            Some('{' | '[') => serde_json::from_str(text).map_err(not_read),
            Some(_) => of_words(text.trim()).map_err(ConstraintError::Syntax),
        }
    }

    /// The text that [`Self::parse`] reads it from; empty where it asks for nothing.
    pub fn text(&self) -> String {
        if self.is_empty() {
            return String::new();
        }
        serde_json::to_string(self).expect("constraints hold only strings and finite numbers")
    }
}

fn not_read(error: serde_json::Error) -> ConstraintError {
    ConstraintError::Syntax(format!("not MoveIt's Constraints: {error}"))
}

fn of_words(text: &str) -> Result<ConstraintsFile, String> {
    let message = match text.split_once(char::is_whitespace) {
        Some(("upright", words)) => upright(words.trim()),
        Some(("keep", words)) => keep(words.trim()),
        _ => None,
    };
    let message = message.ok_or_else(|| format!("{text:?} is no constraint; {VALID}"))?;
    serde_json::from_value(message).map_err(|error| error.to_string())
}

/// `hand:x=0.1`, `hand:-z=5deg@start`.
fn upright(words: &str) -> Option<serde_json::Value> {
    let (words, reference) = match words.strip_suffix("@start") {
        Some(words) => (words, json!("start")),
        None => (words, json!([0, 0, 1])),
    };
    let (place, angle) = words.rsplit_once('=')?;
    let (link, axis) = place.rsplit_once(':')?;
    let tilt = json!({
        "link_name": named(link)?,
        "axis": direction(axis)?,
        "reference": reference,
        "tolerance_rad": radians(angle)?,
    });
    Some(json!({ "name": "upright", "orientation_constraints": [tilt] }))
}

fn named(name: &str) -> Option<&str> {
    Some(name.trim()).filter(|name| !name.is_empty())
}

fn direction(axis: &str) -> Option<[f64; 3]> {
    let (sign, axis) = match axis.strip_prefix('-') {
        Some(axis) => (-1.0, axis),
        None => (1.0, axis.strip_prefix('+').unwrap_or(axis)),
    };
    let place = ["x", "y", "z"]
        .iter()
        .position(|known| *known == axis)?;
    let mut direction = [0.0; 3];
    direction[place] = sign;
    Some(direction)
}

/// `0.1`, `0.1rad` or `5deg`.
fn radians(angle: &str) -> Option<f64> {
    match angle.strip_suffix("deg") {
        Some(degrees) => finite(degrees).map(f64::to_radians),
        None => finite(angle.strip_suffix("rad").unwrap_or(angle)),
    }
}

fn finite(number: &str) -> Option<f64> {
    let number: f64 = number.trim().parse().ok()?;
    number.is_finite().then_some(number)
}

fn numbers<const N: usize>(words: &str) -> Option<[f64; N]> {
    let numbers = words.split(',').map(finite);
    numbers
        .collect::<Option<Vec<f64>>>()?
        .try_into()
        .ok()
}

/// `hand@0,0,0.1 in box 0.4,0.4,0.1 at 0.5,0,0.3 of table`.
fn keep(words: &str) -> Option<serde_json::Value> {
    let (point, region) = words.split_once(" in ")?;
    let (link, offset) = match point.rsplit_once('@') {
        Some((link, offset)) => (link, numbers(offset)?),
        None => (point, [0.0; 3]),
    };
    let (shape, place) = region.split_once(" at ")?;
    let (center, frame) = match place.split_once(" of ") {
        Some((center, frame)) => (center, named(frame)?),
        None => (place, ""),
    };
    let position = json!({
        "header": { "frame_id": frame },
        "link_name": named(link)?,
        "target_point_offset": offset,
        "constraint_region": {
            "primitives": [primitive(shape.trim())?],
            "primitive_poses": [{ "position": numbers::<3>(center)? }],
        },
    });
    Some(json!({ "position_constraints": [position] }))
}

/// MoveIt's primitive, whose cylinders have the length first.
fn primitive(words: &str) -> Option<serde_json::Value> {
    let (kind, sizes) = words.split_once(char::is_whitespace)?;
    match kind {
        "box" => Some(json!({ "type": "box", "dimensions": numbers::<3>(sizes)? })),
        "ball" => Some(json!({ "type": "sphere", "dimensions": numbers::<1>(sizes)? })),
        "cylinder" => {
            let [radius, length] = numbers(sizes)?;
            Some(json!({ "type": "cylinder", "dimensions": [length, radius] }))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> serde_json::Value {
        let file = ConstraintsFile::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        serde_json::to_value(file).unwrap()
    }

    #[test]
    fn few_words_are_the_messages_that_they_stand_for() {
        let tilt = |axis: [f64; 3], reference: serde_json::Value, tolerance: f64| {
            json!({ "name": "upright", "orientation_constraints": [{ "link_name": "hand", "axis": axis,
                "reference": reference, "tolerance_rad": tolerance }] })
        };
        let up = || json!([0.0, 0.0, 1.0]);
        assert_eq!(read("upright hand:x=0.1"), tilt([1.0, 0.0, 0.0], up(), 0.1));
        let degrees = tilt([0.0, 0.0, -1.0], json!("start"), 5f64.to_radians());
        assert_eq!(read("upright hand:-z=5deg@start"), degrees);
        let kept = |offset: [f64; 3], primitive: serde_json::Value| {
            json!({ "name": "", "position_constraints": [{ "link_name": "hand", "target_point_offset": offset,
                "constraint_region": { "primitives": [primitive],
                    "primitive_poses": [{ "position": [0.5, 0.0, 0.3] }] } }] })
        };
        let cylinder = json!({ "type": "cylinder", "dimensions": [2.0, 0.1] });
        let read_cylinder = read("keep hand@0,0,0.1 in cylinder 0.1,2 at 0.5,0,0.3");
        assert_eq!(
            without_defaults(read_cylinder),
            kept([0.0, 0.0, 0.1], cylinder)
        );
        let ball = read("keep hand in ball 0.2 at 0.5,0,0.3 of cup");
        assert_eq!(ball["position_constraints"][0]["header"]["frame_id"], "cup");
    }

    /// The same without what poses leave out as they like.
    fn without_defaults(mut value: serde_json::Value) -> serde_json::Value {
        let pose = &mut value["position_constraints"][0]["constraint_region"]["primitive_poses"][0];
        *pose = json!({ "position": pose["position"] });
        value
    }

    #[test]
    fn several_texts_are_one_that_comes_back_from_its_own() {
        let list = r#"["upright hand:x=0.1", {"joint_constraints": [{"joint_name": "a", "position": 0.1,
            "tolerance_above": 0.30000000000000004, "tolerance_below": 1}]}]"#;
        let all = ConstraintsFile::parse(list).unwrap();
        assert_eq!(ConstraintsFile::parse(&all.text()).unwrap(), all);
        assert_eq!(
            read(list)["name"],
            "",
            "a name that one of them has is not the other's"
        );
        let once = all.clone().and(all.clone());
        assert_eq!(once, all);
        assert_eq!(ConstraintsFile::parse(" ").unwrap().text(), "");
    }

    #[test]
    fn a_list_is_no_message_whose_first_field_is_a_name() {
        let expected = ConstraintsFile::parse("upright hand:x=0.1").unwrap();
        for text in [
            r#""upright hand:x=0.1""#,
            r#"["upright hand:x=0.1"]"#,
            r#"[["upright hand:x=0.1"], null, {}]"#,
        ] {
            let value: serde_json::Value = serde_json::from_str(text).unwrap();
            let read: ConstraintsFile = serde_json::from_value(value).unwrap();
            assert_eq!(read, expected, "{text}");
            assert_eq!(
                serde_json::from_str::<ConstraintsFile>(text).unwrap(),
                expected
            );
        }
        let twice = r#"{"joint_constraints": [], "joint_constraints": []}"#;
        let error = ConstraintsFile::parse(twice).unwrap_err();
        assert!(error.to_string().contains("duplicate field"), "{error}");
    }

    #[test]
    fn a_name_is_one_line() {
        let error = ConstraintsFile::parse("{\"name\": \"a\\nb\"}").unwrap_err();
        let error = error.to_string();
        assert!(
            error.contains("\"a\\nb\"") && !error.contains('\n'),
            "{error}"
        );
    }

    #[test]
    fn other_words_are_refused_with_the_valid_ones() {
        for text in [
            "hand:x=0.1",
            "upright hand",
            "upright hand:x",
            "upright :x=0.1",
            "upright hand:w=0.1",
            "upright hand:x=far",
            "upright hand:x=inf",
            "upright hand:x=0.1@end",
            "keep hand",
            "keep hand in box 1,2 at 0,0,0",
            "keep hand in ball 1",
            "keep hand in cone 1,1 at 0,0,0",
            "keep hand@1,2 in ball 1 at 0,0,0",
            "keep hand in ball 1 at 0,0",
        ] {
            let error = ConstraintsFile::parse(text)
                .unwrap_err()
                .to_string();
            assert!(
                error.contains(text) && error.contains("valid: ") && !error.contains('\n'),
                "{error}"
            );
        }
        for text in ["{", "[1]", r#"{"weight": 1}"#, r#"["upright"]"#] {
            let error = ConstraintsFile::parse(text)
                .unwrap_err()
                .to_string();
            assert!(error.starts_with("constraints: "), "{error}");
        }
    }
}
