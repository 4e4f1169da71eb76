//! What is known to hold the path: requirements at ratios of its segments, and their half-spaces.

use super::active_set::ActiveSet;
use super::cost::Cost;
use super::half_space::{HalfSpace, Part};
use super::rows::Row;
use super::task::Task;
use crate::path::Path;
use crate::robot::ConfigurationSpace;
use crate::validation::{Floors, Requirement, SegmentRefusal};

/// What half-spaces aim at, in floors: where 1.5 floors are kept it is proved for certain.
const AIMED_FLOORS: f64 = 2.0;

/// Looks for the place where a requirement is last kept on the way to a refusal.
const RAY_LOOKS: u32 = 6;

/// How far such a look goes towards the place where nothing would be kept if it went on as it does.
const TOWARDS_TOUCH: f64 = 0.9;

/// Accepted paths for which a hold that does not push is kept.
const IDLE: u32 = 3;

/// Ratios of a segment this close together are one place.
const SAME_RATIO: f64 = 0.1;

/// A constraint of which less than this part of its tolerance is left is taken for a hold, ...
const NEAR_PART: f64 = 0.5;

/// ... where it is looked at on every segment.
const SEEDED_RATIOS: [f64; 2] = [0.0, 0.5];

/// A segment is split inside of this range of ratios.
const SPLIT_INSIDE: std::ops::Range<f64> = 0.1..0.9;

/// A requirement at a ratio of a segment.
#[derive(Clone, Copy, Debug)]
struct Place {
    requirement: Requirement,
    /// What of it.
    part: Part,
    segment: usize,
    ratio: f64,
}

impl Place {
    fn of(refusal: &SegmentRefusal) -> Self {
        Self {
            requirement: refusal.requirement,
            part: Part::default(),
            segment: refusal.segment,
            ratio: refusal.t,
        }
    }

    fn is_near(&self, other: &Self) -> bool {
        self.requirement == other.requirement
            && self.part.is_near(&other.part)
            && self.segment == other.segment
            && (self.ratio - other.ratio).abs() < SAME_RATIO
    }

    /// `jacobian p ≥ right_hand_side` here.
    fn row<'j>(&self, jacobian: &'j [f64], right_hand_side: f64) -> Row<'j> {
        Row {
            segment: self.segment,
            ratio: self.ratio,
            jacobian,
            right_hand_side,
        }
    }

    /// The same place once `segment` is split at `ratio`.
    fn split(&mut self, segment: usize, ratio: f64) {
        (self.segment, self.ratio) = match self.segment {
            at if at < segment => return,
            at if at > segment => (at + 1, self.ratio),
            at if self.ratio < ratio => (at, self.ratio / ratio),
            at => (at + 1, (self.ratio - ratio) / (1.0 - ratio)),
        };
    }
}

/// What holds the path at a place, and how much.
#[derive(Clone, Copy, Debug)]
struct Hold {
    place: Place,
    /// Accepted paths since it last pushed.
    idle: u32,
    /// The sum of its multipliers when it last pushed.
    push: f64,
}

impl Hold {
    fn new(place: Place) -> Self {
        Self {
            place,
            idle: 0,
            push: 0.0,
        }
    }

    fn pushes_inside(&self) -> bool {
        self.idle == 0 && SPLIT_INSIDE.contains(&self.place.ratio)
    }

    /// Adds a multiplier to those that it pushed with at this path.
    fn note_push(&mut self, multiplier: f64) {
        let others = if self.idle == 0 { self.push } else { 0.0 };
        self.idle = 0;
        self.push = others + multiplier;
    }
}

/// The quadratic model that half-spaces are added to.
pub struct HeldModel<'m, 'c> {
    /// δ of each requirement.
    pub floors: &'m Floors,
    /// The cost at the path.
    pub cost: &'m Cost<'c>,
    /// The half-spaces.
    pub set: &'m mut ActiveSet,
}

impl HeldModel<'_, '_> {
    fn push(&mut self, row: Row<'_>) -> Option<usize> {
        self.set.push(self.cost, row)
    }

    /// What a half-space aims at.
    fn aim(&self, half_space: &HalfSpace, requirement: Requirement) -> f64 {
        match requirement {
            Requirement::Clearance(_) => AIMED_FLOORS * self.floors.of(requirement),
            Requirement::Constraint(index) => half_space.aim(index),
        }
    }
}

/// How a requirement was seen kept on the way to a trial.
struct Approach {
    kept: f64,
    /// Of what is kept, for each unit of the part of p; negative where it becomes less.
    rate: f64,
}

impl Approach {
    /// Where to look next, on the way from `tried` to `touching`; `None` where Newton's step tells
    /// nothing and halving goes further.
    fn towards_touch(&self, tried: f64, touching: f64) -> Option<f64> {
        let to_touch = -self.kept / self.rate;
        let is_worth_it = to_touch > 0.1 * (touching - tried) && tried + to_touch < touching;
        let is_ahead = self.rate < 0.0 && is_worth_it;
        // Not all the way: it must still be kept there.
        is_ahead.then_some(tried + TOWARDS_TOUCH * to_touch)
    }
}

/// The trial x₀ ⊕ αp, or any other part of p.
#[derive(Clone, Copy)]
pub struct Ray<'p> {
    /// x₀.
    pub path: &'p Path,
    /// p, one row of nv numbers for each waypoint.
    pub step: &'p [f64],
    /// α.
    pub part: f64,
}

/// The holds of a path, and the half-spaces that they are in an [`ActiveSet`].
pub struct Holds<'r> {
    task: &'r Task<'r>,
    half_space: HalfSpace<'r>,
    known: Vec<Hold>,
    /// Which hold each half-space is of: row and hold.
    owners: Vec<(usize, usize)>,
    configuration: Vec<f64>,
    ends: [Vec<f64>; 2],
    velocity: Vec<f64>,
    /// d and j where a requirement was last seen kept.
    apart: (f64, Vec<f64>),
}

/// What is asked instead of what no step does.
fn relaxed(asked: f64) -> f64 {
    if asked > 0.0 { 0.0 } else { f64::NEG_INFINITY }
}

/// `configuration` ← the one at a ratio between two; `velocity` is scratch.
fn stand_between(
    space: &ConfigurationSpace,
    [from, to]: [&[f64]; 2],
    ratio: f64,
    [velocity, configuration]: [&mut Vec<f64>; 2],
) {
    space.difference(to, from, velocity);
    space.integrate(from, velocity, ratio, configuration);
}

impl<'r> Holds<'r> {
    /// None is known yet.
    pub fn new(task: &'r Task<'r>) -> Self {
        let row = vec![0.0; task.space.nq()];
        Self {
            task,
            half_space: HalfSpace::new(task.model, task.space, task.held, &task.constraints),
            known: Vec::new(),
            owners: Vec::new(),
            ends: [row.clone(), row.clone()],
            configuration: row,
            velocity: vec![0.0; task.space.nv()],
            apart: (0.0, Vec::new()),
        }
    }

    /// Adds the half-spaces `j p ≥ 2δ − d` of all holds at the path, and starts from those that
    /// pushed last.
    pub fn linearise(&mut self, path: &Path, model: &mut HeldModel<'_, '_>) {
        self.known.retain(|hold| hold.idle <= IDLE);
        self.owners.clear();
        self.meet_constraints(path);
        for index in 0..self.known.len() {
            self.hold(index, path, model);
        }
        model.set.warm_start(self.pushing());
    }

    /// Makes every constraint a hold that little is left of at a waypoint or in the middle of a segment:
    /// a look is cheap, and most of a path is held that follows one.
    fn meet_constraints(&mut self, path: &Path) {
        for index in 0..self.task.constraints.len() {
            let near = NEAR_PART * self.task.constraints[index].tolerance();
            for segment in 0..path.len() - 1 {
                for ratio in SEEDED_RATIOS {
                    self.meet_constraint(path, (index, near), (segment, ratio));
                }
            }
        }
    }

    fn meet_constraint(
        &mut self,
        path: &Path,
        (index, near): (usize, f64),
        (segment, ratio): (usize, f64),
    ) {
        let requirement = Requirement::Constraint(index);
        let mut place = Place {
            requirement,
            part: Part::default(),
            segment,
            ratio,
        };
        self.move_along(path, place);
        place.part = self
            .half_space
            .part(requirement, &self.configuration);
        let kept = self
            .half_space
            .at(requirement, place.part, &self.configuration);
        let is_near = kept.is_some_and(|(kept, _)| kept < near);
        let mut known = self.known.iter();
        if is_near && !known.any(|hold| hold.place.is_near(&place)) {
            self.known.push(Hold {
                idle: 1,
                ..Hold::new(place)
            });
        }
    }

    /// The rows of the holds that pushed last.
    fn pushing(&self) -> impl Iterator<Item = usize> {
        let owners = self.owners.iter();
        owners
            .filter(|(_, hold)| self.known[*hold].idle == 0)
            .map(|(row, _)| *row)
    }

    /// Adds the half-space of one hold at the path; its row, where it has one.
    fn hold(&mut self, index: usize, path: &Path, model: &mut HeldModel<'_, '_>) -> Option<usize> {
        let place = self.known[index].place;
        self.move_along(path, place);
        let aim = model.aim(&self.half_space, place.requirement);
        let (kept, jacobian) =
            self.half_space
                .at(place.requirement, place.part, &self.configuration)?;
        let right_hand_side = aim - kept;
        let row = model.push(place.row(jacobian, right_hand_side))?;
        self.owners.push((row, index));
        Some(row)
    }

    /// `configuration` ← the one at a place of the path.
    fn move_along(&mut self, path: &Path, place: Place) {
        let ends = [place.segment, place.segment + 1].map(|waypoint| path.waypoint(waypoint));
        let scratch = [&mut self.velocity, &mut self.configuration];
        stand_between(self.task.space, ends, place.ratio, scratch);
    }

    /// Adds a half-space for what is refused of a trial: that of the present path where the hold
    /// is new and its half-space excludes the trial, else a cutting plane. Returns the largest part
    /// of p at which it was seen kept: at most the trial's.
    pub fn learn(
        &mut self,
        refusal: &SegmentRefusal,
        ray: Ray<'_>,
        model: &mut HeldModel<'_, '_>,
    ) -> f64 {
        let place = self.place_of(refusal, ray);
        let mut known = self.known.iter();
        let index = match known.position(|hold| hold.place.is_near(&place)) {
            Some(index) => index,
            None if self.meet(place, ray, model) => return ray.part,
            None => self.known.len() - 1,
        };
        let Some(part) = self.last_apart(place, ray) else {
            return 0.0;
        };
        let row = model.push(self.cut(place, Ray { part, ..ray }, model));
        self.owners.extend(row.map(|row| (row, index)));
        part
    }

    /// Where a trial is refused, and by which side of what.
    fn place_of(&mut self, refusal: &SegmentRefusal, ray: Ray<'_>) -> Place {
        let place = Place::of(refusal);
        self.move_on(place, ray);
        let part = self
            .half_space
            .part(place.requirement, &self.configuration);
        Place { part, ..place }
    }

    /// Makes a hold known; whether its half-space at the path excludes the trial.
    fn meet(&mut self, place: Place, ray: Ray<'_>, model: &mut HeldModel<'_, '_>) -> bool {
        self.known.push(Hold::new(place));
        let held = self.hold(self.known.len() - 1, ray.path, model);
        held.map(|row| model.set.rows().get(row))
            .is_some_and(|row| row.of_step(ray.step) < row.right_hand_side)
    }

    /// The half-space at the part of p where it was last seen kept: linear from there, so that it
    /// is moved by what the step has done until then.
    fn cut(&self, place: Place, ray: Ray<'_>, model: &HeldModel<'_, '_>) -> Row<'_> {
        let (kept, jacobian) = &self.apart;
        let mut cut = place.row(jacobian, 0.0);
        cut.right_hand_side = ray.part * cut.of_step(ray.step)
            + model.aim(&self.half_space, place.requirement)
            - kept;
        cut
    }

    /// The part of p at which it is last seen kept on its straight way from x₀ to the trial,
    /// with d and j there; it is looked for by Newton's steps from where it is kept, and by
    /// halving. A half-space from there knows the curvature that the one at x₀ does not.
    fn last_apart(&mut self, place: Place, ray: Ray<'_>) -> Option<f64> {
        let mut apart = None;
        let mut touching = ray.part;
        let mut tried = ray.part;
        for _ in 0..RAY_LOOKS {
            let mut next = None;
            match self.look(place, Ray { part: tried, ..ray }) {
                None => touching = tried,
                Some(approach) => {
                    apart = Some(tried);
                    if tried == ray.part {
                        break;
                    }
                    next = approach.towards_touch(tried, touching);
                }
            }
            // At x₀ it is kept: that is proved.
            tried = next.unwrap_or(0.5 * (apart.unwrap_or(0.0) + touching));
        }
        apart
    }

    /// Looks at a place of the ray's path; where it is kept there, notes d and j.
    fn look(&mut self, place: Place, ray: Ray<'_>) -> Option<Approach> {
        self.move_on(place, ray);
        let (kept, jacobian) =
            self.half_space
                .at(place.requirement, place.part, &self.configuration)?;
        self.apart.0 = kept;
        self.apart.1.clear();
        self.apart.1.extend_from_slice(jacobian);
        let rate = place.row(jacobian, 0.0).of_step(ray.step);
        Some(Approach { kept, rate })
    }

    /// `configuration` ← the one at a place of the ray's path.
    fn move_on(&mut self, place: Place, ray: Ray<'_>) {
        self.move_ends(place.segment, ray);
        let ends = self.ends.each_ref().map(Vec::as_slice);
        let scratch = [&mut self.velocity, &mut self.configuration];
        stand_between(self.task.space, ends, place.ratio, scratch);
    }

    /// `ends` ← the waypoints of a segment on the ray's path.
    fn move_ends(&mut self, segment: usize, ray: Ray<'_>) {
        let space = self.task.space;
        let nv = self.velocity.len();
        for (end, waypoint) in self.ends.iter_mut().zip(segment..) {
            let step = &ray.step[waypoint * nv..][..nv];
            space.integrate(ray.path.waypoint(waypoint), step, ray.part, end);
        }
    }

    /// Makes a set that no step satisfies one that some step does: a half-space that asks for more
    /// than the path has is content with what the path has, and one that asks for that is dropped,
    /// so that p = 0 always is a solution. Returns what pinches, if it was a hold's.
    pub fn give_way(&self, row: usize, set: &mut ActiveSet) -> Option<Requirement> {
        let asked = set.rows().get(row).right_hand_side;
        set.relax(row, relaxed(asked));
        Some(self.known[self.owner(row)?].place.requirement)
    }

    /// The hold that a row is of; none where it is a limit's.
    fn owner(&self, row: usize) -> Option<usize> {
        let mut owners = self.owners.iter();
        owners
            .find(|(owned, _)| *owned == row)
            .map(|(_, hold)| *hold)
    }

    /// Notes which holds push.
    pub fn note_pushes(&mut self, set: &ActiveSet) {
        self.let_idle();
        for (row, multiplier) in set.active() {
            if let Some(hold) = self.owner(row) {
                self.known[hold].note_push(multiplier);
            }
        }
    }

    /// One more accepted path.
    fn let_idle(&mut self) {
        for hold in &mut self.known {
            hold.idle += 1;
        }
    }

    /// For each segment with holds that push on its inside, the segment and the ratio of the one
    /// that pushes most, from the last segment to the first.
    pub fn pushed_inside(&self) -> Vec<(usize, f64)> {
        let mut pushed: Vec<&Hold> = self
            .known
            .iter()
            .filter(|known| known.pushes_inside())
            .collect();
        pushed.sort_by(|a, b| {
            let from_the_last = b.place.segment.cmp(&a.place.segment);
            from_the_last.then(b.push.total_cmp(&a.push))
        });
        pushed.dedup_by_key(|hold| hold.place.segment);
        let places = pushed.into_iter().map(|hold| hold.place);
        places
            .map(|place| (place.segment, place.ratio))
            .collect()
    }

    /// Moves the holds to where they are once a segment is split at a ratio.
    pub fn split(&mut self, segment: usize, ratio: f64) {
        for hold in &mut self.known {
            hold.place.split(segment, ratio);
        }
    }
}
