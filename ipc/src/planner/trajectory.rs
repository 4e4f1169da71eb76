//! The trajectory of an answer.

use super::Columns;
use crate::wire::{
    Controller, HoldRecord, LoweredFloorRecord, RequirementKind, ResponseView, TimingStage,
    TrajectoryRecord, Unit, WireError,
};

/// When what is to be where: proved as it is written, at every instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// When each point is passed (ns from the start, where the first one is).
    pub times_ns: Vec<i64>,
    /// Columns of a point, in the order of the request's.
    pub columns: usize,
    /// Positions, point by point (m or rad).
    pub positions: Vec<f64>,
    /// Velocities, point by point (per s); empty where the controller goes straight.
    pub velocities: Vec<f64>,
    /// Accelerations, point by point (per s²); empty where the controller goes without: given them, it
    /// would go another way between the points.
    pub accelerations: Vec<f64>,
    /// For each column the least and greatest velocity, the least and greatest acceleration that it was
    /// allowed.
    pub limits: Vec<[f64; 4]>,
    /// What goes from point to point.
    pub controller: Controller,
    /// Points per second of a controller that goes straight; else 0.
    pub rate_hz: f64,
    /// What it comes of.
    pub stage: TimingStage,
    /// No trajectory between the same ends within the same limits takes less (s).
    pub bound_s: f64,
    /// What the first trajectory that was proved takes, which stops where it must (s).
    pub stops_s: f64,
    /// Clearance that is proved at every instant (m); infinite where nothing is near.
    pub clearance_m: f64,
    /// Work that it took.
    pub work: u64,
    /// What each column uses of its limits.
    pub used: Vec<Used>,
    /// The column whose motor needs the time of the bound; `None` where it is none of the request's.
    pub decides: Option<usize>,
    /// What it is proved at lower floors.
    pub lowered: Vec<Lowered>,
    /// Where it comes nearest to anything, where that was looked for and found.
    pub nearest: Option<Nearest>,
}

/// The largest parts of its limits that a column uses; 1 is all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Used {
    /// Of a limit of velocity.
    pub velocity: f64,
    /// When (s).
    pub velocity_time_s: f64,
    /// Of a limit of acceleration.
    pub acceleration: f64,
    /// When (s).
    pub acceleration_time_s: f64,
}

/// A floor that is lower than asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Lowered {
    /// What kind of thing it is about.
    pub kind: RequirementKind,
    /// What it is about: of a clearance the two bodies.
    pub names: Vec<String>,
    /// The floor.
    pub floor: f64,
    /// What it is counted in.
    pub unit: Unit,
}

/// A place where two bodies are close.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// When (s).
    pub time_s: f64,
    /// The two bodies.
    pub names: Vec<String>,
    /// Their distance (m).
    pub distance_m: f64,
    /// The closest points, in the world (m).
    pub points: [[f64; 3]; 2],
    /// Unit vector from the second body to the first.
    pub normal: [f64; 3],
}

impl Trajectory {
    /// That of a response; `None` where there is none.
    pub(super) fn of_view(
        view: &ResponseView<'_>,
        columns: &Columns,
    ) -> Result<Option<Self>, WireError> {
        let sections = &view.trajectory;
        let Some(head) = sections.head else {
            return Ok(None);
        };
        let table = |numbers: &[f64]| {
            let mut rows =
                vec![0.0; numbers.len() / columns.robot_width().max(1) * columns.width()];
            columns.read(numbers, &mut rows);
            rows
        };
        let limits = sections.limits.chunks_exact(4);
        let limits: Vec<[f64; 4]> = limits
            .map(|own| [own[0], own[1], own[2], own[3]])
            .collect();
        let used: Vec<Used> = sections
            .used
            .chunks_exact(4)
            .map(Used::of)
            .collect();
        let floors = sections.lowered_floors.iter();
        let nearest = sections.nearest;
        Ok(Some(Self {
            times_ns: sections.times_ns.to_vec(),
            columns: columns.width(),
            positions: table(sections.positions),
            velocities: table(sections.velocities),
            accelerations: table(sections.accelerations),
            limits: columns.pick(&limits),
            used: columns.pick(&used),
            decides: columns.column_of(head.decides as usize),
            lowered: floors
                .map(|floor| Lowered::of(floor, view))
                .collect::<Result<_, _>>()?,
            nearest: nearest
                .map(|record| Nearest::of(record, view))
                .transpose()?,
            ..Self::of_head(head)?
        }))
    }

    /// All but its points.
    fn of_head(head: &TrajectoryRecord) -> Result<Self, WireError> {
        Ok(Self {
            times_ns: Vec::new(),
            columns: 0,
            positions: Vec::new(),
            velocities: Vec::new(),
            accelerations: Vec::new(),
            limits: Vec::new(),
            controller: Controller::try_from(head.controller)?,
            rate_hz: head.rate_hz,
            stage: TimingStage::try_from(head.stage)?,
            bound_s: head.bound_s,
            stops_s: head.stops_s,
            clearance_m: head.clearance_m,
            work: head.work,
            used: Vec::new(),
            decides: None,
            lowered: Vec::new(),
            nearest: None,
        })
    }

    /// From the first point to the last (s).
    pub fn duration_s(&self) -> f64 {
        self.times_ns
            .last()
            .map_or(0.0, |ns| *ns as f64 / 1e9)
    }

    /// By which part of the least time it takes longer; 0 where that bound is 0.
    pub fn gap(&self) -> f64 {
        match self.bound_s > 0.0 {
            true => self.duration_s() / self.bound_s - 1.0,
            false => 0.0,
        }
    }

    /// Its points.
    pub fn points(&self) -> usize {
        self.times_ns.len()
    }
}

impl Used {
    fn of(numbers: &[f64]) -> Self {
        Self {
            velocity: numbers[0],
            velocity_time_s: numbers[1],
            acceleration: numbers[2],
            acceleration_time_s: numbers[3],
        }
    }
}

impl Lowered {
    fn of(record: &LoweredFloorRecord, view: &ResponseView<'_>) -> Result<Self, WireError> {
        let requirement = &record.requirement;
        Ok(Self {
            kind: RequirementKind::try_from(requirement.kind)?,
            names: requirement.names(view.names)?,
            floor: record.floor,
            unit: Unit::try_from(requirement.unit)?,
        })
    }
}

impl Nearest {
    fn of(record: &HoldRecord, view: &ResponseView<'_>) -> Result<Self, WireError> {
        Ok(Self {
            time_s: time_s(view.trajectory.times_ns, record.segment as usize, record.t),
            names: record.requirement.names(view.names)?,
            distance_m: record.amount,
            points: record.points,
            normal: record.normal,
        })
    }
}

/// The time of a place between two points.
pub(crate) fn time_s(times_ns: &[i64], segment: usize, t: f64) -> f64 {
    let at = |point: usize| {
        let last = times_ns.len().saturating_sub(1);
        times_ns
            .get(point.min(last))
            .map_or(0.0, |ns| *ns as f64)
    };
    (at(segment) + t * (at(segment + 1) - at(segment))) / 1e9
}
