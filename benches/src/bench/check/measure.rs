//! Measures the check on one path.

use std::time::{Duration, Instant};

use taut::collision::CollisionModel;
use taut::constraint::{self, Constraint, ConstraintsFile};
use taut::optimize::{self, Settings, Workspace};
use taut::path::Path;
use taut::validation::path_proof::{self, PathVerdict};
use taut::validation::{Layers, Queries, Requirement, Scratch, SegmentVerdict, Validator};

use super::super::loaded::Loaded;
use super::figures::{ConstraintFigures, Figures};
use crate::error::Error;
use crate::statistics::median;

/// Joint-space motion between two samples of the sampled check (rad), VAMP's.
const SAMPLE_RAD: f64 = 1.0 / 32.0;
/// Each time is the median of as many runs as fit in here, but of some at least and at most.
const BUDGET: Duration = Duration::from_millis(30);
const RUNS: std::ops::RangeInclusive<usize> = 3..=1001;

/// Measures one problem at the floors that its path sets.
pub(crate) fn measure(
    loaded: &Loaded,
    clearance: f64,
    scratch: &mut Scratch,
) -> Result<Figures, Error> {
    let model = loaded.model()?;
    let path = &loaded.path;
    let held = vec![0.0; model.robot().held().len()];
    let mut check = Check {
        floors: floors(&model, &held, path, clearance, scratch),
        model: &model,
        held: &held,
        clearance,
        scratch,
    };
    let proof = check.proof(path);
    let [proof_s, sampled_s] = check.times(path);
    let figures = Figures {
        geometry: loaded.geometry_name(),
        waypoints: path.len(),
        proof_s: proof_s.unwrap_or_default(),
        refusal_s: check.refusal(path),
        sampled_s,
        sampled_free: check
            .is_exact()
            .then(|| check.sampling(path).is_free),
        run_tests: run_tests(&model, path, clearance, true),
        run_tests_without_reuse: run_tests(&model, path, clearance, false),
        floors_lowered: check.lowered().count(),
        constraints: check.constraints(&loaded.constraints, path),
        ..proof.figures()
    };
    Ok(Figures {
        ratio: ratio(&figures),
        ..figures
    })
}

/// Proof over sampling, where both find the path free.
fn ratio(figures: &Figures) -> Option<f64> {
    let both = figures.proved && figures.sampled_free == Some(true);
    let sampled_s = figures.sampled_s.filter(|_| both)?;
    Some(figures.proof_s / sampled_s)
}

/// The floors that a path sets.
fn floors(
    model: &CollisionModel,
    held: &[f64],
    path: &Path,
    clearance: f64,
    scratch: &mut Scratch,
) -> Vec<f64> {
    let mut validator = Validator::new(model, model.robot().space(), held, clearance, scratch);
    let _ = path_proof::prove_input(&mut validator, path, true, &mut || false);
    validator.floors().clearances().to_vec()
}

/// Tests that the gradient method makes on a path, with or without remembered proofs; 0 where it
/// cannot run.
fn run_tests(model: &CollisionModel, path: &Path, clearance_m: f64, reuse: bool) -> u64 {
    let layers = Layers {
        reuse,
        ..Layers::default()
    };
    let settings = Settings {
        clearance_m,
        layers,
        ..Settings::default()
    };
    let outcome = optimize::run(
        model,
        path,
        &settings,
        &mut Workspace::default(),
        &mut || false,
        &mut |_| {},
    );
    outcome.map_or(0, |outcome| outcome.work)
}

/// One path's robot, scene and floors.
struct Check<'a> {
    model: &'a CollisionModel,
    held: &'a [f64],
    clearance: f64,
    floors: Vec<f64>,
    scratch: &'a mut Scratch,
}

/// One proof.
struct Proof<'a> {
    time_s: f64,
    verdict: PathVerdict<'a>,
    queries: Queries,
}

/// One sampling.
struct Sampling {
    time_s: f64,
    is_free: bool,
}

impl Check<'_> {
    /// Whether the filter sees every shape as it is, so that samples can be taken with it alone.
    fn is_exact(&self) -> bool {
        self.model.filter().is_exact()
    }

    /// Pairs with a lowered floor.
    fn lowered(&self) -> impl Iterator<Item = (Requirement, f64)> {
        let floors = self.floors.iter().copied().enumerate();
        floors
            .filter(|(_, floor)| *floor < self.clearance)
            .map(|(pair, floor)| (Requirement::Clearance(pair), floor))
    }

    /// A validator that has proved nothing yet.
    fn validator(&mut self) -> Validator<'_> {
        let lowered: Vec<(Requirement, f64)> = self.lowered().collect();
        let space = self.model.robot().space();
        let mut validator =
            Validator::new(self.model, space, self.held, self.clearance, self.scratch);
        for (requirement, floor) in lowered {
            validator.set_floor(requirement, floor);
        }
        validator
    }

    /// Median times of proofs and of samplings, turn by turn, so that whatever else the machine does
    /// falls on both alike.
    fn times(&mut self, path: &Path) -> [Option<f64>; 2] {
        let mut proofs = Vec::new();
        let mut samplings = Vec::new();
        repeat(|| {
            proofs.push(self.proof(path).time_s);
            if self.is_exact() {
                samplings.push(self.sampling(path).time_s);
            }
        });
        [proofs, samplings].map(|times| median(times.into_iter()))
    }

    fn proof<'p>(&mut self, path: &'p Path) -> Proof<'p> {
        let mut validator = self.validator();
        let start = Instant::now();
        let verdict = path_proof::prove(&mut validator, path, &mut || false);
        Proof {
            time_s: start.elapsed().as_secs_f64(),
            verdict,
            queries: validator.queries(),
        }
    }

    fn sampling(&mut self, path: &Path) -> Sampling {
        let mut validator = self.validator();
        let start = Instant::now();
        let is_free = validator.samples_are_free(path, SAMPLE_RAD);
        Sampling {
            time_s: start.elapsed().as_secs_f64(),
            is_free,
        }
    }

    /// Time to refuse the straight way from end to end, with the contact that a message shows; `None`
    /// where it is free.
    fn refusal(&mut self, path: &Path) -> Option<f64> {
        self.refuse(path)?;
        let mut times = Vec::new();
        repeat(|| times.extend(self.refuse(path)));
        median(times.into_iter())
    }

    /// What proving the constraints of a path takes, at the tolerances that it sets; `None` where it has
    /// none, or does not keep them.
    fn constraints(&mut self, asked: &ConstraintsFile, path: &Path) -> Option<ConstraintFigures> {
        let model = self.model;
        let constraints: Vec<Constraint> =
            constraint::constraints(asked, model.robot(), model.scene()).ok()?;
        let mut validator = self.validator().with_constraints(&constraints);
        let _ = path_proof::prove_input(&mut validator, path, true, &mut || false);
        let before = validator.work();
        let is_kept = validator.violations(path.as_flat()).is_empty();
        let looks = validator.work() - before;
        if constraints.is_empty() || !is_kept {
            return None;
        }
        let mut times = Vec::new();
        repeat(|| {
            let start = Instant::now();
            validator.violations(path.as_flat());
            times.push(start.elapsed().as_secs_f64());
        });
        Some(ConstraintFigures {
            time_s: median(times.into_iter())?,
            looks_a_segment: looks as f64 / (path.len() - 1).max(1) as f64,
        })
    }

    fn refuse(&mut self, path: &Path) -> Option<f64> {
        let from = path.waypoint(0);
        let to = path.waypoint(path.len() - 1);
        let mut validator = self.validator();
        let start = Instant::now();
        let verdict = validator.segment(from, to, &mut || false);
        let time_s = start.elapsed().as_secs_f64();
        matches!(verdict, SegmentVerdict::Refused(_)).then_some(time_s)
    }
}

impl Proof<'_> {
    /// What it proves and takes.
    fn figures(&self) -> Figures {
        let proofs = match &self.verdict {
            PathVerdict::Proved(proved) => proved.proofs(),
            _ => &[],
        };
        let clearances = proofs.iter().map(|proof| proof.clearance_m);
        Figures {
            proved: matches!(self.verdict, PathVerdict::Proved(_)),
            intervals: proofs.iter().map(|proof| proof.intervals).sum(),
            far_tests: self.queries.far,
            near_tests: self.queries.near,
            exact_tests: self.queries.exact,
            clearance_m: clearances
                .min_by(f64::total_cmp)
                .filter(|least| least.is_finite()),
            ..Figures::default()
        }
    }
}

/// Does something as often as fits in the budget.
fn repeat(mut what: impl FnMut()) {
    let start = Instant::now();
    let mut runs = 0;
    while runs < *RUNS.start() || (runs < *RUNS.end() && start.elapsed() < BUDGET) {
        what();
        runs += 1;
    }
}
