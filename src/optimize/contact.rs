//! The gradient with contact half-spaces: the string is pulled taut around what holds it.
//!
//! The model is the paper's ([`gradient`](super::gradient)) with two changes. The stiffness of each segment is that
//! of the *present* path, λ = 1/length, so that the cost's gradient is the length's, and the cost bounds the length
//! from above: a step that lowers it shortens the path, and the loop ends at a shortest one. And the rows are
//! half-spaces `j p ≥ 2δ − d` from true closest points ([`HalfSpace`]), made anew at each accepted path and released
//! when they do not push ([`ActiveSet`]).
//!
//! A trial that is refused shows where the half-spaces say too little: another is added there, of the present path
//! where the two bodies are not known yet, of the trial itself where they are (a cutting plane; what the first one
//! misses is the curvature of the contact).

use super::active_set::{ActiveSet, Infeasible};
use super::cost::{Cost, segment_lengths};
use super::half_space::HalfSpace;
use super::limits::Limits;
use super::outcome::{Stage, Termination};
use super::progress::Progress;
use super::rows::Row;
use crate::path::Path;
use crate::validation::{SegmentRefusal, SegmentsVerdict};

/// Distance that half-spaces aim at, in floors: what is 1.5 floors clear is proved for certain.
const AIMED_FLOORS: f64 = 2.0;

/// A segment shorter than this part of the path is no stiffer: neighbours that meet do not lock each other.
const SHORTEST_SEGMENT: f64 = 1e-3;

/// Trials from one path.
const TRIALS: u32 = 24;

/// Part of the step that is tried first, while the half-spaces are not known yet.
const FIRST_PART: f64 = 0.5;

/// The smallest part of a step that is tried.
const SMALLEST_PART: f64 = 0.02;

/// Trials refused in a row before less of the step is tried.
const PATIENCE: u32 = 4;

/// Looks for the place where a pair is last apart on its way to a refusal.
const RAY_LOOKS: u32 = 6;

/// Accepted paths for which a contact that does not push is kept.
const IDLE: u32 = 3;

/// Ratios of a segment this close together are one place.
const SAME_RATIO: f64 = 0.1;

/// A step that shortens the path by less than this part is none.
const SMALL_GAIN: f64 = 2e-4;

/// Without this gain since the last, new waypoints are not worth their cost.
const WORTH_REFINING: f64 = 1e-3;

/// A segment is split inside of this range of ratios.
const SPLIT_INSIDE: std::ops::Range<f64> = 0.1..0.9;

/// No segment shorter than this part of the path is split: micro-segments break the timing of a path.
const SHORTEST_SPLIT: f64 = 0.04;

/// Two bodies that hold the path: a pair at a ratio of a segment.
#[derive(Clone, Copy, Debug)]
struct Place {
    pair: usize,
    segment: usize,
    ratio: f64,
    /// Its half-space of the present path.
    row: Option<usize>,
    /// Accepted paths since it last pushed.
    idle: u32,
    /// Its multiplier when it last pushed.
    push: f64,
}

impl Place {
    /// Whether two places are one as far as a half-space goes.
    fn is_near(&self, other: &Self) -> bool {
        self.pair == other.pair && self.segment == other.segment && (self.ratio - other.ratio).abs() < SAME_RATIO
    }
}

/// What came of the trials from one path.
enum Pulled {
    /// A shorter path, by this part of the length.
    By(f64),
    /// None was found.
    Nothing,
    Ended(Termination),
}

/// Pulls the path taut; returns why that ended.
pub fn optimize(progress: &mut Progress) -> Termination {
    progress.enter(Stage::Contact);
    let mut descent = Descent::new(progress);
    loop {
        let before = descent.progress.length;
        if let Some(termination) = descent.converge() {
            return termination;
        }
        let has_gained = descent.progress.length < before * (1.0 - WORTH_REFINING);
        if !(has_gained && descent.refine()) {
            return Termination::Converged;
        }
    }
}

struct Descent<'s, 'r, 'm> {
    progress: &'s mut Progress<'r, 'm>,
    /// x₀: the best path, perhaps with waypoints more.
    base: Path,
    fixed: Vec<bool>,
    cost: Cost<'r>,
    set: ActiveSet,
    limits: Limits,
    half_space: HalfSpace<'r>,
    places: Vec<Place>,
    /// Part of the step that is tried first.
    part: f64,
    trial: Path,
    gradient: Vec<f64>,
    step: Vec<f64>,
    velocity: Vec<f64>,
    configuration: Vec<f64>,
    ends: [Vec<f64>; 2],
    cutting: Vec<f64>,
    cut_distance: f64,
}

impl<'s, 'r, 'm> Descent<'s, 'r, 'm> {
    fn new(progress: &'s mut Progress<'r, 'm>) -> Self {
        let task = progress.task;
        let (base, fixed) = (progress.path.clone(), progress.fixed.clone());
        let size = base.len() * task.space.nv();
        Self {
            cost: Cost::new(task.space, task.metric, base.as_flat(), &fixed, task.moving),
            set: ActiveSet::new(task.space.nv()),
            limits: Limits::new(task, &fixed),
            half_space: HalfSpace::new(task.model, task.space, task.held),
            places: Vec::new(),
            part: FIRST_PART,
            trial: base.clone(),
            gradient: vec![0.0; size],
            step: vec![0.0; size],
            velocity: vec![0.0; task.space.nv()],
            configuration: vec![0.0; task.space.nq()],
            ends: [vec![0.0; task.space.nq()], vec![0.0; task.space.nq()]],
            cutting: Vec::new(),
            cut_distance: 0.0,
            base,
            fixed,
            progress,
        }
    }

    /// The model of the present path: cost, gradient and the half-spaces of all places known.
    fn linearise(&mut self) {
        let task = self.progress.task;
        let rows = self.base.as_flat();
        self.cost = Cost::with_shortest(task.space, task.metric, rows, &self.fixed, task.moving, SHORTEST_SEGMENT);
        self.cost.gradient(rows, &mut self.velocity, &mut self.gradient);
        self.set.begin(&self.cost, &self.gradient);
        self.limits.release();
        self.places.retain(|place| place.idle <= IDLE);
        for index in 0..self.places.len() {
            self.places[index].row = self.hold(self.places[index]);
        }
        let pushed = self.places.iter().filter(|place| place.idle == 0);
        self.set.warm_start(pushed.filter_map(|place| place.row));
    }

    /// Adds the half-space of a place of the present path.
    fn hold(&mut self, place: Place) -> Option<usize> {
        self.interpolate(place.segment, place.ratio);
        let floor = self.progress.validator.floors()[place.pair];
        let (distance, jacobian) = self.half_space.at(place.pair, &self.configuration)?;
        let right_hand_side = AIMED_FLOORS * floor - distance;
        let row = Row { segment: place.segment, ratio: place.ratio, jacobian, right_hand_side };
        self.set.push(&self.cost, row)
    }

    /// `configuration` ← the one at a ratio of a segment of x₀.
    fn interpolate(&mut self, segment: usize, ratio: f64) {
        let path = &self.base;
        let space = self.progress.task.space;
        let (from, to) = (path.waypoint(segment), path.waypoint((segment + 1).min(path.len() - 1)));
        space.difference(to, from, &mut self.velocity);
        space.integrate(from, &self.velocity, ratio, &mut self.configuration);
    }

    /// Pulls until nothing is gained any more; says why the run must end, if it must.
    fn converge(&mut self) -> Option<Termination> {
        let mut small = 0;
        while small < 2 {
            match self.pull() {
                Pulled::Ended(termination) => return Some(termination),
                Pulled::By(gain) if gain >= SMALL_GAIN => small = 0,
                Pulled::By(_) => small += 1,
                Pulled::Nothing => small += 2,
            }
        }
        None
    }

    /// Tries steps from the present path until one is shorter and proved.
    fn pull(&mut self) -> Pulled {
        self.linearise();
        self.update_step();
        let mut part = self.part;
        for trial in 1..=TRIALS {
            if let Some(termination) = self.progress.must_end() {
                return Pulled::Ended(termination);
            }
            self.progress.iterations += 1;
            let length = self.move_trial(part);
            if !self.progress.is_shorter(length) {
                if part < SMALLEST_PART {
                    break;
                }
                part *= 0.5;
                continue;
            }
            match self.progress.prove(self.trial.as_flat()) {
                SegmentsVerdict::Stopped => return Pulled::Ended(Termination::Stopped),
                SegmentsVerdict::Proved => {
                    let gain = 1.0 - length / self.progress.length;
                    self.accept(length);
                    self.part = (2.0 * part).min(1.0);
                    return Pulled::By(gain);
                }
                SegmentsVerdict::Refused(_) => {
                    let reach = self.learn(part);
                    if trial % PATIENCE == 0 {
                        part = (0.95 * reach).clamp(0.25 * part, 0.9 * part);
                    } else {
                        self.update_step();
                    }
                }
            }
        }
        self.part = (0.5 * self.part).max(SMALLEST_PART);
        Pulled::Nothing
    }

    /// p ← the minimum of the model under half-spaces and limits.
    fn update_step(&mut self) {
        loop {
            while let Err(Infeasible { row }) = self.set.solve() {
                // What asks for more than the path has is content with what it has; x₀ itself is then a solution.
                let asked = self.set.rows().get(row).right_hand_side;
                self.set.relax(row, if asked > 0.0 { 0.0 } else { f64::NEG_INFINITY });
            }
            self.set.step(&self.cost, &mut self.step);
            if !self.limits.push_left(&mut self.set, &self.cost, self.base.as_flat(), &self.step) {
                return;
            }
        }
    }

    /// x₁ ← x₀ ⊕ αp; returns its length.
    fn move_trial(&mut self, part: f64) -> f64 {
        let task = self.progress.task;
        let part = part.min(self.limits.largest_part(self.base.as_flat(), &self.step));
        task.displace(&self.base, &self.fixed, &self.step, part, &mut self.trial);
        self.limits.settle(&self.base, &mut self.trial);
        task.length(self.trial.as_flat(), &mut self.velocity)
    }

    /// Adds a half-space for what is refused of the trial x₀ ⊕ αp; returns the largest part of p at which that pair
    /// was not seen to touch yet.
    fn learn(&mut self, part: f64) -> f64 {
        let Some(SegmentRefusal { pair, segment, t, .. }) = self.progress.validator.refusal() else { return part };
        let refused = Place { pair, segment, ratio: t, row: None, idle: 0, push: 0.0 };
        if !self.places.iter().any(|place| place.is_near(&refused)) {
            let row = self.hold(refused);
            self.places.push(Place { row, ..refused });
            if let Some(row) = row {
                let held = self.set.rows().get(row);
                if held.of_step(&self.step) < held.right_hand_side {
                    return part;
                }
            }
        }
        self.cut(&refused, part)
    }

    /// Adds a cutting plane where the pair, moving straight from x₀ towards the refused trial, is last seen apart.
    fn cut(&mut self, refused: &Place, part: f64) -> f64 {
        let &Place { pair, segment, ratio, .. } = refused;
        let (mut apart, mut refused_at) = (0.0, part);
        let mut tried = part;
        for _ in 0..RAY_LOOKS {
            self.place_on_ray(segment, ratio, tried);
            match self.half_space.at(pair, &self.configuration) {
                None => refused_at = tried,
                Some((distance, jacobian)) => {
                    apart = tried;
                    self.cutting.clear();
                    self.cutting.extend_from_slice(jacobian);
                    self.cut_distance = distance;
                    if tried == part {
                        break;
                    }
                    let row = Row { segment, ratio, jacobian: &self.cutting, right_hand_side: 0.0 };
                    let rate = row.of_step(&self.step);
                    let reached = apart - distance / rate;
                    if rate < 0.0 && reached < refused_at && reached - apart > 0.1 * (refused_at - apart) {
                        tried = 0.1 * apart + 0.9 * reached;
                        continue;
                    }
                }
            }
            tried = 0.5 * (apart + refused_at);
        }
        if apart == 0.0 {
            return 0.0;
        }
        let floor = self.progress.validator.floors()[pair];
        let mut cut = Row { segment, ratio, jacobian: &self.cutting, right_hand_side: 0.0 };
        cut.right_hand_side = apart * cut.of_step(&self.step) + AIMED_FLOORS * floor - self.cut_distance;
        self.set.push(&self.cost, cut);
        apart
    }

    /// `configuration` ← the one at a ratio of a segment of x₀ ⊕ αp.
    fn place_on_ray(&mut self, segment: usize, ratio: f64, part: f64) {
        let (space, nv) = (self.progress.task.space, self.velocity.len());
        for side in 0..2 {
            let waypoint = (segment + side).min(self.base.len() - 1);
            let step = &self.step[waypoint * nv..(waypoint + 1) * nv];
            space.integrate(self.base.waypoint(waypoint), step, part, &mut self.ends[side]);
        }
        space.difference(&self.ends[1], &self.ends[0], &mut self.velocity);
        space.integrate(&self.ends[0], &self.velocity, ratio, &mut self.configuration);
    }

    fn accept(&mut self, length: f64) {
        for place in &mut self.places {
            let multiplier = place.row.and_then(|row| self.set.active().find(|(active, _)| *active == row));
            match multiplier {
                Some((_, multiplier)) => (place.idle, place.push) = (0, multiplier),
                None => place.idle += 1,
            }
        }
        std::mem::swap(&mut self.base, &mut self.trial);
        self.progress.adopt(&self.base, &self.fixed, length);
    }

    /// Splits each segment at the place inside of it that is pushed most, so that the path can bend there; false
    /// where there is none.
    fn refine(&mut self) -> bool {
        let mut splits: Vec<Place> = Vec::new();
        for place in self.places.iter().filter(|place| place.idle == 0 && SPLIT_INSIDE.contains(&place.ratio)) {
            match splits.iter_mut().find(|split| split.segment == place.segment) {
                Some(split) if split.push < place.push => *split = *place,
                Some(_) => {}
                None => splits.push(*place),
            }
        }
        let task = self.progress.task;
        let lengths = segment_lengths(task.space, task.metric, self.base.as_flat());
        splits.retain(|split| lengths[split.segment] > SHORTEST_SPLIT * self.progress.length);
        splits.sort_by_key(|split| std::cmp::Reverse(split.segment));
        for split in &splits {
            self.split(split.segment, split.ratio);
        }
        self.fit();
        !splits.is_empty()
    }

    /// A new waypoint at a ratio of a segment; the places move along.
    fn split(&mut self, segment: usize, ratio: f64) {
        self.interpolate(segment, ratio);
        self.base.splice(segment + 1..segment + 1, &self.configuration);
        self.fixed.insert(segment + 1, false);
        for place in &mut self.places {
            if place.segment > segment {
                place.segment += 1;
            } else if place.segment == segment && place.ratio < ratio {
                place.ratio /= ratio;
            } else if place.segment == segment {
                (place.segment, place.ratio) = (segment + 1, (place.ratio - ratio) / (1.0 - ratio));
            }
        }
    }

    /// Makes room for the waypoints that there are.
    fn fit(&mut self) {
        let task = self.progress.task;
        let size = self.base.len() * task.space.nv();
        self.trial.clone_from(&self.base);
        self.gradient.resize(size, 0.0);
        self.step.resize(size, 0.0);
        self.limits = Limits::new(task, &self.fixed);
    }
}
