//! The figures of `taut bench --check`: what a proof costs, a refusal, and the sampling that others
//! do.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::time::{Duration, Instant};

use serde::Serialize;
use taut::collision::CollisionModel;
use taut::optimize::{self, Settings, Workspace};
use taut::path::Path;
use taut::validation::path_proof::{self, PathVerdict};
use taut::validation::{Layers, Queries, Scratch, SegmentVerdict, Validator};

use super::statistics::median;
use crate::cli::error::CliError;
use crate::cli::load::Loaded;
use crate::cli::report::{length, time};

/// Joint-space motion between two samples of the sampled check (rad), VAMP's.
const SAMPLE_RAD: f64 = 1.0 / 32.0;
/// Each time is the median of as many runs as fit in here, but of some at least and at most.
const BUDGET: Duration = Duration::from_millis(30);
const RUNS: std::ops::RangeInclusive<usize> = 3..=1001;

/// One problem.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    set: String,
    name: String,
    /// Why the problem could not be read or run.
    error: Option<String>,
    #[serde(flatten)]
    figures: Option<Figures>,
}

/// What was measured on one path; times are medians (s).
#[derive(Debug, Serialize)]
pub(super) struct Figures {
    geometry: &'static str,
    waypoints: usize,
    proved: bool,
    /// Time to prove the path, or to refuse it.
    proof_s: f64,
    /// Intervals of the proof.
    intervals: u32,
    /// Tests by layer.
    far_tests: u64,
    near_tests: u64,
    exact_tests: u64,
    /// Distance that all pairs keep (m); `None` where nothing comes near.
    clearance_m: Option<f64>,
    /// Pairs with a lowered floor.
    floors_lowered: usize,
    /// Time to refuse the straight way from the first waypoint to the last; `None` where it is
    /// free.
    refusal_s: Option<f64>,
    /// The same segment proved by samples; `None` where the filter does not see every shape as it
    /// is.
    sampled_s: Option<f64>,
    /// Whether all samples are free.
    sampled_free: Option<bool>,
    /// Proof over sampling, where both find the path free.
    ratio: Option<f64>,
    /// Tests of a whole run of the gradient method, and those that it takes when it remembers no
    /// proof.
    run_tests: u64,
    run_tests_without_reuse: u64,
}

/// Medians of one set over the paths that are proved.
#[derive(Debug, Serialize)]
struct SetMedians {
    set: String,
    problems: usize,
    proved: usize,
    proof_s: Option<f64>,
    refusal_s: Option<f64>,
    sampled_s: Option<f64>,
    ratio: Option<f64>,
    worst_ratio: Option<f64>,
    /// Part of a run's tests that remembered proofs save.
    saved: Option<f64>,
}

/// All rows and their medians.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    rows: Vec<Row>,
    sets: Vec<SetMedians>,
}

/// Measures one problem at the floors that its path sets.
pub(super) fn measure(
    loaded: &Loaded,
    clearance: f64,
    scratch: &mut Scratch,
) -> Result<Figures, CliError> {
    let model = loaded.model()?;
    let path = &loaded.path;
    let held = vec![0.0; model.robot().held().len()];
    let floors = {
        let mut validator =
            Validator::new(&model, model.robot().space(), &held, clearance, scratch);
        let _ = path_proof::prove_input(&mut validator, path, true, &mut || false);
        validator.floors().to_vec()
    };
    let mut check = Check {
        model: &model,
        held: &held,
        clearance,
        floors: &floors,
        scratch,
    };
    let mut proofs = Vec::new();
    let mut samplings = Vec::new();
    let (verdict, queries) = check.proof(path).1;
    let is_exact = model.filter().is_exact();
    let sampled_free = is_exact.then(|| check.sampling(path).1);
    // Turn by turn, so that whatever else the machine does falls on both alike.
    repeat(|| {
        proofs.push(check.proof(path).0);
        if is_exact {
            samplings.push(check.sampling(path).0);
        }
    });
    let proof_s = median(proofs.into_iter()).unwrap_or_default();
    let sampled_s = median(samplings.into_iter());
    let (intervals, clearance_m) = match &verdict {
        PathVerdict::Proved(proofs) => (
            proofs.iter().map(|proof| proof.intervals).sum(),
            proofs
                .iter()
                .map(|proof| proof.clearance_m)
                .min_by(f64::total_cmp)
                .filter(|least| least.is_finite()),
        ),
        _ => (0, None),
    };
    let proved = matches!(verdict, PathVerdict::Proved(_));
    let [run_tests, run_tests_without_reuse] =
        [true, false].map(|reuse| run_tests(&model, path, clearance, reuse));
    let both = sampled_s.filter(|_| proved && sampled_free == Some(true));
    Ok(Figures {
        geometry: loaded.geometry_name(),
        waypoints: path.len(),
        proved,
        proof_s,
        intervals,
        far_tests: queries.far,
        near_tests: queries.near,
        exact_tests: queries.exact,
        clearance_m,
        floors_lowered: floors.iter().filter(|floor| **floor < clearance).count(),
        refusal_s: check.refusal(path),
        sampled_s,
        sampled_free,
        ratio: both.map(|sampled_s| proof_s / sampled_s),
        run_tests,
        run_tests_without_reuse,
    })
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
    floors: &'a [f64],
    scratch: &'a mut Scratch,
}

impl Check<'_> {
    /// A validator that has proved nothing yet.
    fn validator(&mut self) -> Validator<'_> {
        let space = self.model.robot().space();
        let mut validator =
            Validator::new(self.model, space, self.held, self.clearance, self.scratch);
        for (pair, floor) in self
            .floors
            .iter()
            .enumerate()
            .filter(|(_, floor)| **floor < self.clearance)
        {
            validator.set_floor(pair, *floor);
        }
        validator
    }

    fn proof(&mut self, path: &Path) -> (f64, (PathVerdict, Queries)) {
        let mut validator = self.validator();
        let start = Instant::now();
        let verdict = path_proof::prove(&mut validator, path, &mut || false);
        (
            start.elapsed().as_secs_f64(),
            (verdict, validator.queries()),
        )
    }

    fn sampling(&mut self, path: &Path) -> (f64, bool) {
        let mut validator = self.validator();
        let start = Instant::now();
        let free = validator.samples_are_free(path, SAMPLE_RAD);
        (start.elapsed().as_secs_f64(), free)
    }

    /// Time to refuse the straight way from end to end, with the contact that a message shows.
    fn refusal(&mut self, path: &Path) -> Option<f64> {
        let from = path.waypoint(0);
        let to = path.waypoint(path.len() - 1);
        let mut once = || {
            let mut validator = self.validator();
            let start = Instant::now();
            let verdict = validator.segment(from, to, &mut || false);
            (start.elapsed().as_secs_f64(), verdict)
        };
        if !matches!(once().1, SegmentVerdict::Refused(_)) {
            return None;
        }
        let mut times = Vec::new();
        repeat(|| times.push(once().0));
        median(times.into_iter())
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

impl Row {
    /// What came of one problem.
    pub(super) fn new(set: String, name: String, measured: Result<Figures, CliError>) -> Self {
        match measured {
            Ok(figures) => Self {
                set,
                name,
                error: None,
                figures: Some(figures),
            },
            Err(error) => Self {
                set,
                name,
                error: Some(error.to_string()),
                figures: None,
            },
        }
    }
}

impl Report {
    /// Takes the medians of the rows.
    pub(super) fn new(rows: Vec<Row>) -> Self {
        let mut by_set: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
        for row in &rows {
            by_set.entry(&row.set).or_default().push(row);
        }
        let sets = by_set
            .into_iter()
            .map(|(set, rows)| SetMedians::of(set, &rows))
            .collect();
        Self { sets, rows }
    }

    /// Whether a problem could not be read or run.
    pub(super) fn has_errors(&self) -> bool {
        self.rows.iter().any(|row| row.error.is_some())
    }

    /// Rows and medians as JSON.
    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).expect("a report holds only strings, booleans and numbers")
    }

    /// Rows and medians for people.
    pub(super) fn table(&self) -> String {
        let mut text = String::new();
        let width = self
            .rows
            .iter()
            .map(|row| row.set.len() + row.name.len() + 1)
            .max()
            .unwrap_or(0)
            .max(7);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<width$}  waypoints     proof   refusal   sampled  ratio  intervals  tests far, near, exact   keeps",
            "problem"
        );
        for row in &self.rows {
            let name = format!("{}/{}", row.set, row.name);
            let _ = match &row.figures {
                Some(figures) => writeln!(text, "{name:<width$}  {}", figures.cells()),
                None => writeln!(
                    text,
                    "{name:<width$}  {}",
                    row.error.as_deref().unwrap_or_default()
                ),
            };
        }
        for set in &self.sets {
            set.write(&mut text);
        }
        text
    }
}

impl Figures {
    /// Part of a run's tests that remembered proofs save.
    fn saved(&self) -> f64 {
        1.0 - self.run_tests as f64 / self.run_tests_without_reuse.max(1) as f64
    }

    fn cells(&self) -> String {
        let optional = |seconds: Option<f64>, none: &str| seconds.map_or(none.to_owned(), time);
        let keeps = match (self.proved, self.clearance_m) {
            (false, _) => "not proved".to_owned(),
            (true, None) => "far".to_owned(),
            (true, Some(metres)) => length(metres),
        };
        let lowered = if self.floors_lowered > 0 {
            format!(" *{}", self.floors_lowered)
        } else {
            String::new()
        };
        format!(
            "{:>9} {:>9} {:>9} {:>9}  {:>5} {:>10}  {:>22}   {keeps}{lowered}",
            self.waypoints,
            time(self.proof_s),
            optional(self.refusal_s, "free"),
            optional(self.sampled_s, "-"),
            self.ratio
                .map_or("-".to_owned(), |ratio| format!("{ratio:.2}")),
            self.intervals,
            format!(
                "{}, {}, {}",
                self.far_tests, self.near_tests, self.exact_tests
            ),
        )
    }
}

impl SetMedians {
    fn of(set: &str, rows: &[&Row]) -> Self {
        let all = || rows.iter().filter_map(|row| row.figures.as_ref());
        let proved = || all().filter(|figures| figures.proved);
        let ratios = || proved().filter_map(|figures| figures.ratio);
        Self {
            set: set.to_owned(),
            problems: rows.len(),
            proved: proved().count(),
            proof_s: median(proved().map(|figures| figures.proof_s)),
            refusal_s: median(all().filter_map(|figures| figures.refusal_s)),
            sampled_s: median(proved().filter_map(|figures| figures.sampled_s)),
            ratio: median(ratios()),
            worst_ratio: ratios().max_by(f64::total_cmp),
            saved: median(proved().map(|figures| figures.saved())),
        }
    }

    fn write(&self, text: &mut String) {
        let Self {
            set,
            problems,
            proved,
            ..
        } = self;
        let or_none = |seconds: Option<f64>| seconds.map_or("-".to_owned(), time);
        let _ = writeln!(
            text,
            "\n{set}: {proved} of {problems} proved; medians of these"
        );
        let _ = write!(
            text,
            "  proof {}  refusal {}",
            or_none(self.proof_s),
            or_none(self.refusal_s)
        );
        if let (Some(ratio), Some(worst)) = (self.ratio, self.worst_ratio) {
            let sampled = or_none(self.sampled_s);
            let _ = write!(
                text,
                "  sampled every 1/32 rad {sampled}  proof ÷ sampled {ratio:.2} (worst {worst:.2})"
            );
        }
        if let Some(saved) = self.saved {
            let _ = write!(
                text,
                "  remembered proofs save {:.0} % of a run's tests",
                100.0 * saved
            );
        }
        let _ = writeln!(text);
    }
}
