//! What the motors allow: the least and greatest velocity and acceleration of each column.

use crate::validation::timed::Curve;

/// From the least to the greatest value, 0 between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Not above 0.
    pub least: f64,
    /// Not below 0.
    pub most: f64,
}

impl Range {
    /// No limit.
    pub const FREE: Self = Self {
        least: f64::NEG_INFINITY,
        most: f64::INFINITY,
    };

    /// The same in both directions.
    pub fn symmetric(most: f64) -> Self {
        Self { least: -most, most }
    }

    /// Which part of the limit in its direction a value is; ∞ where there is none to go in.
    pub fn part(&self, value: f64) -> f64 {
        if value == 0.0 {
            return 0.0;
        }
        value / self.towards(value)
    }

    /// The limit in the direction of a value, with its sign.
    pub fn towards(&self, value: f64) -> f64 {
        if value < 0.0 { self.least } else { self.most }
    }

    /// Whether both directions have a limit above 0 that is a number.
    pub fn is_usable(&self) -> bool {
        let is_size = |size: f64| size > 0.0 && size.is_finite();
        is_size(-self.least) && is_size(self.most)
    }

    /// What is within both.
    #[must_use]
    pub fn within(self, other: Self) -> Self {
        Self {
            least: self.least.max(other.least),
            most: self.most.min(other.most),
        }
    }

    /// The values that are in it when multiplied by this, which is not 0.
    #[must_use]
    pub fn divided(self, factor: f64) -> Self {
        let ends = [self.least / factor, self.most / factor];
        Self {
            least: ends[0].min(ends[1]),
            most: ends[0].max(ends[1]),
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self {
            least: self.least * factor,
            most: self.most * factor,
        }
    }
}

/// The limits of one column (m or rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColumnLimits {
    /// Per second.
    pub velocity: Range,
    /// Per second squared.
    pub acceleration: Range,
}

/// The limits of all columns, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits(Vec<ColumnLimits>);

/// The largest part of a limit that a curve uses, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Use {
    /// 1 is all of it.
    pub part: f64,
    /// When (s).
    pub time_s: f64,
    /// Of which column.
    pub column: usize,
}

/// What a curve uses of limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Usage {
    /// Of the velocities.
    pub velocity: Use,
    /// Of the accelerations.
    pub acceleration: Use,
}

impl Usage {
    /// How many times as long the curve must take to be within its limits, if it is beyond any.
    pub fn stretch(&self) -> f64 {
        self.velocity
            .part
            .max(self.acceleration.part.sqrt())
    }

    /// Of both, what uses more.
    #[must_use]
    pub fn most(self, other: Self) -> Self {
        Self {
            velocity: self.velocity.most(other.velocity),
            acceleration: self.acceleration.most(other.acceleration),
        }
    }
}

impl Use {
    fn most(self, other: Self) -> Self {
        if other.part > self.part { other } else { self }
    }
}

impl Limits {
    /// Of these columns.
    pub fn new(columns: Vec<ColumnLimits>) -> Self {
        Self(columns)
    }

    /// Of each column.
    pub fn columns(&self) -> &[ColumnLimits] {
        &self.0
    }

    /// The limits at which whatever goes takes 1 / `speed` times as long.
    #[must_use]
    pub fn at_speed(&self, speed: f64) -> Self {
        let columns = self.0.iter();
        let slower = |limits: &ColumnLimits| ColumnLimits {
            velocity: limits.velocity.scaled(speed),
            acceleration: limits.acceleration.scaled(speed * speed),
        };
        Self(columns.map(slower).collect())
    }

    /// What a curve uses of them, between its points too.
    pub fn usage(&self, curve: &Curve) -> Usage {
        let columns = 0..self.0.len();
        columns
            .map(|column| self.usage_of(curve, column))
            .fold(Usage::default(), Usage::most)
    }

    /// The same of each column.
    pub fn usage_by_column(&self, curve: &Curve) -> Vec<Usage> {
        let columns = 0..self.0.len();
        columns
            .map(|column| self.usage_of(curve, column))
            .collect()
    }

    /// What one column of a curve uses of its own.
    pub fn usage_of(&self, curve: &Curve, column: usize) -> Usage {
        let limits = &self.0[column];
        let points = 0..curve.segments();
        points.fold(Usage::default(), |usage, point| {
            let velocity = curve.column(point, column).derivative();
            let acceleration = velocity.derivative();
            let until = curve.duration(point);
            let largest = |range: &Range, extremes: [(f64, f64); 2]| {
                let uses = extremes.map(|(value, t)| Use {
                    part: range.part(value),
                    time_s: curve.time(point) + t,
                    column,
                });
                uses[0].most(uses[1])
            };
            usage.most(Usage {
                velocity: largest(&limits.velocity, velocity.extremes(0.0, until)),
                acceleration: largest(&limits.acceleration, acceleration.extremes(0.0, until)),
            })
        })
    }
}
