//! How far the bodies can move in an interval of a straight segment: the theorem behind the proof.
//!
//! On a segment `q(t) = q₀ ⊕ t v`, t ∈ [0, 1], every joint moves at constant speed. For a body X
//! and an ancestor frame C, let the elementary motions from C to X be l = 1 … n, with angular speed
//! ω_l (0 for a translation) and `s_l` = ω_l ρ_l for a rotation, ρ_l the farthest that X can be
//! from its axis, or the speed of a translation. Then in C's frame, per unit t, every point of X
//! * moves at most at V = Σ s_l, and
//! * accelerates at most by A = Σ s_l (ω_l + 2 Σ_{i<l} ω_i).
//!
//! On a curve, where each coordinate is a polynomial of t, speeds are the greatest on an interval, and A
//! has Σ ρ_l α_l more (α_l alone for a translation): ½ h² α_l is how far coordinate l gets from where its
//! velocity at m would take it, and a point of X gets as many times as far as its arm is long. All that is
//! said of V and A then holds on that interval ([`Course`]).
//!
//! For convex A and B, an interval of half width h about m, any unit vector n and the support gap g
//! along it at m, the distance at every t of the interval is at least g − D with D = h |n·v_rel| +
//! h (‖n×ω_A‖ R_A + ‖n×ω_B‖ R_B) + ½ h² (A_A + A_B), v_rel the relative velocity at m of one point
//! of each body, R the radius of the body about that point.

use super::way::Expansion;
use crate::collision::chain::{ChainMotion, MotionKind, Source};
use crate::math::Vec3;
use crate::solid::transform::Transform;

/// Speed and acceleration bounds of what a chain of motions carries on one segment, for every
/// ancestor on the chain.
#[derive(Clone, Debug, Default)]
pub struct MotionBounds {
    /// Entry k counts the motions from the k-th on; the last entry, for none, is zero.
    from: Vec<Sums>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Σ s_l.
    speed: f64,
    /// Σ s_l (ω_l + 2 Ω_l), Ω_l the turning speed of all motions before l, from the root on; and what
    /// the coordinates' own accelerations add.
    acceleration: f64,
    /// Turning speed of all motions before this one, from the root on.
    turning_before: f64,
}

impl MotionBounds {
    /// Computes the bounds for a course.
    pub fn update(&mut self, chain: &[ChainMotion], course: &Course, held: &[f64]) {
        let speeds = course.speeds();
        self.add_up_turning(chain, speeds);
        // From the body up: what lies between a motion and the body is then known.
        let mut pushed = 0.0;
        for (k, motion) in chain.iter().enumerate().rev() {
            let turning = turning_speed(motion, speeds);
            let own = course.acceleration(motion);
            let (speed, acceleration) = match motion.kind {
                MotionKind::Translation(_) => {
                    // It takes the body farther from every axis above it.
                    pushed += course.push(motion, held);
                    (rate(motion, speeds).length(), own)
                }
                MotionKind::Axis | MotionKind::Ball => {
                    let arm = motion.reach + pushed;
                    (turning * arm, own * arm)
                }
            };
            self.add(k, speed, turning);
            self.from[k].acceleration += acceleration;
        }
    }

    /// `turning_before` of every motion, from the root on.
    fn add_up_turning(&mut self, chain: &[ChainMotion], velocity: &[f64]) {
        self.from.clear();
        self.from
            .resize(chain.len() + 1, Sums::default());
        let mut turning = 0.0;
        for (sums, motion) in self.from.iter_mut().zip(chain) {
            sums.turning_before = turning;
            turning += turning_speed(motion, velocity);
        }
    }

    /// The bounds of what moves by no motion of a chain, at this acceleration.
    pub fn accelerate(&mut self, acceleration: f64) {
        self.from.clear();
        self.from.push(Sums {
            acceleration,
            ..Sums::default()
        });
    }

    /// Adds the k-th motion's `s_l` and ω_l to the sums of those after it.
    fn add(&mut self, k: usize, speed: f64, turning: f64) {
        let after = self.from[k + 1];
        let sums = &mut self.from[k];
        sums.speed = after.speed + speed;
        // ω_l twice over is the centripetal part, 2 Ω_l what turns before it adds (Coriolis).
        sums.acceleration = after.acceleration + speed * (turning + 2.0 * sums.turning_before);
    }

    /// V of the body relative to an ancestor, given how many of its motions act at or above that
    /// ancestor.
    pub fn speed(&self, motions_above: usize) -> f64 {
        self.from
            .get(motions_above)
            .map_or(0.0, |sums| sums.speed)
    }

    /// A of the body relative to that ancestor.
    pub fn acceleration(&self, motions_above: usize) -> f64 {
        let Some(sums) = self.from.get(motions_above) else {
            return 0.0;
        };
        // What turns at or above the ancestor carries both bodies alike.
        let relative = sums.acceleration - 2.0 * sums.turning_before * sums.speed;
        // The subtraction may lose the last bits of the larger term.
        relative.max(0.0) + 1e-14 * sums.acceleration
    }
}

/// Velocity of an elementary motion per unit t, by coordinates.
fn rate(motion: &ChainMotion, velocity: &[f64]) -> Vec3 {
    let Some(first) = motion.coordinate else {
        return Vec3::ZERO;
    };
    let count = coordinates(motion.kind);
    vector(&velocity[first..first + count]) * motion.factor
}

/// How many coordinates drive a motion.
fn coordinates(kind: MotionKind) -> usize {
    match kind {
        MotionKind::Axis => 1,
        MotionKind::Translation(n) => n,
        MotionKind::Ball => 3,
    }
}

fn turning_speed(motion: &ChainMotion, velocity: &[f64]) -> f64 {
    match motion.kind {
        MotionKind::Translation(_) => 0.0,
        MotionKind::Axis | MotionKind::Ball => rate(motion, velocity).length(),
    }
}

/// How the coordinates go, as far as bounds ask; per unit t.
#[derive(Clone, Copy, Debug)]
pub enum Course<'a> {
    /// `from ⊕ t velocity`, t ∈ [0, 1].
    Straight {
        /// Where it begins.
        from: &'a [f64],
        /// The same everywhere.
        velocity: &'a [f64],
    },
    /// An interval of a curve.
    Curved(&'a Expansion),
}

impl<'a> Course<'a> {
    /// Of each coordinate, with or without its sign.
    fn speeds(&self) -> &'a [f64] {
        match self {
            Self::Straight { velocity, .. } => velocity,
            Self::Curved(expansion) => &expansion.speed,
        }
    }

    /// Of a coordinate itself.
    pub fn acceleration_of(&self, coordinate: usize) -> f64 {
        match self {
            Self::Straight { .. } => 0.0,
            Self::Curved(expansion) => expansion.acceleration[coordinate],
        }
    }

    /// Of an elementary motion's coordinates themselves.
    fn acceleration(&self, motion: &ChainMotion) -> f64 {
        match self {
            Self::Straight { .. } => 0.0,
            Self::Curved(expansion) => rate(motion, &expansion.acceleration).length(),
        }
    }

    /// How far a translation gets from its rest value.
    fn push(&self, motion: &ChainMotion, held: &[f64]) -> f64 {
        let MotionKind::Translation(n) = motion.kind else {
            return 0.0;
        };
        match self {
            Self::Straight { from, velocity } => {
                // At one of the ends.
                let start = offset_from_rest(motion, n, from, held);
                farthest(start, start + rate(motion, velocity))
            }
            Self::Curved(expansion) => {
                let middle = offset_from_rest(motion, n, &expansion.middle, held);
                middle.length() + expansion.half * rate(motion, &expansion.speed).length()
            }
        }
    }
}

/// How far what goes straight between two points gets from the origin.
fn farthest(start: Vec3, end: Vec3) -> f64 {
    // A norm is convex: on a straight way it is largest at an end.
    start.length().max(end.length())
}

/// Where a translation of n coordinates is in a configuration, seen from its rest value.
fn offset_from_rest(motion: &ChainMotion, n: usize, from: &[f64], held: &[f64]) -> Vec3 {
    let start = start(motion.source, n, from, held);
    // Only a single coordinate follows another one with an offset.
    let shift = if n == 1 {
        Vec3::X * motion.offset
    } else {
        Vec3::ZERO
    };
    start * motion.factor + shift - motion.rest
}

/// Its coordinates in a configuration.
fn start(source: Source, n: usize, from: &[f64], held: &[f64]) -> Vec3 {
    match source {
        Source::Column(q) => vector(&from[q..q + n]),
        Source::Held(i) => vector(&held[i..i + n]),
    }
}

fn vector(values: &[f64]) -> Vec3 {
    let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
    Vec3::new(at(0), at(1), at(2))
}

/// Velocity field of a rigid body, `v(p) = linear + angular × p`, p from the frame's own origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Twist {
    /// Angular velocity.
    pub angular: Vec3,
    /// Velocity of the point at the frame's origin.
    pub linear: Vec3,
}

impl Twist {
    /// From the velocity of one point of the body.
    pub fn through(angular: Vec3, linear: Vec3, point: Vec3) -> Self {
        Self {
            angular,
            linear: linear - angular.cross(point),
        }
    }

    /// Velocity of the body's point at `p`.
    pub fn at(&self, p: Vec3) -> Vec3 {
        self.linear + self.angular.cross(p)
    }

    /// ‖n × ω‖: how fast the body turns towards a direction, for each metre of its radius.
    #[inline]
    pub fn swing(&self, normal: Vec3) -> f64 {
        normal.cross(self.angular).length()
    }

    /// Motion relative to another body, in the same frame of reference.
    pub fn relative_to(&self, other: &Self) -> Self {
        Self {
            angular: self.angular - other.angular,
            linear: self.linear - other.linear,
        }
    }

    /// The same motion in the frame of `place`, whose own motion does not count.
    pub fn seen_from(&self, place: &Transform) -> Self {
        let back = place.rotation.transpose();
        Self {
            angular: back * self.angular,
            linear: back * self.at(place.translation),
        }
    }

    /// The same, `factor` times as fast.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            angular: self.angular * factor,
            linear: self.linear * factor,
        }
    }
}
