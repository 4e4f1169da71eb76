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

    /// The same of each column of a whole trajectory, which ends at rest, and begins so where its first
    /// point says no velocity: where it does that straight, velocities jump.
    pub fn usage_by_column(&self, curve: &Curve) -> Vec<Usage> {
        let columns = self.0.iter().enumerate();
        columns
            .map(|(column, limits)| {
                let own = Own {
                    limits,
                    curve,
                    column,
                };
                self.usage_of(curve, column).most(own.ends())
            })
            .collect()
    }

    /// What one column of a curve uses of its own.
    pub fn usage_of(&self, curve: &Curve, column: usize) -> Usage {
        let own = Own {
            limits: &self.0[column],
            curve,
            column,
        };
        let points = 0..curve.segments();
        points
            .map(|point| own.between(point))
            .chain(own.jumps())
            .fold(Usage::default(), Usage::most)
    }
}

/// A column of a curve, and its limits.
struct Own<'a> {
    limits: &'a ColumnLimits,
    curve: &'a Curve,
    column: usize,
}

impl Own<'_> {
    fn used(&self, range: &Range, value: f64, time_s: f64) -> Use {
        Use {
            part: range.part(value),
            time_s,
            column: self.column,
        }
    }

    /// The larger part of least and greatest, each with its time after a point (s).
    fn largest(&self, range: &Range, point: usize, extremes: [(f64, f64); 2]) -> Use {
        let start_s = self.curve.time(point);
        let [least, most] = extremes.map(|(value, t)| self.used(range, value, start_s + t));
        least.most(most)
    }

    /// From a point to the next.
    fn between(&self, point: usize) -> Usage {
        let velocity = self
            .curve
            .column(point, self.column)
            .derivative();
        let acceleration = velocity.derivative();
        let until = self.curve.duration(point);
        let ColumnLimits {
            velocity: slow,
            acceleration: gentle,
        } = self.limits;
        Usage {
            velocity: self.largest(slow, point, velocity.extremes(0.0, until)),
            acceleration: self.largest(gentle, point, acceleration.extremes(0.0, until)),
        }
    }

    /// Where straight lines meet velocities jump: their differences count as accelerations.
    fn jumps(&self) -> impl Iterator<Item = Usage> + '_ {
        let points = 1..self.curve.segments();
        let jumps = points
            .filter(|point| self.curve.is_straight(*point - 1) || self.curve.is_straight(*point));
        jumps.map(|point| self.jump(point))
    }

    /// From rest, or the velocity that is said, and to rest.
    fn ends(&self) -> Usage {
        let last = self.curve.segments() - 1;
        let start = self.curve.start_velocity(self.column);
        let [first_s, last_s] = [0, last].map(|point| self.curve.duration(point));
        let gained = self.velocity(0, 0.0) - start;
        let lost = -self.velocity(last, last_s);
        let first = self.changed(gained / first_s, self.curve.time(0));
        first.most(self.changed(lost / last_s, self.curve.time(last) + last_s))
    }

    fn velocity(&self, point: usize, t: f64) -> f64 {
        let column = self.curve.column(point, self.column);
        column.derivative().at(t)
    }

    fn changed(&self, rate: f64, time_s: f64) -> Usage {
        Usage {
            acceleration: self.used(&self.limits.acceleration, rate, time_s),
            ..Usage::default()
        }
    }

    fn jump(&self, point: usize) -> Usage {
        let [before_s, after_s] = [point - 1, point].map(|at| self.curve.duration(at));
        let change = self.velocity(point, 0.0) - self.velocity(point - 1, before_s);
        let rate = change / (0.5 * (before_s + after_s));
        self.changed(rate, self.curve.time(point))
    }
}
