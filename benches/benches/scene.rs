//! What a change to a scene costs, and how that grows with the scene: `cargo bench --bench scene`.
//!
//! First the memory that versions take, counted; then times: of a new version of the scene, and of
//! its collision model with the shipped arm. Objects are boxes and balls, half of them in the arm's
//! reach.

use std::path::Path as File;
use std::sync::Arc;

use divan::{Bencher, black_box};
use taut::collision::CollisionModel;
use taut::files::{Geometry, Packages, Reader};
use taut::math::{Pose, Vec3, quat_exp};
use taut::robot::RobotModel;
use taut::scene::{Obstacle, Scene, SceneChange};
use taut::shape::{PlacedShape, Shape};

const OBJECTS: [usize; 4] = [10, 100, 1000, 10_000];
const IN_DIFF: usize = 100;

fn main() {
    if !std::env::args().any(|argument| argument == "--list") {
        memory();
    }
    divan::main();
}

fn somewhere(random: &mut fastrand::Rng) -> Pose {
    let mut coordinate = || random.f64() - 0.5;
    let at = Vec3::new(coordinate(), coordinate(), coordinate());
    let turn = Vec3::new(coordinate(), coordinate(), coordinate());
    let size = if random.bool() { 1.6 } else { 20.0 };
    Pose::from_parts(at * size, quat_exp(turn))
}

fn object(random: &mut fastrand::Rng, id: String) -> Obstacle {
    let size = 0.02 + 0.05 * random.f64();
    let shape = if random.bool() {
        Shape::cuboid(Vec3::splat(size))
    } else {
        Shape::sphere(size)
    };
    let placed = PlacedShape {
        pose: Pose::identity(),
        shape: shape.expect("a size"),
    };
    Obstacle::new(id, vec![placed]).at(somewhere(random))
}

fn scene(count: usize) -> Arc<Scene> {
    let mut random = fastrand::Rng::with_seed(5);
    let obstacles = (0..count)
        .map(|index| object(&mut random, format!("object{index}")))
        .collect();
    Arc::new(
        Scene::new("bench", obstacles, Vec::new(), Vec::new()).expect("the obstacles are solids"),
    )
}

fn move_any(random: &mut fastrand::Rng, count: usize) -> SceneChange {
    SceneChange::Move {
        id: format!("object{}", random.usize(..count)),
        pose: somewhere(random),
    }
}

fn changed(scene: &Scene, changes: impl IntoIterator<Item = SceneChange>) -> Scene {
    scene
        .with(changes)
        .expect("the objects are there")
}

fn robot() -> Arc<RobotModel> {
    let file = File::new(env!("CARGO_MANIFEST_DIR")).join("../config/problems/arm_shelf.json");
    let problem = Reader::new(Packages::default())
        .problem(&file, Geometry::Given)
        .expect("the problem is shipped");
    Arc::new(problem.model().expect("the robot is shipped"))
}

fn model(count: usize) -> CollisionModel {
    CollisionModel::new(robot(), scene(count)).expect("the scene names nothing")
}

/// Bytes that a thousand versions keep, each a MOVE after the one before.
fn memory() {
    const VERSIONS: usize = 1000;
    println!(
        "{:<34} {:>12} {:>22}",
        "memory", "first (B)", "each version more (B)"
    );
    for count in OBJECTS {
        let mut versions = Vec::with_capacity(VERSIONS + 1);
        let first = allocation_counter::measure(|| versions.push(scene(count)));
        let mut random = fastrand::Rng::with_seed(9);
        let more = allocation_counter::measure(|| {
            for _ in 0..VERSIONS {
                let next = changed(
                    &versions[versions.len() - 1],
                    [move_any(&mut random, count)],
                );
                versions.push(Arc::new(next));
            }
        });
        let each = more.bytes_current / VERSIONS as i64;
        println!(
            "{:<34} {:>12} {each:>22}",
            format!("{VERSIONS} versions of {count} objects"),
            first.bytes_current
        );
    }
    println!();
}

/// Times a change that is made to one scene again and again; changes and versions are made and
/// dropped outside.
fn time<T>(bencher: Bencher, mut input: impl FnMut() -> T, mut made: impl FnMut(T) -> Scene) {
    bencher
        .with_inputs(&mut input)
        .bench_local_values(|value| black_box(made(value)));
}

#[divan::bench(args = OBJECTS)]
fn move_one(bencher: Bencher, count: usize) {
    let scene = scene(count);
    let mut random = fastrand::Rng::with_seed(1);
    time(
        bencher,
        || move_any(&mut random, count),
        |change| changed(&scene, [change]),
    );
}

#[divan::bench(args = OBJECTS)]
fn add_one(bencher: Bencher, count: usize) {
    let scene = scene(count);
    let mut random = fastrand::Rng::with_seed(2);
    time(
        bencher,
        || object(&mut random, "another".to_owned()),
        |new| changed(&scene, [SceneChange::Add(new)]),
    );
}

#[divan::bench(args = OBJECTS)]
fn remove_one(bencher: Bencher, count: usize) {
    let scene = scene(count);
    let mut random = fastrand::Rng::with_seed(3);
    let id = || format!("object{}", random.usize(..count));
    time(bencher, id, |id| {
        changed(&scene, [SceneChange::Remove { id }])
    });
}

#[divan::bench(args = OBJECTS)]
fn move_a_hundred(bencher: Bencher, count: usize) {
    let scene = scene(count);
    let mut random = fastrand::Rng::with_seed(4);
    let changes = || {
        (0..IN_DIFF)
            .map(|_| move_any(&mut random, count))
            .collect::<Vec<_>>()
    };
    time(bencher, changes, |changes| changed(&scene, changes));
}

#[divan::bench(args = OBJECTS)]
fn find_the_changes(bencher: Bencher, count: usize) {
    let scene = scene(count);
    let mut random = fastrand::Rng::with_seed(6);
    let other = changed(&scene, (0..10).map(|_| move_any(&mut random, count)));
    bencher.bench_local(|| scene.changes_to(&other));
}

#[divan::bench(args = OBJECTS, sample_count = 20)]
fn model_from_nothing(bencher: Bencher, count: usize) {
    let robot = robot();
    let scene = scene(count);
    bencher.bench_local(|| CollisionModel::new(robot.clone(), scene.clone()));
}

#[divan::bench(args = OBJECTS)]
fn model_after_a_move(bencher: Bencher, count: usize) {
    let model = model(count);
    let mut random = fastrand::Rng::with_seed(7);
    let moved = || Arc::new(changed(model.scene(), [move_any(&mut random, count)]));
    bencher
        .with_inputs(moved)
        .bench_local_values(|scene| model.with_scene(scene));
}

#[divan::bench(args = OBJECTS)]
fn model_after_an_add(bencher: Bencher, count: usize) {
    let model = model(count);
    let mut random = fastrand::Rng::with_seed(8);
    let added = || {
        Arc::new(changed(
            model.scene(),
            [SceneChange::Add(object(&mut random, "another".to_owned()))],
        ))
    };
    bencher
        .with_inputs(added)
        .bench_local_values(|scene| model.with_scene(scene));
}
