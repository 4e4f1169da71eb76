//! Constraints in few words, and as texts travel: the one reader of a request's constraints.

use serde::Deserialize;
use serde_json::json;

use super::{ConstraintError, ConstraintsFile};

const VALID: &str = "valid: MoveIt's Constraints in JSON, a list of such, \"upright LINK:AXIS=ANGLE\" with AXIS one of \
     x, y, z, -x, -y, -z and ANGLE in rad or such as 5deg, then @start or nothing, or \"keep LINK in REGION\" with \
     LINK or LINK@X,Y,Z and REGION one of box X,Y,Z; ball RADIUS; cylinder RADIUS,LENGTH; then at X,Y,Z (m), and of \
     FRAME or nothing";

/// One constraint text among others.
#[derive(Deserialize)]
#[serde(untagged)]
enum Part {
    Words(String),
    Message(serde_json::Value),
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
            Some('{') => serde_json::from_str(text).map_err(|error| no_message(&error)),
            Some('[') => all(text),
            Some(_) => of_words(text.trim()),
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

fn no_message(error: &serde_json::Error) -> ConstraintError {
    ConstraintError::Syntax(format!("not MoveIt's Constraints: {error}"))
}

fn all(text: &str) -> Result<ConstraintsFile, ConstraintError> {
    let parts: Vec<Part> = serde_json::from_str(text).map_err(|error| no_message(&error))?;
    let parts = parts.into_iter().map(part);
    parts
        .reduce(|all, next| Ok(all?.and(next?)))
        .unwrap_or_else(|| Ok(ConstraintsFile::default()))
}

fn part(part: Part) -> Result<ConstraintsFile, ConstraintError> {
    match part {
        Part::Words(words) => ConstraintsFile::parse(&words),
        Part::Message(value) => serde_json::from_value(value).map_err(|error| no_message(&error)),
    }
}

fn of_words(text: &str) -> Result<ConstraintsFile, ConstraintError> {
    let message = match text.split_once(char::is_whitespace) {
        Some(("upright", words)) => upright(words.trim()),
        Some(("keep", words)) => keep(words.trim()),
        _ => None,
    };
    let message = message
        .ok_or_else(|| ConstraintError::Syntax(format!("{text:?} is no constraint; {VALID}")))?;
    serde_json::from_value(message).map_err(|error| no_message(&error))
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
    let (link, offset) = match point.split_once('@') {
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
