//! What is known to hold the path: pairs of bodies at ratios of its segments, and their
//! half-spaces.

use super::active_set::ActiveSet;
use super::cost::Cost;
use super::half_space::HalfSpace;
use super::rows::Row;
use super::task::Task;
use crate::path::Path;
use crate::validation::SegmentRefusal;

/// Distance that half-spaces aim at, in floors: what is 1.5 floors clear is proved for certain.
const AIMED_FLOORS: f64 = 2.0;

/// Looks for the place where a pair is last apart on its way to a refusal.
const RAY_LOOKS: u32 = 6;

/// How far such a look goes towards the place where the pair would touch if it went on as it does.
const TOWARDS_TOUCH: f64 = 0.9;

/// Accepted paths for which a contact that does not push is kept.
const IDLE: u32 = 3;

/// Ratios of a segment this close together are one place.
const SAME_RATIO: f64 = 0.1;

/// A segment is split inside of this range of ratios.
const SPLIT_INSIDE: std::ops::Range<f64> = 0.1..0.9;

/// A pair of bodies at a ratio of a segment.
#[derive(Clone, Copy, Debug)]
struct Contact {
    pair: usize,
    segment: usize,
    ratio: f64,
    /// Accepted paths since it last pushed.
    idle: u32,
    /// The sum of its multipliers when it last pushed.
    push: f64,
}

impl Contact {
    fn is_near(&self, other: &Self) -> bool {
        self.pair == other.pair
            && self.segment == other.segment
            && (self.ratio - other.ratio).abs() < SAME_RATIO
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

/// The contacts of a path, and the half-spaces that they are in an [`ActiveSet`].
pub struct Contacts<'r> {
    task: &'r Task<'r>,
    half_space: HalfSpace<'r>,
    known: Vec<Contact>,
    /// Which contact each half-space is of: row and contact.
    owners: Vec<(usize, usize)>,
    configuration: Vec<f64>,
    ends: [Vec<f64>; 2],
    velocity: Vec<f64>,
    /// d and j where a pair was last seen apart.
    apart: (f64, Vec<f64>),
}

impl<'r> Contacts<'r> {
    /// None is known yet.
    pub fn new(task: &'r Task<'r>) -> Self {
        let row = vec![0.0; task.space.nq()];
        Self {
            task,
            half_space: HalfSpace::new(task.model, task.space, task.held),
            known: Vec::new(),
            owners: Vec::new(),
            ends: [row.clone(), row.clone()],
            configuration: row,
            velocity: vec![0.0; task.space.nv()],
            apart: (0.0, Vec::new()),
        }
    }

    /// Adds the half-spaces `j p ≥ 2δ − d` of all contacts at the path, and starts from those that
    /// pushed last.
    pub fn linearise(&mut self, path: &Path, floors: &[f64], cost: &Cost<'_>, set: &mut ActiveSet) {
        self.known.retain(|contact| contact.idle <= IDLE);
        self.owners.clear();
        for index in 0..self.known.len() {
            self.hold(index, path, floors, cost, set);
        }
        let pushed = self
            .owners
            .iter()
            .filter(|(_, contact)| self.known[*contact].idle == 0);
        set.warm_start(pushed.map(|(row, _)| *row));
    }

    /// Adds the half-space of one contact at the path; its row, where it has one.
    fn hold(
        &mut self,
        index: usize,
        path: &Path,
        floors: &[f64],
        cost: &Cost<'_>,
        set: &mut ActiveSet,
    ) -> Option<usize> {
        let Contact {
            pair,
            segment,
            ratio,
            ..
        } = self.known[index];
        let [from, to] = [segment, segment + 1].map(|waypoint| path.waypoint(waypoint));
        self.task.space.difference(to, from, &mut self.velocity);
        self.task
            .space
            .integrate(from, &self.velocity, ratio, &mut self.configuration);
        let (distance, jacobian) = self.half_space.at(pair, &self.configuration)?;
        let right_hand_side = AIMED_FLOORS * floors[pair] - distance;
        let row = set.push(
            cost,
            Row {
                segment,
                ratio,
                jacobian,
                right_hand_side,
            },
        )?;
        self.owners.push((row, index));
        Some(row)
    }

    /// Adds a half-space for what is refused of a trial: that of the present path where the contact
    /// is new and its half-space excludes the trial, else a cutting plane. Returns the largest part
    /// of p at which the pair was seen apart: at most the trial's.
    pub fn learn(
        &mut self,
        refusal: &SegmentRefusal,
        ray: Ray<'_>,
        floors: &[f64],
        cost: &Cost<'_>,
        set: &mut ActiveSet,
    ) -> f64 {
        let &SegmentRefusal {
            pair, segment, t, ..
        } = refusal;
        let refused = Contact {
            pair,
            segment,
            ratio: t,
            idle: 0,
            push: 0.0,
        };
        let known = self
            .known
            .iter()
            .position(|contact| contact.is_near(&refused));
        let index = known.unwrap_or(self.known.len());
        if known.is_none() {
            self.known.push(refused);
            let held = self
                .hold(index, ray.path, floors, cost, set)
                .map(|row| set.rows().get(row));
            if held.is_some_and(|row| row.of_step(ray.step) < row.right_hand_side) {
                return ray.part;
            }
        }
        let Some(part) = self.last_apart(&refused, ray) else {
            return 0.0;
        };
        let (distance, jacobian) = &self.apart;
        let mut cut = Row {
            segment,
            ratio: t,
            jacobian,
            right_hand_side: 0.0,
        };
        cut.right_hand_side = part * cut.of_step(ray.step) + AIMED_FLOORS * floors[pair] - distance;
        self.owners
            .extend(set.push(cost, cut).map(|row| (row, index)));
        part
    }

    /// The part of p at which the pair is last seen apart on its straight way from x₀ to the trial,
    /// with d and j there; it is looked for by Newton's steps from where it is apart, and by
    /// halving. A half-space from there knows the curvature that the one at x₀ does not.
    fn last_apart(&mut self, refused: &Contact, ray: Ray<'_>) -> Option<f64> {
        let &Contact {
            pair,
            segment,
            ratio,
            ..
        } = refused;
        let mut apart = None;
        let mut touching = ray.part;
        let mut tried = ray.part;
        for _ in 0..RAY_LOOKS {
            self.place(segment, ratio, Ray { part: tried, ..ray });
            let mut next = None;
            match self.half_space.at(pair, &self.configuration) {
                None => touching = tried,
                Some((distance, jacobian)) => {
                    let rate = Row {
                        segment,
                        ratio,
                        jacobian,
                        right_hand_side: 0.0,
                    }
                    .of_step(ray.step);
                    self.apart.0 = distance;
                    self.apart.1.clear();
                    self.apart.1.extend_from_slice(jacobian);
                    apart = Some(tried);
                    if tried == ray.part {
                        break;
                    }
                    let to_touch = -distance / rate;
                    let is_ahead = rate < 0.0
                        && to_touch > 0.1 * (touching - tried)
                        && tried + to_touch < touching;
                    next = is_ahead.then_some(tried + TOWARDS_TOUCH * to_touch);
                }
            }
            tried = next.unwrap_or(0.5 * (apart.unwrap_or(0.0) + touching));
        }
        apart
    }

    /// `configuration` ← the one at a ratio of a segment of the ray's path.
    fn place(&mut self, segment: usize, ratio: f64, ray: Ray<'_>) {
        let space = self.task.space;
        let nv = self.velocity.len();
        for (end, waypoint) in self.ends.iter_mut().zip(segment..) {
            space.integrate(
                ray.path.waypoint(waypoint),
                &ray.step[waypoint * nv..][..nv],
                ray.part,
                end,
            );
        }
        space.difference(&self.ends[1], &self.ends[0], &mut self.velocity);
        space.integrate(
            &self.ends[0],
            &self.velocity,
            ratio,
            &mut self.configuration,
        );
    }

    /// Makes a set that no step satisfies one that some step does: a half-space that asks for more
    /// than the path has is content with what the path has, and one that asks for that is dropped,
    /// so that p = 0 always is a solution. Returns the pair that is pinched, if it was a contact's.
    pub fn give_way(&self, row: usize, set: &mut ActiveSet) -> Option<usize> {
        let asked = set.rows().get(row).right_hand_side;
        set.relax(row, if asked > 0.0 { 0.0 } else { f64::NEG_INFINITY });
        let (_, contact) = self.owners.iter().find(|(owned, _)| *owned == row)?;
        Some(self.known[*contact].pair)
    }

    /// Notes which contacts push.
    pub fn note_pushes(&mut self, set: &ActiveSet) {
        for contact in &mut self.known {
            contact.idle += 1;
        }
        for (row, multiplier) in set.active() {
            if let Some((_, contact)) = self.owners.iter().find(|(owned, _)| *owned == row) {
                let contact = &mut self.known[*contact];
                let others = if contact.idle == 0 { contact.push } else { 0.0 };
                contact.idle = 0;
                contact.push = others + multiplier;
            }
        }
    }

    /// For each segment with contacts that push on its inside, the segment and the ratio of the one
    /// that pushes most, from the last segment to the first.
    pub fn pushed_inside(&self) -> Vec<(usize, f64)> {
        let inside =
            |contact: &&Contact| contact.idle == 0 && SPLIT_INSIDE.contains(&contact.ratio);
        let mut pushed: Vec<&Contact> = self.known.iter().filter(inside).collect();
        pushed.sort_by(|a, b| b.segment.cmp(&a.segment).then(b.push.total_cmp(&a.push)));
        pushed.dedup_by_key(|contact| contact.segment);
        pushed
            .into_iter()
            .map(|contact| (contact.segment, contact.ratio))
            .collect()
    }

    /// Moves the contacts to where they are once a segment is split at a ratio.
    pub fn split(&mut self, segment: usize, ratio: f64) {
        for contact in self
            .known
            .iter_mut()
            .filter(|contact| contact.segment >= segment)
        {
            (contact.segment, contact.ratio) = match contact.segment {
                at if at > segment => (at + 1, contact.ratio),
                at if contact.ratio < ratio => (at, contact.ratio / ratio),
                at => (at + 1, (contact.ratio - ratio) / (1.0 - ratio)),
            };
        }
    }
}
