//! What a certified check costs and how the cost grows: `cargo bench`.
//!
//! First a table of counted tests, the same on every machine; then times. The robot is the shipped
//! arm (boxes, cylinders and balls on seven joints) or the two arms on a mobile base; paths are
//! random walks of proved segments.

use std::path::Path as File;
use std::sync::Arc;

use divan::Bencher;
use taut::collision::CollisionModel;
use taut::files::{Geometry, Packages, Problem, Reader};
use taut::math::{Pose, Quat, Vec3};
use taut::path::Path;
use taut::robot::RobotModel;
use taut::scene::{Obstacle, Scene};
use taut::shape::{Mesh, PlacedShape, Shape};
use taut::validation::path_proof::{self, PathVerdict};
use taut::validation::{Queries, Scratch, SegmentVerdict, SegmentsVerdict, Validator};

const CLEARANCE_M: f64 = 1e-3;
const WAYPOINTS: [usize; 6] = [2, 4, 8, 16, 32, 64];
const FAR_OBJECTS: [usize; 4] = [0, 10, 100, 1000];
const NEAR_OBJECTS: [usize; 4] = [1, 4, 16, 64];
const CLEARANCES_M: [f64; 4] = [1e-4, 1e-3, 5e-3, 1e-2];
const TRIANGLES: [usize; 4] = [128, 2_048, 32_768, 131_072];
const SHIPPED: [&str; 5] = [
    "arm_shelf",
    "arm_window",
    "ell_window",
    "exchange_arms",
    "rooms",
];

fn main() {
    if !std::env::args().any(|argument| argument == "--list") {
        count();
    }
    divan::main();
}

/// A path that is proved, and what it is proved in.
struct Case {
    model: CollisionModel,
    path: Path,
    clearance: f64,
}

impl Case {
    fn validator<'a>(&'a self, scratch: &'a mut Scratch) -> Validator<'a> {
        const HELD: [f64; 16] = [0.0; 16];
        let robot = self.model.robot();
        Validator::new(
            &self.model,
            robot.space(),
            &HELD[..robot.held().len()],
            self.clearance,
            scratch,
        )
    }

    fn prove(&self, scratch: &mut Scratch) -> (u32, Queries) {
        let mut validator = self.validator(scratch);
        let PathVerdict::Proved(proved) =
            path_proof::prove(&mut validator, &self.path, &mut || false)
        else {
            panic!("every path of these benchmarks is free");
        };
        (
            proved
                .proofs()
                .iter()
                .map(|proof| proof.intervals)
                .sum(),
            validator.queries(),
        )
    }

    /// Refuses the straight way from the first waypoint to the last.
    fn refuse(&self, scratch: &mut Scratch) -> Queries {
        let mut validator = self.validator(scratch);
        let ends = [0, self.path.len() - 1].map(|waypoint| self.path.waypoint(waypoint));
        let verdict = validator.segment(ends[0], ends[1], &mut || false);
        assert!(
            matches!(verdict, SegmentVerdict::Refused(_)),
            "every straight way of these benchmarks is blocked"
        );
        validator.queries()
    }
}

fn problem(name: &str) -> Problem {
    let file = File::new(env!("CARGO_MANIFEST_DIR"))
        .join("../config/problems")
        .join(format!("{name}.json"));
    Reader::new(Packages::default())
        .problem(&file, Geometry::Given)
        .expect("the problem is shipped")
}

fn shipped(name: &str) -> Case {
    let problem = problem(name);
    let robot = Arc::new(problem.model().expect("the robot is shipped"));
    let path = problem.path.clone();
    Case {
        model: model(
            &robot,
            problem
                .scene
                .obstacles()
                .iter()
                .cloned()
                .collect(),
        ),
        path,
        clearance: CLEARANCE_M,
    }
}

fn model(robot: &Arc<RobotModel>, obstacles: Vec<Obstacle>) -> CollisionModel {
    let scene =
        Scene::new("bench", obstacles, Vec::new(), Vec::new()).expect("the obstacles are solids");
    CollisionModel::new(robot.clone(), Arc::new(scene)).expect("the scene names nothing")
}

/// A random walk from the first waypoint of a shipped problem among its obstacles, each segment
/// proved.
fn wander(name: &str, waypoints: usize, clearance: f64) -> Case {
    let mut case = shipped(name);
    let mut random = fastrand::Rng::with_seed(7);
    let mut scratch = Scratch::default();
    case.clearance = clearance;
    let robot = case.model.robot().clone();
    let mut rows = case.path.waypoint(0).to_vec();
    while rows.len() < waypoints * robot.space().nq() {
        let from = rows[rows.len() - robot.space().nq()..].to_vec();
        let step = |(value, variable): (&f64, &taut::robot::Variable)| {
            (value + (random.f64() - 0.5) * 0.6).clamp(variable.lower, variable.upper)
        };
        let to: Vec<f64> = from
            .iter()
            .zip(robot.variables())
            .map(step)
            .collect();
        if case
            .validator(&mut scratch)
            .proves(&from, &to, &mut || false)
            == Some(true)
        {
            rows.extend(to);
        }
    }
    case.path = Path::from_rows(robot.space().nq(), rows).expect("whole rows");
    case
}

/// The same case with more obstacles: as many as asked for of those that `place` makes, that leave
/// the path as provable as it is and that take so many exact tests.
fn among(
    mut case: Case,
    count: usize,
    exact_tests: u64,
    mut place: impl FnMut(&mut fastrand::Rng, usize) -> Obstacle,
) -> Case {
    let mut random = fastrand::Rng::with_seed(11);
    let mut scratch = Scratch::default();
    let robot = case.model.robot().clone();
    let old: Vec<_> = case
        .model
        .scene()
        .obstacles()
        .iter()
        .cloned()
        .collect();
    let mut kept = old.clone();
    let mut tried = 0;
    while kept.len() < old.len() + count {
        let candidate = place(&mut random, tried);
        tried += 1;
        case.model = model(&robot, vec![candidate.clone()]);
        let mut validator = case.validator(&mut scratch);
        let is_free =
            validator.segments(case.path.segments(), &mut || false) == SegmentsVerdict::Proved;
        if is_free && validator.queries().exact >= exact_tests {
            kept.push(candidate);
        }
    }
    case.model = model(&robot, kept);
    case
}

fn obstacle(id: String, shape: Shape, at: Vec3) -> Obstacle {
    let pose = Pose::from_parts(at, Quat::IDENTITY);
    Obstacle::new(
        id,
        vec![PlacedShape {
            pose: Pose::identity(),
            shape,
        }],
    )
    .at(pose)
}

/// Boxes from 4 m to 30 m away.
fn far(case: Case, count: usize) -> Case {
    among(case, count, 0, |random, index| {
        let turn = random.f64() * std::f64::consts::TAU;
        let at =
            Vec3::new(turn.cos(), turn.sin(), 0.2 * random.f64()) * (4.0 + 26.0 * random.f64());
        obstacle(
            format!("far{index}"),
            Shape::cuboid(Vec3::splat(0.3)).expect("a size"),
            at,
        )
    })
}

/// Boxes in the arm's reach that its path clears.
fn near(count: usize) -> Case {
    among(
        wander("arm_shelf", 8, CLEARANCE_M),
        count,
        0,
        |random, index| {
            let mut coordinate = || random.f64() - 0.5;
            let at = Vec3::new(1.6 * coordinate(), 1.6 * coordinate(), 0.5 + coordinate());
            obstacle(
                format!("near{index}"),
                Shape::cuboid(Vec3::splat(0.04)).expect("a size"),
                at,
            )
        },
    )
}

/// A bumpy ball of so many triangles that the arm passes closely.
fn triangles(count: usize) -> Case {
    let mesh = Arc::new(bumpy_ball(count));
    among(wander("arm_shelf", 8, CLEARANCE_M), 1, 20, |random, _| {
        let mut coordinate = || random.f64() - 0.5;
        let at = Vec3::new(1.2 * coordinate(), 1.2 * coordinate(), 0.6 + coordinate());
        obstacle("bumpy".to_owned(), Shape::Mesh(mesh.clone()), at)
    })
}

/// A closed ball of radius 0.1 m with bumps, of `2 n²` triangles.
fn bumpy_ball(triangles: usize) -> Mesh {
    let n = (triangles as f64 / 2.0).sqrt() as u32;
    let point = |row: u32, column: u32| {
        let polar = f64::from(row) / f64::from(n + 1);
        let turn = f64::from(column) / f64::from(n);
        let polar = polar * std::f64::consts::PI;
        let turn = turn * std::f64::consts::TAU;
        let radius = 0.1 + 0.01 * (7.0 * polar).sin() * (5.0 * turn).sin();
        Vec3::new(
            polar.sin() * turn.cos(),
            polar.sin() * turn.sin(),
            polar.cos(),
        ) * radius
    };
    let mut vertices = vec![Vec3::Z * 0.1, -Vec3::Z * 0.1];
    vertices.extend(
        (1..=n)
            .flat_map(|row| (0..n).map(move |column| (row, column)))
            .map(|(r, c)| point(r, c)),
    );
    let index = |row: u32, column: u32| 2 + (row - 1) * n + column % n;
    let mut faces = Vec::new();
    for column in 0..n {
        faces.push([0, index(1, column), index(1, column + 1)]);
        faces.push([1, index(n, column + 1), index(n, column)]);
        for row in 1..n {
            faces.push([
                index(row, column),
                index(row + 1, column),
                index(row + 1, column + 1),
            ]);
            faces.push([
                index(row, column),
                index(row + 1, column + 1),
                index(row, column + 1),
            ]);
        }
    }
    Mesh::new("bumpy", vertices, faces).expect("a mesh with an area")
}

/// Counted tests of every case that is timed below.
fn count() {
    let mut scratch = Scratch::default();
    println!(
        "{:<34} {:>9} {:>9} {:>9} {:>9}",
        "tests of a proof", "intervals", "far", "near", "exact"
    );
    let mut line = |name: String, case: Case| {
        let (intervals, Queries { far, near, exact }) = case.prove(&mut scratch);
        println!("{name:<34} {intervals:>9} {far:>9} {near:>9} {exact:>9}");
    };
    SHIPPED
        .iter()
        .for_each(|name| line((*name).to_owned(), shipped(name)));
    WAYPOINTS.iter().for_each(|&n| {
        line(
            format!("{n} waypoints"),
            wander("arm_shelf", n, CLEARANCE_M),
        )
    });
    FAR_OBJECTS.iter().for_each(|&n| {
        line(
            format!("{n} far objects, arm"),
            far(shipped("arm_shelf"), n),
        )
    });
    FAR_OBJECTS.iter().for_each(|&n| {
        line(
            format!("{n} far objects, mobile base"),
            far(shipped("exchange_arms"), n),
        )
    });
    NEAR_OBJECTS
        .iter()
        .for_each(|&n| line(format!("{n} near objects"), near(n)));
    CLEARANCES_M
        .iter()
        .for_each(|&m| line(format!("clearance {m} m"), clear(m)));
    TRIANGLES
        .iter()
        .for_each(|&n| line(format!("{n} triangles"), triangles(n)));
    println!();
}

/// One walk for every clearance: it keeps the largest.
fn clear(clearance: f64) -> Case {
    Case {
        clearance,
        ..wander("arm_shelf", 8, 1.5 * CLEARANCES_M[CLEARANCES_M.len() - 1])
    }
}

fn time(bencher: Bencher, case: &Case) {
    let mut scratch = Scratch::default();
    bencher.bench_local(|| case.prove(&mut scratch));
}

#[divan::bench(args = SHIPPED)]
fn proof(bencher: Bencher, name: &str) {
    time(bencher, &shipped(name));
}

#[divan::bench(args = SHIPPED)]
fn refusal(bencher: Bencher, name: &str) {
    let case = shipped(name);
    let mut scratch = Scratch::default();
    bencher.bench_local(|| case.refuse(&mut scratch));
}

#[divan::bench(args = WAYPOINTS)]
fn waypoints(bencher: Bencher, count: usize) {
    time(bencher, &wander("arm_shelf", count, CLEARANCE_M));
}

#[divan::bench(args = FAR_OBJECTS)]
fn far_objects_of_an_arm(bencher: Bencher, count: usize) {
    time(bencher, &far(shipped("arm_shelf"), count));
}

#[divan::bench(args = FAR_OBJECTS)]
fn far_objects_of_a_mobile_base(bencher: Bencher, count: usize) {
    time(bencher, &far(shipped("exchange_arms"), count));
}

#[divan::bench(args = NEAR_OBJECTS)]
fn near_objects(bencher: Bencher, count: usize) {
    time(bencher, &near(count));
}

#[divan::bench(args = CLEARANCES_M)]
fn clearance(bencher: Bencher, metres: f64) {
    time(bencher, &clear(metres));
}

#[divan::bench(args = TRIANGLES)]
fn mesh_triangles(bencher: Bencher, count: usize) {
    time(bencher, &triangles(count));
}
