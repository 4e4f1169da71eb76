//! What one iteration of the contact model costs and how that grows: `cargo bench --bench step`.
//!
//! A random walk on prismatic joints, and random half-spaces that the step without rows is not in.
//! An iteration is what the optimizer does from one path: cost and gradient, rows (their M), the
//! active set method from nothing, and the step. First a table of what holds the step, the same on
//! every machine; then times.

use divan::Bencher;
use taut::math::{Pose, Vec3};
use taut::optimize::active_set::ActiveSet;
use taut::optimize::cost::{Cost, rest_lengths};
use taut::optimize::rows::Row;
use taut::path::Metric;
use taut::robot::{
    ConfigurationSpace, JointDescription, JointKind, LinkDescription, RobotDescription, RobotModel,
};

const WAYPOINTS: [usize; 3] = [10, 100, 1_000];
const ROWS: [usize; 5] = [10, 20, 40, 80, 160];
/// As many joints as a humanoid or a two-armed robot on a base has.
const MANY_JOINTS: usize = 35;
/// As in the optimizer.
const SHORTEST_SEGMENT: f64 = 1e-3;

fn main() {
    if !std::env::args().any(|argument| argument == "--list") {
        count();
    }
    divan::main();
}

/// A path and half-spaces.
struct Case {
    space: ConfigurationSpace,
    metric: Metric,
    path: Vec<f64>,
    fixed: Vec<bool>,
    moving: Vec<bool>,
    /// Segment, ratio, jacobian and right-hand side.
    rows: Vec<(usize, f64, Vec<f64>, f64)>,
}

/// What an iteration writes to.
struct Memory {
    set: ActiveSet,
    gradient: Vec<f64>,
    velocity: Vec<f64>,
    step: Vec<f64>,
}

/// The space of so many joints with limits.
fn lines(joints: usize) -> ConfigurationSpace {
    let link = |i: usize| LinkDescription {
        name: format!("link{i}"),
        collision: Vec::new(),
    };
    let joint = |i: usize| JointDescription {
        name: format!("joint{i}"),
        kind: JointKind::Prismatic,
        parent: format!("link{i}"),
        child: format!("link{}", i + 1),
        origin: Pose::identity(),
        axis: Vec3::X,
        limits: Some((-1.0, 1.0)),
        soft_limits: None,
        mimic: None,
    };
    let links = (0..=joints).map(link).collect();
    let joints = (0..joints).map(joint).collect();
    let description = RobotDescription {
        links,
        joints,
        ..RobotDescription::default()
    };
    RobotModel::new(description)
        .expect("a chain")
        .space()
        .clone()
}

impl Case {
    /// Each row asks for about half of `push` more than the step without rows has.
    fn random(waypoints: usize, joints: usize, rows: usize, push: f64) -> Self {
        let mut random = fastrand::Rng::with_seed(7);
        let space = lines(joints);
        let metric = Metric::new(
            &space,
            (0..joints)
                .map(|_| 0.5 + random.f64())
                .collect(),
        )
        .expect("positive weights");
        let mut path = vec![0.0; joints];
        for place in joints..waypoints * joints {
            path.push(path[place - joints] + random.f64() - 0.4);
        }
        let mut case = Self {
            space,
            metric,
            path,
            fixed: (0..waypoints)
                .map(|i| i == 0 || i + 1 == waypoints)
                .collect(),
            moving: vec![true; joints],
            rows: Vec::new(),
        };
        let mut memory = case.memory();
        let cost = case.cost();
        cost.gradient(&case.path, &mut memory.velocity, &mut memory.gradient);
        memory.set.begin(&cost, &memory.gradient);
        memory.set.step(&cost, &mut memory.step);
        for _ in 0..rows {
            let segment = random.usize(1..waypoints - 2);
            let jacobian: Vec<f64> = (0..joints)
                .map(|_| random.f64() - 0.5)
                .collect();
            let row = Row {
                segment,
                ratio: random.f64(),
                jacobian: &jacobian,
                right_hand_side: 0.0,
            };
            let right_hand_side = row.of_step(&memory.step) + push * (random.f64() + 0.1);
            let ratio = row.ratio;
            case.rows
                .push((segment, ratio, jacobian, right_hand_side));
        }
        case
    }

    fn memory(&self) -> Memory {
        let joints = self.moving.len();
        Memory {
            set: ActiveSet::new(joints),
            gradient: vec![0.0; self.path.len()],
            velocity: vec![0.0; joints],
            step: vec![0.0; self.path.len()],
        }
    }

    fn cost(&self) -> Cost<'_> {
        let lengths = rest_lengths(&self.space, &self.metric, &self.path, SHORTEST_SEGMENT);
        Cost::of_rest_lengths(
            &self.space,
            &self.metric,
            &lengths,
            &self.fixed,
            &self.moving,
        )
    }

    fn linearise<'a>(&'a self, memory: &mut Memory) -> Cost<'a> {
        let cost = self.cost();
        cost.gradient(&self.path, &mut memory.velocity, &mut memory.gradient);
        memory.set.begin(&cost, &memory.gradient);
        cost
    }

    fn push_rows(&self, cost: &Cost<'_>, memory: &mut Memory) {
        for (segment, ratio, jacobian, right_hand_side) in &self.rows {
            let row = Row {
                segment: *segment,
                ratio: *ratio,
                jacobian,
                right_hand_side: *right_hand_side,
            };
            memory.set.push(cost, row);
        }
    }

    /// One iteration.
    fn iterate(&self, memory: &mut Memory) {
        let cost = self.linearise(memory);
        self.push_rows(&cost, memory);
        memory
            .set
            .solve(&mut || false)
            .expect("independent rows are feasible");
        memory.set.step(&cost, &mut memory.step);
    }
}

/// As in a path of an arm: 12 contacts.
fn long(waypoints: usize) -> Case {
    Case::random(waypoints, 7, 12, 0.3)
}

/// Most of the rows hold: each asks for more than the step without rows has.
fn wide(rows: usize) -> Case {
    Case::random(60, MANY_JOINTS, rows, 0.3)
}

/// Which rows hold each case that is timed below.
fn count() {
    println!(
        "{:<34} {:>9} {:>9}",
        "half-spaces of a step", "rows", "active"
    );
    let line = |name: String, case: Case| {
        let mut memory = case.memory();
        case.iterate(&mut memory);
        println!(
            "{name:<34} {:>9} {:>9}",
            case.rows.len(),
            memory.set.active().count()
        );
    };
    WAYPOINTS
        .iter()
        .for_each(|&n| line(format!("{n} waypoints x 7"), long(n)));
    ROWS.iter()
        .for_each(|&n| line(format!("60 waypoints x {MANY_JOINTS}"), wide(n)));
    println!();
}

fn time(bencher: Bencher, case: &Case, of: impl Fn(&Case, &mut Memory)) {
    let mut memory = case.memory();
    bencher.bench_local(|| of(case, &mut memory));
}

#[divan::bench(args = WAYPOINTS)]
fn waypoints(bencher: Bencher, count: usize) {
    time(bencher, &long(count), Case::iterate);
}

#[divan::bench(args = ROWS)]
fn rows(bencher: Bencher, count: usize) {
    time(bencher, &wide(count), Case::iterate);
}

/// Of that, what does not depend on rows: stiffness, gradient, the step without rows.
#[divan::bench(args = ROWS)]
fn rows_model_only(bencher: Bencher, count: usize) {
    time(bencher, &wide(count), |case, memory| {
        drop(case.linearise(memory))
    });
}

/// The same and M.
#[divan::bench(args = ROWS)]
fn rows_model_and_m(bencher: Bencher, count: usize) {
    time(bencher, &wide(count), |case, memory| {
        let cost = case.linearise(memory);
        case.push_rows(&cost, memory);
    });
}

/// The whole from the rows that held last, as from one accepted path to the next.
#[divan::bench(args = ROWS)]
fn rows_warm(bencher: Bencher, count: usize) {
    let case = wide(count);
    let mut memory = case.memory();
    case.iterate(&mut memory);
    let held: Vec<usize> = memory
        .set
        .active()
        .map(|(row, _)| row)
        .collect();
    bencher.bench_local(|| {
        let cost = case.linearise(&mut memory);
        case.push_rows(&cost, &mut memory);
        memory.set.warm_start(held.iter().copied());
        memory
            .set
            .solve(&mut || false)
            .expect("independent rows are feasible");
        memory.set.step(&cost, &mut memory.step);
    });
}
