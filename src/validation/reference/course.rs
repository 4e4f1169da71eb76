//! How columns go on a segment of what is verified, for ratios in [0, 1].

use super::column::Column;
use super::travel::Travel;
use crate::robot::{Component, ConfigurationSpace, Kinematics, RobotModel};

/// An interval of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) middle: f64,
    pub(super) half: f64,
    pub(super) depth: u32,
}

impl Interval {
    /// The segment.
    pub(super) const WHOLE: Self = Self {
        middle: 0.5,
        half: 0.5,
        depth: 0,
    };

    pub(super) fn halves(&self) -> [Self; 2] {
        let half = self.half / 2.0;
        let depth = self.depth + 1;
        [self.middle - half, self.middle + half].map(|middle| Self {
            middle,
            half,
            depth,
        })
    }

    fn ends(&self) -> [f64; 2] {
        [self.middle - self.half, self.middle + self.half]
    }
}

/// How columns go on a segment.
#[derive(Clone, Debug)]
pub(super) enum Course<'a> {
    /// Straight: `q(t) = from ⊕ t velocity`.
    Straight {
        space: &'a ConfigurationSpace,
        from: &'a [f64],
        velocity: Vec<f64>,
    },
    /// Each column on its own; quaternions stand still.
    Curved {
        space: &'a ConfigurationSpace,
        columns: &'a [Column],
    },
}

impl<'a> Course<'a> {
    /// Straight from one configuration to another.
    pub(super) fn straight(space: &'a ConfigurationSpace, [from, to]: [&'a [f64]; 2]) -> Self {
        let mut velocity = vec![0.0; space.nv()];
        space.difference(to, from, &mut velocity);
        Self::Straight {
            space,
            from,
            velocity,
        }
    }

    /// Whether it has other bounds on each of its intervals.
    pub(super) fn is_curved(&self) -> bool {
        matches!(self, Self::Curved { .. })
    }

    /// The configuration at a ratio.
    pub(super) fn at(&self, t: f64) -> Vec<f64> {
        match self {
            Self::Straight {
                space,
                from,
                velocity,
            } => {
                let mut configuration = from.to_vec();
                space.integrate(from, velocity, t, &mut configuration);
                configuration
            }
            Self::Curved { columns, .. } => columns
                .iter()
                .map(|column| column.at(t))
                .collect(),
        }
    }

    /// How a robot moves on an interval, at most; and where it is placed there.
    pub(super) fn travel<'r>(
        &self,
        robot: &'r RobotModel,
        held: &[f64],
        interval: Interval,
    ) -> (Travel<'r>, Kinematics) {
        let place = |t: f64| {
            let mut kinematics = Kinematics::default();
            kinematics.update(robot, &self.at(t), held);
            kinematics
        };
        let speeds = self.speeds(interval);
        if self.is_curved() {
            let middle = place(interval.middle);
            return (Travel::about(robot, speeds, &middle, interval.half), middle);
        }
        // One for the whole segment, as the arms are.
        let [first, last] = [0.0, 1.0].map(place);
        (Travel::new(robot, &speeds, [&first, &last]), first)
    }

    /// How fast each coordinate is at most on an interval, by its size where it is curved (per unit t).
    pub(super) fn speeds(&self, interval: Interval) -> Vec<f64> {
        match self {
            Self::Straight { velocity, .. } => velocity.clone(),
            Self::Curved { space, columns } => {
                let ends = interval.ends();
                let mut speeds = vec![0.0; space.nv()];
                for component in space.components() {
                    if let Component::Line { q, v } | Component::Circle { q, v } = *component {
                        speeds[v] = columns[q].derivative().part(ends).size();
                    }
                }
                speeds
            }
        }
    }
}
