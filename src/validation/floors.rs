//! Distances that pairs must keep: one for almost all, others for a few.
//!
//! A scene of a thousand objects makes ten thousand pairs. Only what was set is ever undone, so
//! that a request that does not come near them does not pay for them.

/// Floors of all pairs of a model.
#[derive(Debug, Default)]
pub(super) struct Floors {
    /// Floor of each pair (m).
    all: Vec<f64>,
    /// Floor of the pairs that are not in `set` (m).
    common: f64,
    highest: f64,
    /// Pairs whose floor was set, and the intervals that each has spent on the segments at hand.
    set: Vec<(usize, u32)>,
}

impl Floors {
    /// The same floor for so many pairs.
    pub(super) fn reset(&mut self, pairs: usize, common: f64) {
        // By bits: what is not the same number anew is written anew.
        if self.common.to_bits() != common.to_bits() {
            self.all.clear();
        }
        self.unset(common);
        self.common = common;
        self.highest = common;
        self.all.resize(pairs, common);
    }

    /// Gives the pairs whose floor was set this one.
    fn unset(&mut self, common: f64) {
        for (pair, _) in self.set.drain(..) {
            if let Some(floor) = self.all.get_mut(pair) {
                *floor = common;
            }
        }
    }

    /// The same as others, each higher by this (m).
    pub(super) fn raise(&mut self, others: &Self, by: f64) {
        self.reset(others.all.len(), others.common + by);
        for (pair, floor) in others.lowered() {
            self.set(pair, floor + by);
        }
    }

    /// Gives one pair another floor.
    pub(super) fn set(&mut self, pair: usize, floor: f64) {
        self.highest = self.highest.max(floor);
        self.all[pair] = floor;
        if self.spent(pair).is_none() {
            self.set.push((pair, 0));
        }
    }

    /// What a pair whose floor was set has spent.
    fn spent(&mut self, pair: usize) -> Option<&mut u32> {
        let mut set = self.set.iter_mut();
        set.find(|(known, _)| *known == pair)
            .map(|(_, spent)| spent)
    }

    /// Floor of each pair (m).
    pub(super) fn all(&self) -> &[f64] {
        &self.all
    }
    /// That of the pairs whose floor was not set (m).
    pub(super) fn common(&self) -> f64 {
        self.common
    }
    /// The highest that any pair has had (m).
    pub(super) fn highest(&self) -> f64 {
        self.highest
    }
    /// Pairs with a floor below that of most, and their floors (m).
    pub(super) fn lowered(&self) -> impl Iterator<Item = (usize, f64)> {
        let lowered = self
            .set
            .iter()
            .map(|(pair, _)| (*pair, self.all[*pair]));
        lowered.filter(|(_, floor)| *floor < self.common)
    }

    /// Forgets what was spent.
    pub(super) fn begin(&mut self) {
        self.set
            .iter_mut()
            .for_each(|(_, spent)| *spent = 0);
    }
    /// Counts an interval against a pair; how many it has spent, 0 for a pair whose floor is not
    /// lowered.
    pub(super) fn spend(&mut self, pair: usize) -> u32 {
        if self.all[pair] >= self.common {
            return 0;
        }
        self.spent(pair).map_or(0, |spent| {
            *spent += 1;
            *spent
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_an_earlier_request_is_left() {
        let mut floors = Floors::default();
        for (pairs, common) in [
            (3, 1e-3),
            (5, 1e-3),
            (2, 1e-3),
            (6, 1e-3),
            (4, 2e-3),
            (4, 1e-3),
        ] {
            floors.reset(pairs, common);
            assert_eq!(
                (floors.all(), floors.highest()),
                (vec![common; pairs].as_slice(), common)
            );
            assert_eq!(floors.lowered().count(), 0);
            floors.set(pairs - 1, common / 4.0);
            floors.set(0, common * 2.0);
            assert_eq!(
                floors.lowered().collect::<Vec<_>>(),
                [(pairs - 1, common / 4.0)]
            );
            assert_eq!((floors.highest(), floors.spend(0)), (common * 2.0, 0));
            assert_eq!([floors.spend(pairs - 1), floors.spend(pairs - 1)], [1, 2]);
            floors.begin();
            assert_eq!(floors.spend(pairs - 1), 1);
        }
    }
}
