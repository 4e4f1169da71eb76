//! One column between two points of a timed trajectory: a polynomial, its derivatives, its extremes,
//! and how it looks from one of its places.

/// Σ c_k t^k, t in seconds from the first of the two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomial([f64; 6]);

/// Position, velocity and acceleration at a point, as far as they count there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Knot {
    /// m or rad.
    pub position: f64,
    /// Per second.
    pub velocity: f64,
    /// Per second squared.
    pub acceleration: f64,
}

impl Polynomial {
    /// What stands still.
    pub fn constant(position: f64) -> Self {
        Self([position, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    /// The straight line between two positions.
    pub fn linear(a: Knot, b: Knot, duration: f64) -> Self {
        Self([
            a.position,
            (b.position - a.position) / duration,
            0.0,
            0.0,
            0.0,
            0.0,
        ])
    }

    /// The cubic with these positions and velocities at its ends.
    pub fn cubic(a: Knot, b: Knot, duration: f64) -> Self {
        let t = duration;
        let step = b.position - a.position;
        let quadratic = (3.0 * step - (2.0 * a.velocity + b.velocity) * t) / (t * t);
        let cubic = ((a.velocity + b.velocity) * t - 2.0 * step) / (t * t * t);
        Self([a.position, a.velocity, quadratic, cubic, 0.0, 0.0])
    }

    /// The quintic with these positions, velocities and accelerations at its ends.
    pub fn quintic(a: Knot, b: Knot, duration: f64) -> Self {
        let t = duration;
        let step = b.position - a.position;
        let v = a.velocity * t;
        let w = b.velocity * t;
        let k = a.acceleration * t * t;
        let l = b.acceleration * t * t;
        let cubic = (20.0 * step - 12.0 * v - 8.0 * w - 3.0 * k + l) / 2.0;
        let quartic = (-30.0 * step + 16.0 * v + 14.0 * w + 3.0 * k - 2.0 * l) / 2.0;
        let quintic = (12.0 * step - 6.0 * v - 6.0 * w - k + l) / 2.0;
        Self([
            a.position,
            a.velocity,
            0.5 * a.acceleration,
            cubic / t.powi(3),
            quartic / t.powi(4),
            quintic / t.powi(5),
        ])
    }

    /// Its value at a time (s).
    pub fn at(&self, t: f64) -> f64 {
        self.0
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * t + c)
    }

    /// The same by τ, where t = at + scale τ: the coefficients of τ⁰, τ¹, …
    pub fn seen_from(&self, at: f64, scale: f64) -> [f64; 6] {
        let mut coefficients = self.0;
        let degree = self.degree();
        for first in 0..degree {
            for k in (first..degree).rev() {
                coefficients[k] += at * coefficients[k + 1];
            }
        }
        let mut power = 1.0;
        for coefficient in &mut coefficients[1..=degree] {
            power *= scale;
            *coefficient *= power;
        }
        coefficients
    }

    /// What it is between two times, as a polynomial of the ratio between them.
    #[must_use]
    pub fn stretch(&self, from: f64, to: f64) -> Self {
        Self(self.seen_from(from, to - from))
    }

    fn degree(&self) -> usize {
        let known = self.0.iter().rposition(|c| *c != 0.0);
        known.unwrap_or(0)
    }

    /// Its derivative by time.
    #[must_use]
    pub fn derivative(&self) -> Self {
        let [_, a, b, c, d, e] = self.0;
        Self([a, 2.0 * b, 3.0 * c, 4.0 * d, 5.0 * e, 0.0])
    }

    /// Least and greatest value between two times, each with when it is taken (s).
    pub fn extremes(&self, from: f64, to: f64) -> [(f64, f64); 2] {
        let turns = self
            .turns(from, to)
            .into_iter()
            .chain([from, to]);
        let values = turns.map(|t| (self.at(t), t));
        let none = [(f64::INFINITY, from), (f64::NEG_INFINITY, from)];
        values.fold(none, |[low, high], value| {
            [
                if value.0 < low.0 { value } else { low },
                if value.0 > high.0 { value } else { high },
            ]
        })
    }

    /// Where it turns between two times.
    fn turns(&self, from: f64, to: f64) -> Vec<f64> {
        let mut turns = Vec::with_capacity(6);
        self.derivative().roots(from, to, &mut turns);
        turns
    }

    /// The largest |value| between two times.
    pub fn largest(&self, from: f64, to: f64) -> f64 {
        let [(low, _), (high, _)] = self.extremes(from, to);
        low.abs().max(high.abs())
    }

    /// Places between two times where the sign changes, in order: between two turns there is at
    /// most one.
    fn roots(&self, from: f64, to: f64, found: &mut Vec<f64>) {
        if self.is_constant() {
            return;
        }
        if self.degree() == 1 {
            let root = -self.0[0] / self.0[1];
            return found.extend(Some(root).filter(|root| (from..=to).contains(root)));
        }
        let mut left = from;
        for right in self.turns(from, to).into_iter().chain([to]) {
            found.extend(self.root_between(left, right));
            left = right;
        }
    }

    /// Whether it stands still.
    pub fn is_constant(&self) -> bool {
        self.0[1..].iter().all(|c| *c == 0.0)
    }

    /// By halving, where the signs at both ends differ.
    fn root_between(&self, mut left: f64, mut right: f64) -> Option<f64> {
        let rising = self.at(left) <= 0.0;
        if rising == (self.at(right) <= 0.0) {
            return None;
        }
        loop {
            let middle = left + (right - left) / 2.0;
            if middle <= left || middle >= right {
                return Some(left);
            }
            if (self.at(middle) <= 0.0) == rising {
                left = middle
            } else {
                right = middle
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knot(rng: &mut fastrand::Rng) -> Knot {
        let mut number = || 4.0 * rng.f64() - 2.0;
        Knot {
            position: number(),
            velocity: number(),
            acceleration: number(),
        }
    }

    #[test]
    fn ends_are_as_given() {
        let mut rng = fastrand::Rng::with_seed(1);
        for _ in 0..200 {
            let a = knot(&mut rng);
            let b = knot(&mut rng);
            let t = 0.05 + 3.0 * rng.f64();
            let close =
                |x: f64, y: f64| assert!((x - y).abs() < 1e-9 * (1.0 + 1.0 / t.powi(2)), "{x} {y}");
            let polynomials = [Polynomial::linear, Polynomial::cubic, Polynomial::quintic]
                .map(|make| make(a, b, t));
            for (degree, polynomial) in polynomials.iter().enumerate() {
                let first = polynomial.derivative();
                let second = polynomial.derivative().derivative();
                for (at, end) in [(0.0, a), (t, b)] {
                    close(polynomial.at(at), end.position);
                    if degree > 0 {
                        close(first.at(at), end.velocity);
                    }
                    if degree > 1 {
                        close(second.at(at), end.acceleration);
                    }
                }
            }
        }
    }

    #[test]
    fn a_stretch_is_the_same_polynomial() {
        let mut rng = fastrand::Rng::with_seed(3);
        for _ in 0..200 {
            let a = knot(&mut rng);
            let b = knot(&mut rng);
            for make in [Polynomial::linear, Polynomial::cubic, Polynomial::quintic] {
                let polynomial = make(a, b, 1.5);
                let stretch = polynomial.stretch(0.3, 1.1);
                for part in 0..=8 {
                    let ratio = f64::from(part) / 8.0;
                    let there = polynomial.at(0.3 + 0.8 * ratio);
                    assert!((stretch.at(ratio) - there).abs() < 1e-12, "{there}");
                }
            }
        }
    }

    #[test]
    fn nothing_sampled_is_beyond_the_extremes_and_they_are_taken() {
        let mut rng = fastrand::Rng::with_seed(2);
        for _ in 0..500 {
            let a = knot(&mut rng);
            let b = knot(&mut rng);
            let t = 0.2 + 2.0 * rng.f64();
            let mut polynomial = Polynomial::quintic(a, b, t);
            for _ in 0..3 {
                let [(low, when_low), (high, when_high)] = polynomial.extremes(0.0, t);
                let sampled: Vec<f64> = (0..=2000)
                    .map(|i| polynomial.at(t * f64::from(i) / 2000.0))
                    .collect();
                let scale = 1e-12 * (low.abs() + high.abs());
                assert!(
                    sampled
                        .iter()
                        .all(|x| (low - scale..=high + scale).contains(x))
                );
                assert_eq!(
                    [polynomial.at(when_low), polynomial.at(when_high)],
                    [low, high]
                );
                polynomial = polynomial.derivative();
            }
        }
    }
}
