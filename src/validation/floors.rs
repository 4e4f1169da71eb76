//! What requirements must keep: one floor for almost all, others for a few.
//!
//! A scene of a thousand objects makes ten thousand pairs. Only what was set is ever undone, so
//! that a request that does not come near them does not pay for them.

use super::requirement::Requirement;

/// Floors of all requirements of a request.
#[derive(Debug, Default)]
pub struct Floors {
    /// Floor of each pair's clearance (m).
    clearances: Vec<f64>,
    /// Floor of the clearances that are not in `set` (m).
    common: f64,
    highest: f64,
    /// Requirements whose floor was set, and the intervals that each has spent on the segments at
    /// hand.
    set: Vec<(Requirement, u32)>,
    /// Floors of the first constraints, none above 0; that of all others is 0: nothing of the tolerance
    /// need be left.
    constraints: Vec<f64>,
}

impl Floors {
    /// The floor of a requirement, in its unit.
    pub fn of(&self, requirement: Requirement) -> f64 {
        match requirement {
            Requirement::Clearance(pair) => self.clearances[pair],
            Requirement::Constraint(index) => self
                .constraints
                .get(index)
                .copied()
                .unwrap_or(0.0),
        }
    }

    /// The same floor for the clearances of so many pairs.
    pub(super) fn reset(&mut self, pairs: usize, common: f64) {
        // By bits: what is not the same number anew is written anew.
        if self.common.to_bits() != common.to_bits() {
            self.clearances.clear();
        }
        self.unset(common);
        self.common = common;
        self.highest = common;
        self.clearances.resize(pairs, common);
    }

    /// Gives the clearances whose floor was set this one.
    fn unset(&mut self, common: f64) {
        self.constraints.clear();
        for (requirement, _) in self.set.drain(..) {
            if let Requirement::Clearance(pair) = requirement
                && let Some(floor) = self.clearances.get_mut(pair)
            {
                *floor = common;
            }
        }
    }

    /// Clearances as others have them, each higher by this (m).
    pub(super) fn raise(&mut self, others: &Self, by: f64) {
        self.reset(others.clearances.len(), others.common + by);
        for (requirement, floor) in others.lowered() {
            if let Requirement::Clearance(_) = requirement {
                self.set(requirement, floor + by);
            }
        }
    }

    /// Gives one requirement another floor.
    pub(super) fn set(&mut self, requirement: Requirement, floor: f64) {
        match requirement {
            Requirement::Clearance(pair) => {
                self.highest = self.highest.max(floor);
                self.clearances[pair] = floor;
            }
            Requirement::Constraint(index) => {
                let count = self.constraints.len().max(index + 1);
                self.constraints.resize(count, 0.0);
                self.constraints[index] = floor;
            }
        }
        if self.spent(requirement).is_none() {
            self.set.push((requirement, 0));
        }
    }

    /// What a requirement whose floor was set has spent.
    fn spent(&mut self, requirement: Requirement) -> Option<&mut u32> {
        let mut set = self.set.iter_mut();
        set.find(|(known, _)| *known == requirement)
            .map(|(_, spent)| spent)
    }

    /// Floor of each pair's clearance (m).
    pub fn clearances(&self) -> &[f64] {
        &self.clearances
    }
    /// That of the clearances whose floor was not set (m).
    pub(super) fn common(&self) -> f64 {
        self.common
    }
    /// The highest that any clearance has had (m).
    pub(super) fn highest(&self) -> f64 {
        self.highest
    }
    /// What a requirement keeps whose floor was not set, in its unit.
    fn usual(&self, requirement: Requirement) -> f64 {
        match requirement {
            Requirement::Clearance(_) => self.common,
            Requirement::Constraint(_) => 0.0,
        }
    }
    /// Requirements with a floor below that of most, and their floors.
    pub fn lowered(&self) -> impl Iterator<Item = (Requirement, f64)> {
        let lowered = self
            .set
            .iter()
            .map(|(requirement, _)| (*requirement, self.of(*requirement)));
        lowered.filter(|(requirement, floor)| *floor < self.usual(*requirement))
    }

    /// Forgets what was spent.
    pub(super) fn begin(&mut self) {
        self.set
            .iter_mut()
            .for_each(|(_, spent)| *spent = 0);
    }
    /// Counts an interval against a requirement; how many it has spent, 0 for one whose floor is not
    /// lowered.
    pub(super) fn spend(&mut self, requirement: Requirement) -> u32 {
        if self.of(requirement) >= self.usual(requirement) {
            return 0;
        }
        self.spent(requirement).map_or(0, |spent| {
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
            let [first, last] = [0, pairs - 1].map(Requirement::Clearance);
            floors.reset(pairs, common);
            assert_eq!(
                (floors.clearances(), floors.highest()),
                (vec![common; pairs].as_slice(), common)
            );
            assert_eq!(floors.lowered().count(), 0);
            floors.set(last, common / 4.0);
            floors.set(first, common * 2.0);
            assert_eq!(floors.lowered().collect::<Vec<_>>(), [(last, common / 4.0)]);
            assert_eq!((floors.highest(), floors.spend(first)), (common * 2.0, 0));
            assert_eq!([floors.spend(last), floors.spend(last)], [1, 2]);
            floors.begin();
            assert_eq!(floors.spend(last), 1);
        }
    }
}
