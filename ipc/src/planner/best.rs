//! One answer.

use super::carrier::Answered;
use super::{Columns, Kept, PlannerError, Refused, Trajectory};
#[cfg(feature = "iceoryx2")]
use crate::client::Response;
use crate::limits::{CORRIDOR_ROUNDING_M, WIDEST_CORRIDOR_M};
use crate::wire::section::numbers;
use crate::wire::{
    CertificateSegment, Code, ResponseHeader, ResponseView, Status, Times, WarningKind,
    WarningRecord, WireError,
};
use std::borrow::Cow;
use std::sync::Arc;

/// A line that a person should know beside a verdict.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Whether it says what the verdict does not cover, or rests on.
    pub is_uncovered: bool,
    /// The line.
    pub text: String,
}

/// How far what is executed may stray from a proved path: for every configuration p of a segment
/// and every q with Σ reach |q − p| ≤ slack, every pair keeps the floor at q.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    /// Distance that every pair keeps within the corridor, in metres.
    pub floor_m: f64,
    /// How far bodies move at most against each other, per unit of each velocity coordinate of the
    /// robot (m per rad or m).
    pub reach: Vec<f64>,
    /// The slack of each segment, in metres.
    pub slack_m: Vec<f64>,
}

impl Corridor {
    /// That of a response; `None` where it was not asked for or nothing is proved.
    pub fn of_view(view: &ResponseView<'_>) -> Option<Self> {
        let floor_m = view.header.floor_m;
        let slack = |segment: &CertificateSegment| {
            (segment.clearance_m - (floor_m + CORRIDOR_ROUNDING_M)).clamp(0.0, WIDEST_CORRIDOR_M)
        };
        (!view.reach.is_empty()).then(|| Self {
            floor_m,
            reach: view.reach.to_vec(),
            slack_m: view.certificate.iter().map(slack).collect(),
        })
    }
}

/// An answer to a request: an improvement, or the final one.
///
/// It lies in shared memory, which goes back when it is dropped, or in memory of its own.
#[derive(Debug)]
pub struct Best {
    memory: Memory,
    columns: Arc<Columns>,
}

#[derive(Debug)]
enum Memory {
    #[cfg(feature = "iceoryx2")]
    Shared(Response),
    /// Words, so that the sections are aligned.
    Own(ResponseHeader, Vec<u64>),
}

impl Memory {
    fn is_shared(&self) -> bool {
        !matches!(self, Self::Own(..))
    }

    fn header(&self) -> &ResponseHeader {
        match self {
            #[cfg(feature = "iceoryx2")]
            Self::Shared(response) => response.header(),
            Self::Own(header, _) => header,
        }
    }

    fn payload(&self) -> &[u8] {
        match self {
            #[cfg(feature = "iceoryx2")]
            Self::Shared(response) => response.payload(),
            Self::Own(_, words) => bytemuck::cast_slice(words),
        }
    }
}

impl Best {
    #[cfg(feature = "iceoryx2")]
    pub(super) fn new(response: Response, columns: Arc<Columns>) -> Self {
        Self {
            memory: Memory::Shared(response),
            columns,
        }
    }

    /// An answer in memory of its own.
    pub(super) fn own(answered: Answered, columns: Arc<Columns>) -> Self {
        let Answered { header, words } = answered;
        Self {
            memory: Memory::Own(header, words),
            columns,
        }
    }

    /// The same answer in memory of its own; the shared memory goes back.
    pub fn into_own(self) -> Self {
        if !self.is_shared() {
            return self;
        }
        let payload = self.memory.payload();
        let mut words = vec![0_u64; payload.len().div_ceil(8)];
        bytemuck::cast_slice_mut(&mut words)[..payload.len()].copy_from_slice(payload);
        Self {
            memory: Memory::Own(*self.header(), words),
            columns: self.columns,
        }
    }

    /// Whether it lies in shared memory.
    pub fn is_shared(&self) -> bool {
        self.memory.is_shared()
    }

    /// The header.
    pub fn header(&self) -> &ResponseHeader {
        self.memory.header()
    }

    /// How it went.
    pub fn code(&self) -> Code {
        // Checked when it came.
        Code::try_from(self.header().code).unwrap_or(Code::MalformedRequest)
    }

    /// Whether it is the last answer to its request.
    pub fn is_final(&self) -> bool {
        self.header().status == u32::from(Status::Final)
    }

    /// The path, row by row, all of the robot's variables in its order; empty if there is none.
    pub fn path(&self) -> &[f64] {
        let path = self.header().path;
        numbers(self.memory.payload(), "path", path, usize::MAX).unwrap_or_default()
    }

    /// All sections.
    ///
    /// # Errors
    /// [`WireError`] only if the daemon changed them after sending.
    pub fn view(&self) -> Result<ResponseView<'_>, WireError> {
        ResponseView::parse(*self.header(), self.memory.payload())
    }

    /// The line for people, empty if there is none.
    pub fn message(&self) -> &str {
        self.view().map_or("", |view| view.message)
    }

    /// The corridor of a final answer; `None` where it was not asked for or nothing is proved.
    ///
    /// # Errors
    /// [`WireError`] only if the daemon changed it after sending.
    pub fn corridor(&self) -> Result<Option<Corridor>, WireError> {
        Ok(Corridor::of_view(&self.view()?))
    }

    /// What a final answer that is proved keeps of each constraint.
    ///
    /// # Errors
    /// [`WireError`] only if the daemon changed it after sending.
    pub fn keeps(&self) -> Result<Vec<Kept>, WireError> {
        Kept::of_view(&self.view()?)
    }

    /// Whether it has a trajectory, and why not.
    pub fn times(&self) -> Times {
        // Checked when it came.
        Times::try_from(self.header().times).unwrap_or(Times::NotAsked)
    }

    /// The trajectory, in the caller's columns; `None` where there is none, [`Self::times`] says why.
    ///
    /// # Errors
    /// [`WireError`] only if the daemon changed it after sending.
    pub fn trajectory(&self) -> Result<Option<Trajectory>, WireError> {
        Trajectory::of_view(&self.view()?, &self.columns)
    }

    /// The trajectory, in the caller's columns.
    ///
    /// # Errors
    /// [`PlannerError::Refused`] with [`Code::Untimed`] where there is none, and why.
    pub fn timed(&self) -> Result<Trajectory, PlannerError> {
        let untimed = || {
            PlannerError::Refused(Box::new(Refused {
                code: Code::Untimed,
                message: self.why_untimed(),
                retry_after_ms: 0,
                place: None,
            }))
        };
        self.trajectory()?.ok_or_else(untimed)
    }

    fn why_untimed(&self) -> String {
        match self.times() {
            Times::NotAsked => {
                "the request asked for no times: give it timing, such as acceleration=2/s"
                    .to_owned()
            }
            Times::NotReached if !self.is_final() => {
                "there are no times yet: they come after the path".to_owned()
            }
            Times::NoPath => "the path is not proved, and gets no times".to_owned(),
            Times::Timed | Times::NotReached | Times::Refused => self.message().to_owned(),
        }
    }

    /// What a person should know beside the verdict, first what it does not cover: of robot, scene
    /// and request, and of the joints that nobody said where they stand.
    ///
    /// # Errors
    /// [`WireError`] only if the daemon changed it after sending.
    pub fn warnings(&self) -> Result<Vec<Warning>, WireError> {
        let view = self.view()?;
        let told = |record: &WarningRecord| -> Result<Warning, WireError> {
            let is_uncovered = WarningKind::try_from(record.kind)? == WarningKind::Uncovered;
            Ok(Warning {
                is_uncovered,
                text: record.text.of(view.names)?.to_owned(),
            })
        };
        let mut warnings: Vec<Warning> = view
            .warnings
            .iter()
            .map(told)
            .collect::<Result<_, _>>()?;
        let note = self.columns.note().filter(|_| self.is_final());
        let uncovered = warnings
            .iter()
            .filter(|warning| warning.is_uncovered)
            .count();
        warnings.splice(
            uncovered..uncovered,
            note.map(|text| Warning {
                is_uncovered: true,
                text,
            }),
        );
        Ok(warnings)
    }

    /// Rows of the path; 0 where there is none.
    pub fn waypoints(&self) -> usize {
        self.path().len() / self.columns.robot_width().max(1)
    }

    /// How the caller's columns lie in [`Self::path`].
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// The path in the caller's columns, row by row: where it lies, or a copy if these are not the
    /// robot's.
    pub fn rows(&self) -> Cow<'_, [f64]> {
        if self.columns.are_the_robots() {
            return Cow::Borrowed(self.path());
        }
        let mut rows = vec![0.0; self.waypoints() * self.columns.width()];
        self.columns.read(self.path(), &mut rows);
        Cow::Owned(rows)
    }

    /// Itself if it is a success or an improvement; also where its path is proved and only
    /// [times](Self::times) are missing ([`Code::Untimed`]).
    ///
    /// # Errors
    /// [`PlannerError::Refused`] otherwise, with what is not kept and where, if the path is wrong.
    pub fn check(self) -> Result<Self, PlannerError> {
        match self.refused()? {
            None => Ok(self),
            Some(refused) => Err(PlannerError::Refused(Box::new(refused))),
        }
    }

    /// What it says against the path or the request, if it is no success. That times are missing says
    /// nothing against the path.
    ///
    /// # Errors
    /// [`PlannerError::Client`] only if the daemon changed it after sending.
    pub fn refused(&self) -> Result<Option<Refused>, PlannerError> {
        if matches!(self.code(), Code::Success | Code::Untimed) {
            return Ok(None);
        }
        Ok(Some(Refused::of_view(&self.view()?)?))
    }
}
