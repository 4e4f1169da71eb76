//! Whole paths of robots with their exact shapes, among clouds of the scenes that they were planned
//! in, with the noise of a camera: nothing is proved that the points refute, looked at one by one.

use std::path::{Path as File, PathBuf};
use std::sync::Arc;

use fastrand::Rng;

use crate::collision::CollisionModel;
use crate::files::{Geometry, Packages, Problem, Reader};
use crate::math::{Pose, Vec3};
use crate::optimize::{self, Mode, Settings, Workspace};
use crate::path::Path;
use crate::robot::RobotModel;
use crate::scene::{Obstacle, Scene};
use crate::shape::{Cloud, Drawn, PlacedShape, Shape};
use crate::testing::{self, Oracle};
use crate::validation::certificate::Certificate;
use crate::validation::soundness::cases;

/// Places of each segment that are looked at.
const PLACES: u32 = 40;
const SCAN: &str = "scan";

/// A problem and its robot.
struct World {
    problem: Problem,
    robot: Arc<RobotModel>,
}

/// The shipped problems of arms, or those of the folder `TAUT_PROBLEMS`.
fn worlds() -> Vec<World> {
    let files = match std::env::var_os("TAUT_PROBLEMS") {
        Some(folder) => problems_in(File::new(&folder)),
        None => {
            let folder = File::new(env!("CARGO_MANIFEST_DIR")).join("config/problems");
            ["arm_shelf.json", "arm_window.json"]
                .map(|name| folder.join(name))
                .to_vec()
        }
    };
    let mut reader = Reader::new(Packages::default());
    let mut world = |file: &PathBuf| {
        let problem = reader.problem(file, Geometry::Given).unwrap();
        let robot = Arc::new(problem.model().unwrap());
        World { problem, robot }
    };
    files.iter().map(&mut world).collect()
}

fn problems_in(folder: &File) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let files = entries.map(|entry| entry.unwrap().path());
    let mut problems: Vec<_> = files
        .filter(|file| {
            file.extension()
                .is_some_and(|ending| ending == "json")
        })
        .collect();
    problems.sort();
    problems
}

/// A point on the surface of a shape, in its own frame.
fn on_surface(rng: &mut Rng, shape: &Shape) -> Vec3 {
    let any = testing::vector(rng, 1.0);
    match shape.drawn() {
        Drawn::Sphere { radius } => any.normalize_or_zero() * radius,
        Drawn::Box { size } => {
            let axis = rng.usize(0..3);
            let mut point = any * size / 2.0;
            point[axis] = (size[axis] / 2.0).copysign(any[axis]);
            point
        }
        Drawn::Cylinder { radius, length } | Drawn::Capsule { radius, length } => {
            let around = any.with_z(0.0).normalize_or_zero() * radius;
            around.with_z(any.z * length / 2.0)
        }
        Drawn::Mesh(mesh) => {
            let triangle = mesh.triangles()[rng.usize(..mesh.triangles().len())];
            let [a, b, c] = triangle.map(|corner| mesh.vertices()[corner as usize]);
            a.lerp(b, rng.f64()).lerp(c, rng.f64())
        }
    }
}

/// Points on what stands in a scene, each off by some millimetres.
fn scan(rng: &mut Rng, scene: &Scene) -> Vec<Vec3> {
    let shapes: Vec<_> = scene
        .obstacles()
        .iter()
        .flat_map(Obstacle::placed_shapes)
        .collect();
    let count = [1, 40, 200, 800][rng.usize(0..4)];
    let mut point = || {
        let placed = &shapes[rng.usize(..shapes.len())];
        let on = on_surface(rng, &placed.shape);
        placed.pose.transform_point(on) + testing::vector(rng, 3e-3)
    };
    (0..count).map(|_| point()).collect()
}

fn among(world: &World, points: &[Vec3], radius: f64) -> CollisionModel {
    let cloud = Cloud::of_points(points.iter().map(Vec3::to_array), radius).unwrap();
    let placed = PlacedShape {
        pose: Pose::identity(),
        shape: Shape::Cloud(Arc::new(cloud)),
    };
    let object = Obstacle::new(SCAN, vec![placed]);
    let scene = Scene::new(SCAN, vec![object], Vec::new(), Vec::new()).unwrap();
    CollisionModel::new(world.robot.clone(), Arc::new(scene)).unwrap()
}

/// Some waypoints of the planner's path, one behind the other, each moved by up to a tenth of a radian
/// or metre, within the limits.
fn path(rng: &mut Rng, world: &World) -> Path {
    let planned = &world.problem.path;
    let first = rng.usize(0..planned.len() - 1);
    let last = (first + rng.usize(1..6)).min(planned.len() - 1);
    let off = [0.0, 0.02, 0.1][rng.usize(0..3)];
    let space = world.robot.space();
    let mut rows = Vec::new();
    for waypoint in first..=last {
        let by: Vec<_> = (0..space.nv())
            .map(|_| testing::uniform(rng, -off, off))
            .collect();
        let mut row = vec![0.0; space.nq()];
        space.integrate(planned.waypoint(waypoint), &by, 1.0, &mut row);
        for (value, variable) in row.iter_mut().zip(world.robot.variables()) {
            *value = value.clamp(variable.lower, variable.upper);
        }
        rows.extend(row);
    }
    Path::from_rows(space.nq(), rows).unwrap()
}

fn certificate(model: &CollisionModel, path: &Path) -> Option<Certificate> {
    let settings = Settings {
        mode: Mode::Check,
        ..Settings::default()
    };
    let mut workspace = Workspace::default();
    let answer = optimize::run(
        model,
        path,
        &settings,
        &mut workspace,
        &mut || false,
        &mut |_| {},
    );
    answer.unwrap().certificate
}

/// Links that are not allowed to touch the cloud.
fn links_against_scan(model: &CollisionModel) -> Vec<usize> {
    let pairs = (0..model.pairs().len()).map(|pair| model.pair_names(pair));
    let against = pairs.filter_map(|[a, b]| match (a.as_ref(), b.as_ref()) {
        (SCAN, link) | (link, SCAN) => model.robot().link_index(link),
        _ => None,
    });
    against.collect()
}

#[test]
fn whole_paths_that_are_proved_keep_clear_of_every_point() {
    let (count, mut rng) = cases(60);
    let worlds = worlds();
    let [mut proved, mut refused, mut looked_at] = [0, 0, 0];
    for case in 0..count {
        let world = &worlds[rng.usize(0..worlds.len())];
        let points = scan(&mut rng, &world.problem.scene);
        let radius = testing::uniform(&mut rng, 0.002, 0.02);
        let model = among(world, &points, radius);
        let path = path(&mut rng, world);
        let Some(certificate) = certificate(&model, &path) else {
            refused += 1;
            continue;
        };
        proved += 1;
        let links = links_against_scan(&model);
        let oracle = Oracle::new(&model);
        let space = world.robot.space();
        let mut velocity = vec![0.0; space.nv()];
        let mut q = vec![0.0; space.nq()];
        for (segment, claim) in certificate.segments.iter().enumerate() {
            let from = path.waypoint(segment);
            space.difference(path.waypoint(segment + 1), from, &mut velocity);
            let claim = claim
                .clearance_m
                .unwrap_or(certificate.clearance_m);
            for place in 0..=PLACES {
                let t = f64::from(place) / f64::from(PLACES);
                space.integrate(from, &velocity, t, &mut q);
                let least = oracle.least_to_points(&model, &links, &points, &q) - radius;
                assert!(
                    least >= claim - 1e-6,
                    "case {case}, {}: {least} in segment {segment} at {t} where {claim} is proved",
                    world.problem.name
                );
                looked_at += 1;
            }
        }
    }
    println!("{proved} proved, {refused} refused, {looked_at} places looked at");
    assert!(
        proved > count / 10 && refused > count / 20,
        "{proved}, {refused}"
    );
}
