//! Why a planner's call failed.

use crate::client_error::ClientError;
use crate::control::{ControlReply, Refusal};
use crate::instance::InstanceError;
use crate::wire::{
    Code, RefusalReason, RefusalRecord, RequirementKind, ResponseView, Unit, WireError,
};

/// Why a planner's call failed.
#[derive(Debug, thiserror::Error)]
pub enum PlannerError {
    /// The connection.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// A name, number or size of the request that is none; nothing was sent.
    #[error("{message}")]
    Invalid {
        /// What kind of mistake.
        code: Code,
        /// The bad value, the valid ones, the next step.
        message: String,
    },
    /// The daemon's answer is no.
    #[error("{0}")]
    Refused(Box<Refused>),
}

/// A daemon's no.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// Why.
    pub code: Code,
    /// In one line.
    pub message: String,
    /// When to try again, in milliseconds; 0 = never.
    pub retry_after_ms: u32,
    /// Where on the path, if that is what is wrong with it.
    pub place: Option<Place>,
}

/// Where a path does not keep what it must, or is not proved to.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Why.
    pub reason: RefusalReason,
    /// What kind of thing is not kept.
    pub kind: RequirementKind,
    /// What it is about: of a clearance the two bodies.
    pub names: Vec<String>,
    /// Segment of the path, from 0.
    pub segment: u32,
    /// Ratio on the segment, 0 to 1.
    pub t: f64,
    /// How much is kept there: of a clearance the distance, below 0 the penetration depth, which is
    /// from below unless both bodies are convex.
    pub amount: f64,
    /// The floor: how much must be kept.
    pub allowed: f64,
    /// What both are counted in.
    pub unit: Unit,
    /// Where that is seen, world frame, in metres: of a clearance contact or closest points.
    pub points: [[f64; 3]; 2],
    /// Unit vector along which the first point moves for more to be kept: of a clearance from the
    /// second body to the first.
    pub normal: [f64; 3],
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(place) = &self.place else {
            let message = self.message.lines().next().unwrap_or_default();
            return if message.is_empty() {
                f.write_str(self.code.name())
            } else {
                f.write_str(message)
            };
        };
        let Place {
            names,
            segment,
            t,
            amount,
            ..
        } = place;
        write!(
            f,
            "{}: {} at segment {segment} (from 0), t = {t:.3}, ",
            self.code.name(),
            names.join(" × ")
        )?;
        match place.kind {
            RequirementKind::Clearance if *amount < 0.0 => write!(f, "depth ≥ {:.3e} m", -amount)?,
            RequirementKind::Clearance => write!(f, "distance {amount:.3e} m")?,
            RequirementKind::Orientation | RequirementKind::Position | RequirementKind::Joint => {
                write!(f, "{}", of_tolerance(*amount, place.unit))?;
            }
        }
        if self.message.is_empty() {
            Ok(())
        } else {
            write!(f, "; {}", self.message.replace('\n', "; "))
        }
    }
}

/// What is left of a tolerance, or by how much something is outside of it.
fn of_tolerance(left: f64, unit: Unit) -> String {
    let unit = unit.name();
    match left < 0.0 {
        true => format!("outside by {:.3e} {unit}", -left),
        false => format!("{left:.3e} {unit} left"),
    }
}

impl Place {
    fn of(record: &RefusalRecord, view: &ResponseView<'_>) -> Result<Self, WireError> {
        let reason = RefusalReason::try_from(view.header.refusal_reason)?;
        Ok(Self {
            reason,
            kind: RequirementKind::try_from(record.requirement.kind)?,
            names: record.requirement.names(view.names)?,
            segment: record.segment,
            t: record.t,
            amount: record.amount,
            allowed: record.allowed,
            unit: Unit::try_from(record.requirement.unit)?,
            points: record.points,
            normal: record.normal,
        })
    }
}

impl Refused {
    /// What a final response that is no success says.
    ///
    /// # Errors
    /// [`WireError`] only if the daemon changed it after sending.
    pub(super) fn of_view(view: &ResponseView<'_>) -> Result<Self, WireError> {
        Ok(Self {
            code: view.code,
            message: view.message.to_owned(),
            retry_after_ms: view.header.retry_after_ms,
            place: view
                .refusal
                .map(|record| Place::of(record, view))
                .transpose()?,
        })
    }
}

impl PlannerError {
    /// The code for other languages.
    pub fn code(&self) -> Code {
        match self {
            Self::Client(error) => error.code(),
            Self::Invalid { code, .. } => *code,
            Self::Refused(refused) => refused.code,
        }
    }

    /// When the same call may succeed, in milliseconds; 0 = never.
    pub fn retry_after_ms(&self) -> u32 {
        match self {
            Self::Refused(refused) => refused.retry_after_ms,
            Self::Client(ClientError::Overloaded | ClientError::DaemonLost { .. }) => 100,
            _ => 0,
        }
    }

    /// Where on the path, if that is what is wrong.
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Refused(refused) => refused.place.as_ref(),
            _ => None,
        }
    }

    pub(super) fn of_refusal(refusal: Refusal) -> Self {
        let code = Code::try_from(refusal.code).unwrap_or(Code::MalformedRequest);
        let Refusal {
            message,
            retry_after_ms,
            ..
        } = refusal;
        Self::Refused(Box::new(Refused {
            code,
            message,
            retry_after_ms,
            place: None,
        }))
    }

    /// A reply of another kind than the message asks for.
    pub(super) fn unexpected(reply: &ControlReply) -> Self {
        let message =
            format!("the daemon answers {reply:?}; use client and daemon of the same release");
        Self::Invalid {
            code: Code::MalformedRequest,
            message,
        }
    }

    /// A name that is none of the valid ones.
    pub(super) fn unknown<'a>(
        kind: &str,
        name: &str,
        valid: impl IntoIterator<Item = &'a str>,
        code: Code,
    ) -> Self {
        let valid: Vec<&str> = valid.into_iter().collect();
        let valid = if valid.is_empty() {
            "none".to_owned()
        } else {
            valid.join(", ")
        };
        Self::Invalid {
            code,
            message: format!("{name:?} is no {kind}; valid: {valid}"),
        }
    }

    pub(super) fn invalid(code: Code, message: impl Into<String>) -> Self {
        Self::Invalid {
            code,
            message: message.into(),
        }
    }
}

impl From<InstanceError> for PlannerError {
    fn from(error: InstanceError) -> Self {
        Self::Client(error.into())
    }
}

impl From<WireError> for PlannerError {
    fn from(error: WireError) -> Self {
        Self::Client(error.into())
    }
}
