//! A look at the waypoints of a path, which says early that the path collides: the filter at all of
//! them, eight at a time, then the exact bodies of each pair where the filter saw it nearest. What
//! it finds is a collision, if not the first; what it does not find, the proof does.

use super::continuous::Validator;
use super::interval::IntervalVerdict;
use super::undecided::{Interval, List};
use crate::lanes::LANES;
use crate::path::Path;

/// A waypoint, and a pair that touches or overlaps there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colliding {
    pub(super) waypoint: usize,
    /// Index of the pair in the collision model.
    pub(super) pair: usize,
}

/// What the filter did not prove to be apart.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    at: Colliding,
    gap: f32,
}

impl Validator<'_> {
    /// Whether any two bodies' surfaces meet at one configuration.
    pub fn collides(&mut self, configuration: &[f64]) -> bool {
        let path = Path::from_rows(configuration.len(), configuration.to_vec());
        let look = |path: &Path| self.colliding_waypoint(path, std::iter::once(0), &mut || false);
        path.as_ref().and_then(look).flatten().is_some()
    }

    /// The first of the collisions that a look at these waypoints finds. `stop` is asked at every
    /// eight, and at every exact look; `None` where it said so before any was found.
    pub(super) fn colliding_waypoint(
        &mut self,
        path: &Path,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Colliding>> {
        self.seeking_contact(0.0, |validator| {
            validator.look_at_waypoints(path, waypoints, stop)
        })
    }

    fn look_at_waypoints(
        &mut self,
        path: &Path,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Option<Colliding>> {
        let mut suspects = self.suspects(path, waypoints, stop)?;
        suspects.sort_by(|a, b| a.gap.total_cmp(&b.gap).then(a.at.pair.cmp(&b.at.pair)));
        let mut first: Option<Colliding> = None;
        for Suspect { at, .. } in suspects {
            if first.is_some_and(|first| first.waypoint <= at.waypoint) {
                continue;
            }
            match if stop() {
                IntervalVerdict::Stopped
            } else {
                self.look_exactly(path, at, stop)
            } {
                IntervalVerdict::Stopped => return first.map(Some),
                IntervalVerdict::Collision => first = Some(at),
                IntervalVerdict::Proved(_) | IntervalVerdict::TooClose | IntervalVerdict::Split => {
                }
            }
        }
        Some(first)
    }

    fn look_exactly(
        &mut self,
        path: &Path,
        at: Colliding,
        stop: &mut dyn FnMut() -> bool,
    ) -> IntervalVerdict {
        let waypoint = path.waypoint(at.waypoint);
        self.begin();
        self.add(waypoint, waypoint);
        self.place(&Interval {
            segment: 0,
            middle: 0.0,
            half: 0.0,
            pairs: List::All,
        });
        self.decide(at.pair, 0.0, stop)
    }

    /// For each pair that the filter does not prove to be apart everywhere, the waypoint where it
    /// sees it nearest. `None` where stopped.
    fn suspects(
        &mut self,
        path: &Path,
        waypoints: impl Iterator<Item = usize>,
        stop: &mut dyn FnMut() -> bool,
    ) -> Option<Vec<Suspect>> {
        let mut nearest: Vec<Option<Suspect>> = vec![None; self.model.pairs().len()];
        let mut waypoints = waypoints.peekable();
        while waypoints.peek().is_some() {
            if stop() {
                return None;
            }
            let mut numbers = [0; LANES];
            let mut batch = [Interval::default(); LANES];
            let mut count = 0;
            self.begin();
            for number in waypoints.by_ref().take(LANES) {
                self.add(path.waypoint(number), path.waypoint(number));
                (numbers[count], batch[count].segment) = (number, count);
                count += 1;
            }
            self.filter(&batch[..count]);
            for unproved in &self.scratch.filter.unproved {
                let known = &mut nearest[unproved.pair as usize];
                for lane in (0..LANES).filter(|lane| unproved.lanes >> lane & 1 == 1) {
                    let gap = unproved.gap[lane];
                    if known.is_none_or(|known| gap < known.gap) {
                        let at = Colliding {
                            waypoint: numbers[lane],
                            pair: unproved.pair as usize,
                        };
                        *known = Some(Suspect { at, gap });
                    }
                }
            }
        }
        Some(nearest.into_iter().flatten().collect())
    }
}
