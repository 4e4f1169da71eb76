//! What a path must keep everywhere, each with a floor: the clearance of every pair of bodies, and
//! what is left of the tolerance of every constraint.
//!
//! From the check to the answer everything speaks of requirements: floors, refusals, what is
//! nearest, what holds the path, rows, certificates. What a requirement is about matters only where
//! it is measured, where it is proved on an interval, where a row is made of it, and in its names.

use serde::{Deserialize, Serialize};

use crate::collision::CollisionModel;
use crate::constraint::{Constraint, ConstraintKind};
use crate::math::Vec3;
use crate::solid::{Contact, TOUCHING_M};

/// Something that every segment must keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Requirement {
    /// The clearance of a pair of bodies, by its index in the collision model.
    Clearance(usize),
    /// A constraint of the request, by its index.
    Constraint(usize),
}

impl Requirement {
    /// What people call it.
    pub fn named(self, model: &CollisionModel, constraints: &[Constraint]) -> NamedRequirement {
        match self {
            Self::Clearance(pair) => NamedRequirement::clearance(model.pair_names(pair)),
            Self::Constraint(index) => NamedRequirement::constraint(&constraints[index]),
        }
    }

    /// The pair whose clearance it is, where bodies are looked at.
    pub(crate) fn pair(self) -> usize {
        match self {
            Self::Clearance(pair) => pair,
            Self::Constraint(index) => {
                unreachable!("constraint {index} is no pair: no bodies are looked at for it")
            }
        }
    }
}

/// What kind of thing a requirement is, which says how its amounts are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RequirementKind {
    /// The distance of two bodies (m), at least the floor; negative is how deep they are in each
    /// other.
    Clearance,
    /// What is left of how far something may turn (rad); negative is how far it is outside.
    Orientation,
    /// What is left of where a point may be (m); negative is how far it is outside.
    Position,
    /// What is left of where a joint may be (rad or m); negative is how far it is outside.
    Joint,
}

impl RequirementKind {
    /// Every kind, in the order of the wire.
    pub const ALL: [Self; 4] = [
        Self::Clearance,
        Self::Orientation,
        Self::Position,
        Self::Joint,
    ];

    /// Name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clearance => "clearance",
            Self::Orientation => "orientation",
            Self::Position => "position",
            Self::Joint => "joint",
        }
    }
}

/// What the amounts of a requirement are counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Unit {
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Radians.
    #[serde(rename = "rad")]
    Radian,
}

impl Unit {
    /// Every unit, in the order of the wire.
    pub const ALL: [Self; 2] = [Self::Metre, Self::Radian];

    /// Symbol, its name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Radian => "rad",
        }
    }
}

/// A requirement as people know it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedRequirement {
    /// How its amounts are meant.
    pub kind: RequirementKind,
    /// What they are counted in.
    pub unit: Unit,
    /// What it is about: of a clearance the two bodies, of a constraint its name.
    pub names: Vec<String>,
}

impl NamedRequirement {
    /// The clearance of two bodies.
    pub fn clearance(bodies: [String; 2]) -> Self {
        Self {
            kind: RequirementKind::Clearance,
            unit: Unit::Metre,
            names: bodies.into(),
        }
    }

    /// What a constraint says must hold.
    pub fn constraint(constraint: &Constraint) -> Self {
        let (kind, unit) = match constraint.kind {
            ConstraintKind::Orientation => (RequirementKind::Orientation, Unit::Radian),
            ConstraintKind::Position => (RequirementKind::Position, Unit::Metre),
            ConstraintKind::Angle => (RequirementKind::Joint, Unit::Radian),
            ConstraintKind::Slide => (RequirementKind::Joint, Unit::Metre),
        };
        Self {
            kind,
            unit,
            names: vec![constraint.name.clone()],
        }
    }
}

impl std::fmt::Display for NamedRequirement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.names.join(" × "))
    }
}

/// A floor that the input of a request forced down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "WrittenFloor")]
pub struct LoweredFloor {
    /// Whose.
    #[serde(flatten)]
    pub requirement: NamedRequirement,
    /// What every path of the request keeps of it, in its unit.
    pub floor: f64,
}

/// A lowered floor as files have it.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "a lowered floor has kind, unit, names and floor; a kind that is not clearance needs a newer taut"
)]
enum WrittenFloor {
    Named {
        #[serde(flatten)]
        requirement: NamedRequirement,
        floor: f64,
    },
    /// Two bodies and their floor (m): until 2026-11 there was nothing else.
    Clearance(String, String, f64),
}

impl From<WrittenFloor> for LoweredFloor {
    fn from(written: WrittenFloor) -> Self {
        let (requirement, floor) = match written {
            WrittenFloor::Named { requirement, floor } => (requirement, floor),
            WrittenFloor::Clearance(a, b, floor) => (NamedRequirement::clearance([a, b]), floor),
        };
        Self { requirement, floor }
    }
}

/// How a requirement stands at one configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// How much of it is kept, in its unit.
    pub amount: f64,
    /// Where that is seen, in the world (m): of a clearance the closest or contact points of the two
    /// bodies.
    pub points: [Vec3; 2],
    /// Unit vector along which the first point must move for more to be kept: of a clearance from
    /// the second body towards the first.
    pub normal: Vec3,
}

impl Measure {
    /// Whether bodies touch or overlap.
    pub(super) fn touches(&self) -> bool {
        self.amount <= TOUCHING_M
    }
}

impl From<Contact> for Measure {
    fn from(contact: Contact) -> Self {
        Self {
            amount: contact.distance,
            points: [contact.point_a, contact.point_b],
            normal: contact.normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lowered_floor_is_read_in_both_forms_and_written_in_one() {
        let lowered = LoweredFloor {
            requirement: NamedRequirement::clearance(["hand", "door"].map(str::to_owned)),
            floor: 2.5e-4,
        };
        let text = r#"{"kind":"clearance","unit":"m","names":["hand","door"],"floor":0.00025}"#;
        assert_eq!(serde_json::to_string(&lowered).unwrap(), text);
        for text in [text, r#"["hand","door",0.00025]"#] {
            assert_eq!(serde_json::from_str::<LoweredFloor>(text).unwrap(), lowered);
        }
        let newer = r#"{"kind":"colour","unit":"nm","names":["hand"],"floor":580}"#;
        let error = serde_json::from_str::<LoweredFloor>(newer).unwrap_err();
        assert!(error.to_string().contains("a newer taut"), "{error}");
    }

    #[test]
    fn files_call_kinds_and_units_by_their_names() {
        for kind in RequirementKind::ALL {
            assert_eq!(serde_json::to_value(kind).unwrap(), kind.name());
        }
        for unit in Unit::ALL {
            assert_eq!(serde_json::to_value(unit).unwrap(), unit.name());
        }
    }
}
