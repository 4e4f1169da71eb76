//! Objects whose shape a sensor sees, anew in each of its frames.

use serde::{Deserialize, Serialize};

use super::SceneError;
use super::numbers::Finite;
use crate::hash::ContentHasher;

/// Farthest (m) that points on the robot are looked for: more hides what it should not touch.
const MOST_PADDING_M: f64 = 0.5;
/// Largest radius and cell (m).
const LARGEST_M: f64 = 1.0;

/// That the shape of an object comes from a sensor, and what is made of its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensing {
    /// What each point is the centre of: a ball of this radius (m).
    pub radius_m: f64,
    /// Edge (m) of the cells that keep one point each, in whose place a larger ball stands for all
    /// of them; 0 = every point stays.
    pub thin_m: f64,
    /// Points as near to the robot's own bodies as this (m) are left out.
    pub self_padding_m: f64,
    /// The frame that its shape comes from; `None` before there is any: nothing is known of what is
    /// there.
    pub frame: Option<SensedFrame>,
    /// How long after the one before it that was taken (ns); 0 of the first. No answer rests on it,
    /// and nobody keeps it.
    pub period_ns: u64,
}

/// A frame that was taken in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensedFrame {
    /// When the sensor saw it, in nanoseconds of `CLOCK_MONOTONIC`.
    pub taken_ns: u64,
    /// Points that it had.
    pub came: u32,
    /// Points that are no point: not finite, or where the sensor saw nothing.
    pub not_finite: u32,
    /// Points on the robot or on what it carries.
    pub on_robot: u32,
    /// Of these, points that no body of the robot holds but the padding: the world may be there.
    pub in_padding: u32,
    /// Points that cells were thinned by.
    pub thinned: u32,
    /// Points of the shape.
    pub points: u32,
}

impl SensedFrame {
    /// How long ago (ns) it was taken, at `now_ns` of `CLOCK_MONOTONIC`.
    pub fn age_ns(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.taken_ns)
    }
}

/// As texts have it; a frame is in none of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SensingFile {
    radius: Finite,
    #[serde(default, skip_serializing_if = "is_zero")]
    thin: Finite,
    #[serde(default, skip_serializing_if = "is_zero")]
    self_padding: Finite,
}

fn is_zero(number: &Finite) -> bool {
    number.0 == 0.0
}

impl Sensing {
    /// A sensor whose points are balls of this radius (m), and nothing else done to them.
    pub fn new(radius_m: f64) -> Self {
        Self {
            radius_m,
            thin_m: 0.0,
            self_padding_m: 0.0,
            frame: None,
            period_ns: 0,
        }
    }

    /// The same sensor before it has seen anything.
    #[must_use]
    pub fn blind(&self) -> Self {
        Self {
            frame: None,
            period_ns: 0,
            ..self.clone()
        }
    }

    /// Checks its lengths.
    pub(super) fn check(&self, id: &str) -> Result<(), SceneError> {
        let lengths = [
            ("radius", self.radius_m, f64::MIN_POSITIVE..=LARGEST_M),
            ("thin", self.thin_m, 0.0..=LARGEST_M),
            ("self_padding", self.self_padding_m, 0.0..=MOST_PADDING_M),
        ];
        let bad = lengths
            .into_iter()
            .find(|(_, value, valid)| !valid.contains(value));
        match bad {
            None => Ok(()),
            Some((what, value, valid)) => Err(SceneError::BadSensing {
                id: id.to_owned(),
                what,
                value,
                most: *valid.end(),
            }),
        }
    }

    pub(super) fn tell(&self, hasher: &mut ContentHasher) {
        hasher
            .name("sensed")
            .floats(&[self.radius_m, self.thin_m, self.self_padding_m]);
        if let Some(frame) = &self.frame {
            hasher.number(frame.taken_ns);
        }
    }
}

impl SensingFile {
    pub(super) fn of(sensing: &Sensing) -> Self {
        Self {
            radius: Finite(sensing.radius_m),
            thin: Finite(sensing.thin_m),
            self_padding: Finite(sensing.self_padding_m),
        }
    }

    pub(super) fn build(self) -> Sensing {
        Sensing {
            thin_m: self.thin.0,
            self_padding_m: self.self_padding.0,
            ..Sensing::new(self.radius.0)
        }
    }
}
