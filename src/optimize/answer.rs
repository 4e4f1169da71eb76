//! What came of a request, from the form that optimizers work on to the caller's.

use super::input::lower_bound;
use super::nearest;
use super::outcome::{
    KeptConstraint, NearestHolds, Outcome, Refusal, Stage, StageShare, Termination,
};
use super::progress::Progress;
use super::question::Question;
use super::restorer::Restorer;
use crate::path::Path;
use crate::validation::certificate::Terms;
use crate::validation::{
    Certificate, ConstraintClaims, Corridor, HitReason, Kept, LoweredFloor, NamedRequirement,
    Nearest, Requirement, RequirementKind, SegmentProof, Validator,
};

/// What was found, in the form that optimizers work on.
pub(super) struct Answer {
    pub path: Path,
    pub proofs: Option<Vec<SegmentProof>>,
    pub refusal: Option<Refusal>,
    pub termination: Termination,
    /// Requirements with a lowered floor, and their floors.
    lowered: Vec<(Requirement, f64)>,
    nearest: Option<Nearest>,
    /// What is left of constraints.
    kept: Kept,
    /// Length of the input and of the path, where an optimizer has measured them.
    lengths: Option<[f64; 2]>,
    iterations: u64,
    work: u64,
    stage: Stage,
    stages: Vec<StageShare>,
    pinched: Vec<Requirement>,
}

impl Answer {
    /// The input, of which nothing is known.
    pub fn unproved(question: &Question) -> Self {
        Self {
            path: question.input.path.clone(),
            proofs: None,
            refusal: None,
            lowered: Vec::new(),
            nearest: None,
            kept: Kept::default(),
            lengths: None,
            iterations: 0,
            work: 0,
            stage: Stage::Input,
            stages: Vec::new(),
            pinched: Vec::new(),
            termination: Termination::Done,
        }
    }

    /// The input, refused.
    pub fn refused(question: &Question, refusal: Refusal) -> Self {
        Self {
            refusal: Some(refusal),
            ..Self::unproved(question)
        }
    }

    /// The same without what was proved, which says nothing of a robot without geometry; a
    /// collision stays one.
    pub fn unproved_still(self) -> Self {
        let refusal = self
            .refusal
            .filter(|refusal| matches!(refusal.reason, HitReason::Collision | HitReason::Outside));
        Self {
            proofs: None,
            refusal,
            lowered: Vec::new(),
            kept: Kept::default(),
            termination: Termination::Done,
            ..self
        }
    }

    /// Takes what optimizers have come to.
    pub fn take(&mut self, mut progress: Progress) {
        self.iterations = progress.iterations;
        self.stage = progress.found_by();
        self.stages = progress.shares();
        self.pinched = std::mem::take(&mut progress.pinched);
        self.pinched.sort_unstable();
        self.pinched.dedup();
        self.lengths = Some([progress.best.input_length(), progress.best.length()]);
        (self.path, self.proofs) = progress.best.into_parts();
    }

    /// Goes back to the input.
    pub fn reset(&mut self, question: &Question) {
        self.path.clone_from(&question.input.path);
        self.lengths = None;
    }

    /// Adds what is asked for beside the path: what it comes near, how far it may be strayed from.
    pub fn look_around(
        &mut self,
        question: &Question,
        validator: &mut Validator,
        stop: &mut dyn FnMut() -> bool,
    ) {
        self.lowered = validator.floors().lowered().collect();
        self.lowered
            .sort_by_key(|(requirement, _)| *requirement);
        self.work = validator.work();
        let Some(proofs) = &mut self.proofs else {
            return;
        };
        self.kept = validator.kept(&self.path, stop);
        if question.settings.contacts {
            self.nearest = validator
                .nearest(&self.path, stop)
                .map(|nearest| self.kept.among(nearest));
        }
        if question.settings.corridor {
            validator.widen(&self.path, proofs, stop);
        }
    }

    /// The same in the caller's words and with the caller's waypoints.
    pub fn into_outcome(mut self, question: &Question) -> Outcome {
        let Question {
            model,
            path,
            settings,
            input,
        } = *question;
        let is_unchanged = self.path == input.path;
        let [length_before, length_after, lower_bound] = self.lengths(question);
        let output = self.output(question, is_unchanged);
        let floors_lowered = self.floors_lowered(question);
        let certificate = self
            .claims(question, is_unchanged)
            .map(|proofs| {
                let terms = Terms {
                    constraints: self.constraint_claims(question, is_unchanged),
                    ..terms(question, &floors_lowered)
                };
                Certificate::new(model, (&output).into(), terms, &proofs)
            });
        Outcome {
            turned: input.turned(model.robot(), path, &output),
            proved: certificate.is_some(),
            uncheckable: model
                .uncheckable()
                .filter(|_| self.refusal.is_none()),
            pairs: model.checked_pairs(),
            length_before,
            length_after,
            lower_bound,
            weights: input.metric.weights().to_vec(),
            clearance_m: settings.clearance_m,
            floor_m: least_floor_m(settings.clearance_m, &floors_lowered),
            floors_lowered,
            nearest: self.named_nearest(question, is_unchanged),
            keeps: self.keeps(question, is_unchanged),
            pinched: named(question, &self.pinched),
            iterations: self.iterations,
            work: self.work,
            stage: if is_unchanged {
                Stage::Input
            } else {
                self.stage
            },
            warnings: [model.uncovered(), input.warnings.clone()].concat(),
            corridor: corridor(question, &output, certificate.as_ref()),
            refusal: self.refusal,
            stages: self.stages,
            termination: self.termination,
            path: output,
            certificate,
        }
    }

    fn named_nearest(&self, question: &Question, is_unchanged: bool) -> Option<NearestHolds> {
        let nearest = self.nearest.as_ref()?;
        let segments = callers_segments(question, is_unchanged);
        Some(nearest::named(question, nearest, &segments))
    }

    fn keeps(&self, question: &Question, is_unchanged: bool) -> Vec<KeptConstraint> {
        if self.kept.tightest.is_empty() {
            return Vec::new();
        }
        let segments = callers_segments(question, is_unchanged);
        nearest::keeps(question, &self.kept, &segments)
    }

    /// The path as the caller gets it; it is taken out.
    fn output(&mut self, question: &Question, is_unchanged: bool) -> Path {
        let Question { path, input, .. } = *question;
        if is_unchanged {
            return input.given(path).clone();
        }
        let mut output = std::mem::take(&mut self.path);
        Restorer::new(path, input).restore(&mut output);
        output
    }

    /// Length of the input, of the path, and what none can be shorter than.
    fn lengths(&self, question: &Question) -> [f64; 3] {
        let input = question.input;
        let [before, after] = self
            .lengths
            .unwrap_or_else(|| [input.length(); 2]);
        // Without a waypoint on a straight line the sum may be rounded up.
        let after = after.min(before);
        let bound = lower_bound(&input.space, &input.metric, question.path, input.keep_goal);
        // Angles far out are rounded by more than the two may differ.
        [before, after, bound.min(after)]
    }

    fn floors_lowered(&self, question: &Question) -> Vec<LoweredFloor> {
        let lowered = self.lowered.iter();
        lowered
            .map(|&(requirement, floor)| LoweredFloor {
                requirement: requirement.named(question.model, &question.input.constraints),
                floor,
            })
            .collect()
    }

    /// What is left of constraints on the segments that the caller gets.
    fn constraint_claims(
        &self,
        question: &Question,
        is_unchanged: bool,
    ) -> Option<ConstraintClaims> {
        let standing_for = &question.input.standing_for;
        let left = &self.kept.left;
        (!left.is_empty()).then(|| ConstraintClaims {
            asked: question.settings.constraints.clone(),
            left: match is_unchanged && standing_for.len() > 1 {
                true => standing_for
                    .windows(2)
                    .map(|ends| left[ends[0].min(left.len() - 1)].clone())
                    .collect(),
                false => left.clone(),
            },
        })
    }

    /// The proofs of the segments that the caller gets.
    fn claims(&self, question: &Question, is_unchanged: bool) -> Option<Vec<SegmentProof>> {
        let proofs = self.proofs.as_ref()?;
        Some(if is_unchanged {
            spread(proofs, &question.input.standing_for)
        } else {
            proofs.clone()
        })
    }
}

/// The caller's segments of those that optimizers worked on; none where the path is another one.
fn callers_segments(question: &Question, is_unchanged: bool) -> Vec<usize> {
    match is_unchanged {
        true => nearest::segments_of(&question.input.standing_for),
        false => Vec::new(),
    }
}

fn corridor(
    question: &Question,
    output: &Path,
    certificate: Option<&Certificate>,
) -> Option<Corridor> {
    let certificate = certificate.filter(|_| question.settings.corridor)?;
    Some(Corridor::new(question.model, output, certificate))
}

fn terms(question: &Question, lowered: &[LoweredFloor]) -> Terms {
    let settings = question.settings;
    Terms {
        clearance_m: settings.clearance_m,
        lowered: lowered.to_vec(),
        unwrapped: settings.unwrapped,
        held: settings.held.clone(),
        constraints: None,
    }
}

fn least_floor_m(clearance_m: f64, lowered: &[LoweredFloor]) -> f64 {
    let clearances = lowered
        .iter()
        .filter(|lowered| lowered.requirement.kind == RequirementKind::Clearance);
    clearances
        .map(|lowered| lowered.floor)
        .fold(clearance_m, f64::min)
}

fn named(question: &Question, requirements: &[Requirement]) -> Vec<NamedRequirement> {
    let requirements = requirements.iter();
    requirements
        .map(|requirement| requirement.named(question.model, &question.input.constraints))
        .collect()
}

/// Proofs of the caller's segments: one between equal waypoints keeps what the segment beside it
/// keeps.
fn spread(proofs: &[SegmentProof], standing_for: &[usize]) -> Vec<SegmentProof> {
    if standing_for.len() < 2 {
        return proofs.to_vec();
    }
    let segments = standing_for.windows(2);
    segments
        .map(|ends| proof_between(proofs, ends[0], ends[1]))
        .collect()
}

/// Of the caller's segment whose ends these waypoints stand for.
fn proof_between(proofs: &[SegmentProof], from: usize, to: usize) -> SegmentProof {
    let proof = proofs[from.min(proofs.len() - 1)];
    match from < to {
        true => proof,
        false => SegmentProof {
            intervals: 0,
            ..proof
        },
    }
}
