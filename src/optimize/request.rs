//! One request from end to end: check, prove the input, optimize, prove the answer.

use std::f64::consts::TAU;

use super::input::{Input, RequestError, lower_bound};
use super::mode::Mode;
use super::nearest;
use super::outcome::{
    LoweredFloor, Outcome, Refusal, RefusalPlace, Stage, StageShare, Termination,
};
use super::progress::Progress;
use super::settings::Settings;
use super::task::{Improvement, Task};
use crate::collision::{CollisionModel, reach_weights};
use crate::path::Path;
use crate::robot::Kinematics;
use crate::robot::configuration::turns_between;
use crate::validation::certificate::Terms;
use crate::validation::path_proof::{self, PathVerdict};
use crate::validation::{
    Certificate, Contact, Corridor, Hit, HitReason, Nearest, Scratch, SegmentProof, Validator,
};

/// Reusable memory of a worker; every request starts from the same state whatever ran before.
#[derive(Debug, Default)]
pub struct Workspace {
    scratch: Scratch,
    kinematics: Kinematics,
}

/// Work that a request gets which names no budget.
pub const DEFAULT_WORK_BUDGET: u64 = 200_000_000;

/// Runs a request.
///
/// `stop` is asked often and ends the run with the best path so far; `publish` gets every strictly
/// shorter proved path as it is found, each with the ends of the input, bit for bit. Same model,
/// path and settings give the same answer, bit for bit, as long as `stop` keeps still.
///
/// # Errors
/// A request that cannot be computed as it stands. A path that collides is no error but an answer.
pub fn run(
    model: &CollisionModel,
    path: &Path,
    settings: &Settings,
    workspace: &mut Workspace,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> Result<Outcome, RequestError> {
    let robot = model.robot();
    let input = Input::new(robot, path, settings, &reach_weights(robot, model.bodies()))?;
    workspace
        .kinematics
        .update(robot, path.waypoint(0), &input.held);
    if let Some((bodies, contact)) = model.static_contact(&workspace.kinematics) {
        let refusal = standing_overlap(bodies, contact);
        return Ok(Answer {
            refusal: Some(refusal),
            ..Answer::unproved(&input.path)
        }
        .into_outcome(model, path, settings, &input));
    }
    let validator = Validator::new(
        model,
        &input.space,
        &input.held,
        settings.clearance_m,
        &mut workspace.scratch,
    );
    let mut validator = validator.with_layers(settings.layers);
    let answer = match model.uncheckable() {
        None => answer(&mut validator, path, settings, &input, stop, publish),
        Some(_) => {
            let checked = Settings {
                mode: Mode::Check,
                contacts: false,
                ..settings.clone()
            };
            answer(&mut validator, path, &checked, &input, stop, publish).unproved_still()
        }
    };
    Ok(answer.into_outcome(model, path, settings, &input))
}

/// What was found, in the form that optimizers work on.
struct Answer {
    path: Path,
    proofs: Option<Vec<SegmentProof>>,
    refusal: Option<Refusal>,
    /// Pairs with a lowered floor, and their floors (m).
    lowered: Vec<(usize, f64)>,
    nearest: Option<Nearest>,
    iterations: u64,
    work: u64,
    stage: Stage,
    stages: Vec<StageShare>,
    pinched: Vec<usize>,
    termination: Termination,
}

impl Answer {
    fn unproved(path: &Path) -> Self {
        Self {
            path: path.clone(),
            proofs: None,
            refusal: None,
            lowered: Vec::new(),
            nearest: None,
            iterations: 0,
            work: 0,
            stage: Stage::Input,
            stages: Vec::new(),
            pinched: Vec::new(),
            termination: Termination::Done,
        }
    }

    /// The same without what was proved, which says nothing of a robot without geometry; a
    /// collision stays one.
    fn unproved_still(self) -> Self {
        let refusal = self
            .refusal
            .filter(|refusal| refusal.reason == HitReason::Collision);
        Self {
            proofs: None,
            refusal,
            lowered: Vec::new(),
            termination: Termination::Done,
            ..self
        }
    }
}

fn answer(
    validator: &mut Validator,
    path: &Path,
    settings: &Settings,
    input: &Input,
    stop: &mut dyn FnMut() -> bool,
    publish: &mut dyn FnMut(Improvement),
) -> Answer {
    let mut answer = Answer::unproved(&input.path);
    let mut restored = Restorer::new(path, input);
    let mut publish = |improvement: Improvement| restored.publish(&improvement, publish);
    match path_proof::prove_input(validator, &input.path, !settings.strict, stop) {
        PathVerdict::Stopped => answer.termination = Termination::Stopped,
        PathVerdict::Proved(proofs) => {
            answer.optimize(validator, settings, input, true, stop, &mut publish);
            // Asked again of the validator, which remembers what it proved: the certificate gets
            // its claims, and an answer never rests on an optimizer's bookkeeping.
            answer.proofs = if answer.path == input.path {
                Some(proofs)
            } else {
                proved(validator, &answer.path)
            };
            assert!(
                answer.proofs.is_some(),
                "an optimizer returned a path that the validator does not prove"
            );
        }
        PathVerdict::Refused {
            segment,
            hit,
            proved_prefix,
        } => {
            answer.refusal = Some(refusal(validator, input, segment, &hit, proved_prefix));
            if hit.reason != HitReason::Collision
                && !settings.strict
                && settings.mode != Mode::Check
            {
                // Not provable, but nowhere found colliding: optimized all the same. The result
                // counts only if all of it is proved.
                answer.optimize(validator, settings, input, false, stop, &mut publish);
                answer.proofs = proved(validator, &answer.path);
                match answer.proofs {
                    Some(_) => answer.refusal = None,
                    None => answer.path = input.path.clone(),
                }
            }
        }
    }
    answer.lowered = validator.lowered().collect();
    answer.lowered.sort_by_key(|(pair, _)| *pair);
    answer.work = validator.work();
    if answer.proofs.is_some() && settings.contacts {
        answer.nearest = validator.nearest(&answer.path, stop);
    }
    if settings.corridor
        && let Some(proofs) = &mut answer.proofs
    {
        validator.widen(&answer.path, proofs, stop);
    }
    answer
}

fn proved(validator: &mut Validator, path: &Path) -> Option<Vec<SegmentProof>> {
    match path_proof::prove(validator, path, &mut || false) {
        PathVerdict::Proved(proofs) => Some(proofs),
        _ => None,
    }
}

impl Answer {
    fn optimize(
        &mut self,
        validator: &mut Validator,
        settings: &Settings,
        input: &Input,
        is_proved: bool,
        stop: &mut dyn FnMut() -> bool,
        publish: &mut dyn FnMut(Improvement),
    ) {
        let budget = if settings.work_budget == 0 {
            DEFAULT_WORK_BUDGET
        } else {
            settings.work_budget
        };
        let task = Task {
            model: validator.model(),
            space: &input.space,
            metric: &input.metric,
            held: &input.held,
            fixed: &input.fixed,
            fixed_rows: &input.fixed_rows,
            moving: &input.moving,
            keep_goal: settings.keep_goal,
            seed: settings.seed,
            work_budget: validator.work().saturating_add(budget),
        };
        let Some(optimizer) = settings.mode.optimizer() else {
            return;
        };
        let mut progress = Progress::new(
            &task,
            self.path.clone(),
            is_proved,
            validator,
            stop,
            publish,
        );
        self.termination = optimizer(&mut progress);
        self.iterations = progress.iterations;
        self.stage = progress.found_by;
        self.stages = progress.shares();
        self.pinched = std::mem::take(&mut progress.pinched);
        self.pinched.sort_unstable();
        self.pinched.dedup();
        self.path = progress.path;
    }

    fn into_outcome(
        self,
        model: &CollisionModel,
        path: &Path,
        settings: &Settings,
        input: &Input,
    ) -> Outcome {
        let mut scratch = vec![0.0; input.space.nv()];
        let mut length = |path: &Path| {
            input
                .metric
                .length(&input.space, path.as_flat(), &mut scratch)
        };
        let length_before = length(&input.path);
        // Without a waypoint on a straight line the sum may be rounded up.
        let length_after = length(&self.path).min(length_before);
        // Angles far out are rounded by more than the two may differ.
        let lower_bound =
            lower_bound(&input.space, &input.metric, path, input.keep_goal).min(length_after);
        let is_unchanged = self.path == input.path;
        let output = if is_unchanged {
            input.given(path).clone()
        } else {
            Restorer::new(path, input).restore(&self.path).clone()
        };
        let lowered = self.lowered.iter();
        let floors_lowered: Vec<_> = lowered
            .map(|&(pair, floor_m)| LoweredFloor {
                bodies: model.pair_names(pair),
                floor_m,
            })
            .collect();
        let caller_segments = if is_unchanged {
            nearest::segments_of(&input.standing_for)
        } else {
            Vec::new()
        };
        let nearest = self
            .nearest
            .map(|nearest| nearest::named(model, &nearest, &caller_segments));
        let named = |lowered: &LoweredFloor| {
            let [a, b] = lowered.bodies.clone();
            (a, b, lowered.floor_m)
        };
        let certificate = self.proofs.map(|proofs| {
            let terms = Terms {
                clearance_m: settings.clearance_m,
                lowered: floors_lowered.iter().map(named).collect(),
                unwrapped: settings.unwrapped,
                held: settings.held.clone(),
            };
            let proofs = if is_unchanged {
                spread(&proofs, &input.standing_for)
            } else {
                proofs
            };
            Certificate::new(model, &output, terms, &proofs)
        });
        let asked = certificate.as_ref().filter(|_| settings.corridor);
        let corridor = asked.map(|certificate| Corridor::new(model, &output, certificate));
        Outcome {
            turned: input.turned(model.robot(), path, &output),
            path: output,
            proved: certificate.is_some(),
            uncheckable: model.uncheckable().filter(|_| self.refusal.is_none()),
            pairs: model.checked_pairs(),
            refusal: self.refusal,
            length_before,
            length_after,
            lower_bound,
            weights: input.metric.weights().to_vec(),
            clearance_m: settings.clearance_m,
            floor_m: floors_lowered
                .iter()
                .map(|lowered| lowered.floor_m)
                .fold(settings.clearance_m, f64::min),
            floors_lowered,
            nearest,
            pinched: self
                .pinched
                .iter()
                .map(|&pair| model.pair_names(pair))
                .collect(),
            iterations: self.iterations,
            work: self.work,
            stage: if is_unchanged {
                Stage::Input
            } else {
                self.stage
            },
            stages: self.stages,
            termination: self.termination,
            warnings: [model.uncovered(), input.warnings.clone()].concat(),
            corridor,
            certificate,
        }
    }
}

/// Proofs of the caller's segments: one between equal waypoints keeps what the segment beside it
/// keeps.
fn spread(proofs: &[SegmentProof], standing_for: &[usize]) -> Vec<SegmentProof> {
    let of_segment = |ends: &[usize]| match proofs[ends[0].min(proofs.len() - 1)] {
        proof if ends[0] < ends[1] => proof,
        proof => SegmentProof {
            intervals: 0,
            ..proof
        },
    };
    if standing_for.len() < 2 {
        proofs.to_vec()
    } else {
        standing_for.windows(2).map(of_segment).collect()
    }
}

/// Gives waypoints that must stay as they were the caller's bits back: the optimizers' form of a
/// row may differ by the norm of a quaternion. Angles keep the numbers that were proved, which may
/// be whole turns away.
struct Restorer {
    /// The optimizers' form of each fixed waypoint and the caller's, in order.
    rows: Vec<(Vec<f64>, Vec<f64>)>,
    circles: Vec<usize>,
    buffer: Path,
}

impl Restorer {
    fn new(path: &Path, input: &Input) -> Self {
        let originals = input
            .origins
            .iter()
            .map(|&origin| path.waypoint(origin).to_vec());
        let pairs = input
            .path
            .waypoints()
            .map(<[f64]>::to_vec)
            .zip(originals)
            .zip(&input.fixed);
        let rows = pairs
            .filter(|(_, fixed)| **fixed)
            .map(|(pair, _)| pair)
            .collect();
        Self {
            rows,
            circles: input.space.circles().collect(),
            buffer: input.path.clone(),
        }
    }

    fn restore(&mut self, path: &Path) -> &Path {
        self.buffer.clone_from(path);
        let mut fixed = self.rows.iter();
        let mut next = fixed.next();
        for index in 0..path.len() {
            // The last row is the last fixed one even where an earlier row equals it.
            if let Some((row, original)) = next
                && self.is_same_place(path.waypoint(index), row, original)
            {
                let restored = self.buffer.waypoint_mut(index);
                restored.copy_from_slice(original);
                for &q in &self.circles {
                    restored[q] = path.waypoint(index)[q];
                }
                next = fixed.next();
            }
        }
        &self.buffer
    }

    /// Whether a path's row is this fixed one, but for whole turns of the caller's angles.
    fn is_same_place(&self, at: &[f64], row: &[f64], original: &[f64]) -> bool {
        let is_same = |q: usize| match self.circles.contains(&q) {
            true => at[q] == original[q] + turns_between(original[q], at[q]) as f64 * TAU,
            false => at[q] == row[q],
        };
        (0..at.len()).all(is_same)
    }

    fn publish(&mut self, improvement: &Improvement, publish: &mut dyn FnMut(Improvement)) {
        publish(Improvement {
            path: self.restore(improvement.path),
            ..*improvement
        });
    }
}

fn refusal(
    validator: &mut Validator,
    input: &Input,
    segment: usize,
    hit: &Hit,
    proved_prefix: f64,
) -> Refusal {
    let model = validator.model();
    let path = &input.path;
    let start = path.waypoint(0);
    let goal = path.waypoint(path.len() - 1);
    let is_on_last_segment = segment + 2 >= path.len();
    let place = if hit.reason != HitReason::Collision {
        RefusalPlace::Between
    } else if validator.touches(hit.pair, start) {
        RefusalPlace::Start
    } else if validator.touches(hit.pair, goal) || (is_on_last_segment && validator.collides(goal))
    {
        RefusalPlace::Goal
    } else {
        RefusalPlace::Between
    };
    let from = path.waypoint(segment);
    let to = path.waypoint((segment + 1).min(path.len() - 1));
    let contact = match hit.reason {
        HitReason::Collision => validator.penetration(hit.pair, from, to, hit.t),
        HitReason::TooClose | HitReason::Uncertified => hit.contact,
    };
    let segments = nearest::segments_of(&input.standing_for);
    let callers = |segment: usize, t: f64| match (segment, t) {
        // Nothing is proved, not even that the robot may stand where it starts.
        (0, 0.0) => 0,
        _ => segments
            .get(segment)
            .copied()
            .unwrap_or(input.standing_for.len() - 1),
    };
    let proved_segments = proved_prefix.floor();
    let proved_t = proved_prefix - proved_segments;
    Refusal {
        reason: hit.reason,
        place,
        segment: callers(segment, hit.t),
        t: hit.t,
        bodies: model.pair_names(hit.pair),
        points: [contact.point_a, contact.point_b],
        normal: contact.normal,
        depth_m: -contact.distance,
        proved_prefix: callers(proved_segments as usize, proved_t) as f64 + proved_t,
        hint: String::new(),
    }
}

/// A link that no joint moves stands in an obstacle.
fn standing_overlap(bodies: [String; 2], contact: Contact) -> Refusal {
    let [link, object] = &bodies;
    let hint = format!(
        "no joint moves {link}; if it may touch {object}, add [\"{link}\", \"{object}\"] to allowed_collisions"
    );
    Refusal {
        reason: HitReason::Collision,
        place: RefusalPlace::Start,
        segment: 0,
        t: 0.0,
        points: [contact.point_a, contact.point_b],
        normal: contact.normal,
        depth_m: -contact.distance,
        proved_prefix: 0.0,
        hint,
        bodies,
    }
}
