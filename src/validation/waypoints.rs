//! A look at all waypoints of a path: the filter first, eight at a time, then exactly what it left undecided, nearest
//! first. A path that collides is known as such before anything of it is proved.

use super::continuous::Validator;
use super::interval::IntervalVerdict;
use super::undecided::{Interval, List};
use crate::lanes::LANES;
use crate::path::Path;

/// Waypoints that are looked at together.
const BLOCK: usize = 4096;

/// A waypoint, and a pair that touches or overlaps there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colliding {
    pub(super) waypoint: usize,
    /// Index of the pair in the collision model.
    pub(super) pair: usize,
}

/// What a look at waypoints found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Waypoints {
    /// Surfaces meet at none.
    Free,
    /// The first at which they do.
    Colliding(Colliding),
    /// `stop` said so; with what was found until then, which need not be the first.
    Stopped(Option<Colliding>),
}

/// What the filter did not prove to be apart.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    at: Colliding,
    gap: f32,
}

impl Validator<'_> {
    /// The first waypoint at which surfaces meet. `stop` is asked at every eight, and at every exact look.
    pub(super) fn first_colliding_waypoint(&mut self, path: &Path, stop: &mut dyn FnMut() -> bool) -> Waypoints {
        self.seeking_contact(0.0, |validator| {
            for first in (0..path.len()).step_by(BLOCK) {
                match validator.look_at_waypoints(path, first, stop) {
                    Waypoints::Free => {}
                    found => return found,
                }
            }
            Waypoints::Free
        })
    }

    fn look_at_waypoints(&mut self, path: &Path, first: usize, stop: &mut dyn FnMut() -> bool) -> Waypoints {
        let Some(mut suspects) = self.suspects(path, first, stop) else { return Waypoints::Stopped(None) };
        suspects.sort_by(|a, b| {
            a.gap.total_cmp(&b.gap).then(a.at.waypoint.cmp(&b.at.waypoint)).then(a.at.pair.cmp(&b.at.pair))
        });
        let mut earliest = None;
        for Suspect { at, .. } in suspects {
            let is_before = |known: Colliding| (at.waypoint, at.pair) < (known.waypoint, known.pair);
            if !earliest.is_none_or(is_before) {
                continue;
            }
            let still = Interval { segment: at.waypoint - first, middle: 0.0, half: 0.0, pairs: List::All };
            let verdict = if stop() { IntervalVerdict::Stopped } else { self.look_exactly(&still, at.pair, stop) };
            match verdict {
                IntervalVerdict::Stopped => return Waypoints::Stopped(earliest),
                IntervalVerdict::Collision => earliest = Some(at),
                IntervalVerdict::Proved(_) | IntervalVerdict::TooClose | IntervalVerdict::Split => {}
            }
        }
        earliest.map_or(Waypoints::Free, Waypoints::Colliding)
    }

    fn look_exactly(&mut self, still: &Interval, pair: usize, stop: &mut dyn FnMut() -> bool) -> IntervalVerdict {
        self.place(still);
        self.decide(pair, 0.0, stop)
    }

    /// What the filter does not prove to be apart, at up to a block of waypoints. `None` where stopped.
    fn suspects(&mut self, path: &Path, first: usize, stop: &mut dyn FnMut() -> bool) -> Option<Vec<Suspect>> {
        self.begin();
        let count = (path.len() - first).min(BLOCK);
        for waypoint in path.waypoints().skip(first).take(count) {
            self.add(waypoint, waypoint);
        }
        let mut suspects = Vec::new();
        while !self.scratch.queue.is_empty() {
            if stop() {
                return None;
            }
            let (mut rake, count) = self.next_rake();
            rake[..count].iter_mut().for_each(|still| (still.middle, still.half) = (0.0, 0.0));
            self.filter(&rake[..count]);
            for unproved in &self.scratch.rake.unproved {
                for lane in (0..LANES).filter(|lane| unproved.lanes >> lane & 1 == 1) {
                    let at = Colliding { waypoint: first + rake[lane].segment, pair: unproved.pair as usize };
                    suspects.push(Suspect { at, gap: unproved.gap[lane] });
                }
            }
        }
        Some(suspects)
    }
}
