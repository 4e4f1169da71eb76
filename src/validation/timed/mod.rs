//! Timed trajectories: what a controller executes between the points that it gets is proved, not
//! the points.
//!
//! Between two points a controller follows a polynomial q(t) (`curve`). On a piece of time of width
//! w let c be the chord between the piece's ends. Then |q_j(t) − c_j(t)| ≤ e_j = w²/8 · max |q_j''|
//! on the piece for each column j, so that by [`reach`](super::reach) every pair is at q(t) at
//! least as far apart as at c(t), less E = Σ_j reach_j e_j. A piece is proved by proving its chord,
//! a straight segment, with every floor higher by E.
//!
//! Pieces are halved until E is an eighth of the floor that decides; the rest is as in
//! [`path_proof`](super::path_proof): a pair that comes closer than asked for has its floor
//! lowered, unless that is forbidden. A collision is one only where the bodies touch on the curve
//! itself; one anywhere goes before whatever is not provable anywhere.

pub mod curve;
pub mod inside;
pub mod polynomial;
mod refusal;
#[cfg(test)]
mod tests;

pub use curve::{Curve, CurveError, Outside, Point};

use super::demand::Demand;
use super::floors::Floors;
use super::path_proof::lowered_floor;
use super::reach::{Ranges, Reach};
use super::requirement::{Measure, Requirement};
use super::validator::Validator;
use super::{Enclosed, Hit, HitReason, SegmentProof, SegmentVerdict, SegmentsVerdict};

/// E of a piece is at most this part of the floor that it is proved at.
const DEVIATION: f64 = 1.0 / 8.0;
/// A piece is not halved below this width (s).
const FINEST_S: f64 = 1e-6;
/// Pieces after which a trajectory counts as not provable.
const MOST_PIECES: u64 = 4_000_000;

/// What is known of a timed trajectory.
#[derive(Clone, Debug, PartialEq)]
pub enum TimedVerdict {
    /// Every pair keeps its floor at every instant.
    Proved(TimedProof),
    /// It does not.
    Refused(TimedHit),
    /// `stop` said so.
    Stopped,
}

/// A proof of a timed trajectory, in short.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedProof {
    /// Distance that every pair keeps at every instant (m); ∞ where nothing is near.
    pub clearance_m: f64,
    /// Requirements with a lowered floor, and that floor.
    pub lowered: Vec<(Requirement, f64)>,
    /// Pieces of time that the proof is made of.
    pub pieces: u64,
}

/// Where a timed trajectory is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedHit {
    /// Why.
    pub reason: HitReason,
    /// The point before it, from 0.
    pub point: usize,
    /// When it is first so (s), on the trajectory's clock.
    pub time_s: f64,
    /// What is not kept.
    pub requirement: Requirement,
    /// When it was measured (s): a little later, where bodies are deeper in each other.
    pub seen_s: f64,
    /// How much was kept then.
    pub measure: Measure,
}

/// A piece of time between two points.
#[derive(Clone, Copy, Debug)]
struct Piece {
    point: usize,
    /// From the point on (s).
    from: f64,
    to: f64,
}

impl Piece {
    fn width(&self) -> f64 {
        self.to - self.from
    }

    /// The later half first, as a stack takes them.
    fn halves(&self) -> [Self; 2] {
        let middle = self.from + self.width() / 2.0;
        [
            Self {
                from: middle,
                ..*self
            },
            Self {
                to: middle,
                ..*self
            },
        ]
    }
}

/// What becomes of a piece.
enum Settled {
    Proved,
    /// To be looked at, in parts or with a floor lowered; the later first.
    Again(Vec<Piece>),
    /// The bodies touch on the curve.
    Collision(TimedHit),
    /// They do not, but are closer than can be proved.
    Unprovable(TimedHit),
    /// `stop` said so.
    Stopped,
}

/// The pieces of a curve between points, the last first.
fn whole(curve: &Curve) -> Vec<Piece> {
    let piece = |point| Piece {
        point,
        from: 0.0,
        to: curve.duration(point),
    };
    (0..curve.segments()).rev().map(piece).collect()
}

impl TimedHit {
    /// Bodies are in each other when the curve begins.
    fn at_start(curve: &Curve, requirement: Requirement, measure: Measure) -> Self {
        let time_s = curve.time(0);
        Self {
            reason: HitReason::Collision,
            point: 0,
            time_s,
            requirement,
            seen_s: time_s,
            measure,
        }
    }
}

/// What a proof needs.
struct Prover<'c, 'v, 'm> {
    curve: &'c Curve,
    validator: &'v mut Validator<'m>,
    reach: Reach,
    /// Floor of the clearances that are not lowered (m).
    clearance: f64,
    lowered: Vec<(Requirement, f64)>,
    /// What must be kept on the chord at hand.
    floors: Floors,
    strict: bool,
    pieces: u64,
    kept: f64,
}

/// Proves that a trajectory is free at every instant from its first point to its last, every pair
/// at the validator's floors; where not `strict`, floors of pairs that come closer are lowered,
/// never below [`LEAST_FLOOR_M`](super::path_proof::LEAST_FLOOR_M).
///
/// The validator's space must take columns as they stand: a controller does.
pub fn prove(
    validator: &mut Validator,
    curve: &Curve,
    strict: bool,
    stop: &mut dyn FnMut() -> bool,
) -> TimedVerdict {
    match validator.enclosed_at(&curve.at(0, 0.0), stop) {
        Enclosed::Nothing => {}
        Enclosed::Stopped => return TimedVerdict::Stopped,
        Enclosed::Broken(requirement, measure) => {
            let hit = TimedHit::at_start(curve, requirement, measure);
            return with_depth(validator, curve, TimedVerdict::Refused(hit));
        }
    }
    let mut prover = Prover::new(curve, validator, strict);
    let verdict = match prover.all_at_once(stop) {
        Some(verdict) => verdict,
        None => prover.one_by_one(stop),
    };
    with_depth(validator, curve, verdict)
}

/// The reach of the columns' deviations from chords between values that the curve takes.
fn reach(validator: &Validator, curve: &Curve) -> Reach {
    Reach::new(
        validator.model(),
        validator.examiner.held,
        &ranges(curve),
        0.0,
    )
}

/// What each column is between.
fn ranges(curve: &Curve) -> Ranges {
    let mut ranges = Ranges::none(curve.columns());
    for (column, [low, high]) in curve.ranges().into_iter().enumerate() {
        ranges.add_value(column, low);
        ranges.add_value(column, high);
    }
    ranges
}

/// A collision with its penetration depth, which the search for it does without.
fn with_depth(validator: &mut Validator, curve: &Curve, verdict: TimedVerdict) -> TimedVerdict {
    match verdict {
        TimedVerdict::Refused(hit) if hit.reason == HitReason::Collision => {
            let at = curve.at(hit.point, hit.seen_s - curve.time(hit.point));
            let measure = validator.measure_depth(hit.requirement, [&at, &at], 0.0);
            TimedVerdict::Refused(TimedHit { measure, ..hit })
        }
        verdict => verdict,
    }
}

impl<'c, 'v, 'm> Prover<'c, 'v, 'm> {
    fn new(curve: &'c Curve, validator: &'v mut Validator<'m>, strict: bool) -> Self {
        Self {
            curve,
            reach: reach(validator, curve),
            clearance: validator.floors().common(),
            validator,
            lowered: Vec::new(),
            floors: Floors::default(),
            strict,
            pieces: 0,
            kept: f64::INFINITY,
        }
    }
}

impl Prover<'_, '_, '_> {
    /// All pieces together at floors that are an eighth higher, which is cheap and mostly enough;
    /// `None` where not.
    fn all_at_once(&mut self, stop: &mut dyn FnMut() -> bool) -> Option<TimedVerdict> {
        let most = DEVIATION * self.clearance;
        let chords = self.chords_within(most, stop)?;
        self.set_floors(most);
        let segments = chords
            .iter()
            .map(|[from, to]| [from.as_slice(), to.as_slice()]);
        let validator = &mut *self.validator;
        let mut demand = Demand::proof(&mut self.floors, validator.directions);
        match validator
            .examiner
            .segments(&mut demand, segments, stop)
        {
            SegmentsVerdict::Refused(_) => None,
            SegmentsVerdict::Stopped => Some(TimedVerdict::Stopped),
            SegmentsVerdict::Proved => {
                self.pieces = chords.len() as u64;
                self.kept = self.least_kept() - most;
                Some(self.proved())
            }
        }
    }

    /// The chords of pieces that are halved until none deviates farther than this (m); `None` where they
    /// would be too many, or too narrow.
    fn chords_within(
        &self,
        most: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Vec<[Vec<f64>; 2]>> {
        let mut chords = Vec::new();
        let mut open = self.whole();
        while let Some(piece) = open.pop() {
            if self.deviation(&piece) <= most {
                chords.push(self.chord(&piece));
                continue;
            }
            let are_too_many = chords.len() as u64 + open.len() as u64 > MOST_PIECES;
            if are_too_many || piece.width() < FINEST_S || stop() {
                return None;
            }
            open.extend(piece.halves());
        }
        Some(chords)
    }

    /// The least clearance of the segments that were proved last.
    fn least_kept(&self) -> f64 {
        let proofs = self
            .validator
            .examiner
            .scratch
            .segments
            .proofs
            .iter();
        proofs
            .map(|proof| proof.clearance_m)
            .fold(f64::INFINITY, f64::min)
    }

    /// Piece by piece in the order of time, so that what is refused is refused where it is first.
    fn one_by_one(&mut self, stop: &mut dyn FnMut() -> bool) -> TimedVerdict {
        let mut open = self.whole();
        let mut unprovable = None;
        while let Some(piece) = open.pop() {
            match self.settle(&piece, stop) {
                Settled::Proved => {}
                Settled::Again(pieces) => open.extend(pieces),
                Settled::Collision(touch) => return TimedVerdict::Refused(touch),
                // The first: pieces come in the order of time.
                Settled::Unprovable(seen) => unprovable = unprovable.or(Some(seen)),
                Settled::Stopped => return TimedVerdict::Stopped,
            }
        }
        unprovable.map_or_else(|| self.proved(), TimedVerdict::Refused)
    }

    /// Proves a piece by its chord, or finds what becomes of it.
    fn settle(&mut self, piece: &Piece, stop: &mut dyn FnMut() -> bool) -> Settled {
        if stop() {
            return Settled::Stopped;
        }
        let deviation = self.deviation(piece);
        if deviation > DEVIATION * self.clearance && self.can_be_halved(piece) {
            return Settled::Again(piece.halves().to_vec());
        }
        self.set_floors(deviation);
        let [from, to] = self.chord(piece);
        let validator = &mut *self.validator;
        let mut demand = Demand::proof(&mut self.floors, validator.directions);
        match validator
            .examiner
            .segment(&mut demand, [&from, &to], stop)
        {
            SegmentVerdict::Stopped => Settled::Stopped,
            SegmentVerdict::Proved(SegmentProof { clearance_m, .. }) => {
                self.pieces += 1;
                self.kept = self.kept.min(clearance_m - deviation);
                Settled::Proved
            }
            SegmentVerdict::Refused(hit) => self.refused(piece, &hit, deviation, stop),
        }
    }

    /// What becomes of a piece that is refused as it stands.
    fn refused(
        &mut self,
        piece: &Piece,
        hit: &Hit,
        deviation: f64,
        stop: &mut dyn FnMut() -> bool,
    ) -> Settled {
        let touch = self.touch(piece, hit);
        if touch.is_none()
            && let Some(pieces) = self.again(piece, hit, deviation)
        {
            return Settled::Again(pieces);
        }
        let seen = touch.unwrap_or_else(|| self.refusal(piece, hit));
        let known = Some(&seen).filter(|seen| seen.reason == HitReason::Collision);
        match self.first_collision(piece, known, stop) {
            Some(Some(touch)) => Settled::Collision(touch),
            Some(None) => Settled::Unprovable(seen),
            None => Settled::Stopped,
        }
    }

    /// What may still be provable of a refused piece: its halves, or itself at a lower floor.
    fn again(&mut self, piece: &Piece, hit: &Hit, deviation: f64) -> Option<Vec<Piece>> {
        let is_wide = deviation > DEVIATION * self.floor(hit.requirement);
        if is_wide && self.can_be_halved(piece) {
            return Some(piece.halves().to_vec());
        }
        let is_lowered = !self.strict && self.lower(hit, deviation);
        is_lowered.then(|| vec![*piece])
    }

    fn proved(&self) -> TimedVerdict {
        TimedVerdict::Proved(TimedProof {
            clearance_m: self.kept,
            lowered: self.lowered.clone(),
            pieces: self.pieces,
        })
    }

    /// The pieces between points, the last first.
    fn whole(&self) -> Vec<Piece> {
        whole(self.curve)
    }

    fn can_be_halved(&self, piece: &Piece) -> bool {
        piece.width() > FINEST_S && self.pieces < MOST_PIECES
    }

    /// E (m).
    fn deviation(&self, piece: &Piece) -> f64 {
        self.reach.cost(
            &self
                .curve
                .deviations(piece.point, piece.from, piece.to),
        )
    }

    fn chord(&self, piece: &Piece) -> [Vec<f64>; 2] {
        [piece.from, piece.to].map(|t| self.curve.at(piece.point, t))
    }

    /// The floor of a requirement on the curve.
    fn floor(&self, requirement: Requirement) -> f64 {
        let mut lowered = self.lowered.iter();
        let own = lowered.find(|(lowered, _)| *lowered == requirement);
        own.map_or(self.clearance, |(_, floor)| *floor)
    }

    /// Gives every requirement the floor that it must keep on a chord with this deviation (m).
    fn set_floors(&mut self, deviation: f64) {
        let pairs = self.validator.model().pairs().len();
        self.floors
            .reset(pairs, self.clearance + deviation);
        for &(requirement, floor) in &self.lowered {
            self.floors.set(requirement, floor + deviation);
        }
    }

    /// Lowers the floor of what kept too little on a chord with this deviation.
    fn lower(&mut self, hit: &Hit, deviation: f64) -> bool {
        // On the curve the pair may be nearer than on the chord by as much.
        let amount = hit.measure.amount - deviation;
        let Some(floor) = lowered_floor(self.floor(hit.requirement), amount) else {
            return false;
        };
        self.lowered
            .retain(|(known, _)| *known != hit.requirement);
        self.lowered.push((hit.requirement, floor));
        true
    }
}
