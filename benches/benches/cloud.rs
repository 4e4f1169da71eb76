//! What a cloud costs: `cargo bench --bench cloud`.
//!
//! Clouds are samples of the surfaces of shipped scenes, with the noise of a depth camera; or, with
//! `CLOUDS=FOLDER PROBLEMS=FOLDER`, files `NAME.KIND.bin` (x, y, z in f32) of problems `NAME.json`.
//! CPU time of this thread, medians.

use std::path::{Path as File, PathBuf};
use std::sync::Arc;

use rustix::time::{ClockId, clock_gettime};
use taut::collision::CollisionModel;
use taut::files::{Geometry, Packages, Problem, Reader};
use taut::math::Vec3;
use taut::optimize::{self, Mode, Outcome, Settings, Workspace};
use taut::path::Path;
use taut::robot::RobotModel;
use taut::scene::{Obstacle, Scene};
use taut::shape::{Cloud, Drawn, PlacedShape, Shape};
use taut::validation::{Scratch, Validator};

const REPEAT: usize = 15;
const KINDS: [&str; 4] = ["10k", "100k", "one", "all"];

fn cpu_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Median CPU time (s) and the last result.
fn timed<T>(repeat: usize, mut what: impl FnMut() -> T) -> (f64, T) {
    let mut times = Vec::new();
    let mut last = None;
    for _ in 0..repeat {
        let start = cpu_s();
        last = Some(what());
        times.push(cpu_s() - start);
    }
    times.sort_by(f64::total_cmp);
    (times[times.len() / 2], last.expect("it was done"))
}

fn points(file: &File) -> Vec<[f64; 3]> {
    let bytes = std::fs::read(file).expect("the cloud is there");
    let number = |at: &[u8]| f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]]));
    bytes
        .chunks_exact(12)
        .map(|point| [number(point), number(&point[4..]), number(&point[8..])])
        .collect()
}

/// A point on the surface of a shape, in its own frame.
fn on_surface(shape: &Shape, random: &mut fastrand::Rng) -> Vec3 {
    let mut within = |half: f64| half * (2.0 * random.f64() - 1.0);
    let any = Vec3::new(within(1.0), within(1.0), within(1.0));
    match shape.drawn() {
        Drawn::Sphere { radius } => any.normalize_or_zero() * radius,
        Drawn::Box { size } => {
            let axis = random.usize(0..3);
            let mut point = any * size / 2.0;
            point[axis] = (size[axis] / 2.0).copysign(any[axis]);
            point
        }
        Drawn::Cylinder { radius, length } | Drawn::Capsule { radius, length } => {
            let around = any.with_z(0.0).normalize_or_zero() * radius;
            around.with_z(any.z * length / 2.0)
        }
        Drawn::Mesh(mesh) => {
            let triangle = mesh.triangles()[random.usize(..mesh.triangles().len())];
            let [a, b, c] = triangle.map(|corner| mesh.vertices()[corner as usize]);
            a.lerp(b, random.f64()).lerp(c, random.f64())
        }
    }
}

/// So many points on what stands in a scene, each off by some tenths of a millimetre.
fn sampled_surfaces(scene: &Scene, count: usize) -> Vec<[f64; 3]> {
    let mut random = fastrand::Rng::with_seed(1);
    let shapes: Vec<_> = scene
        .obstacles()
        .iter()
        .flat_map(Obstacle::placed_shapes)
        .collect();
    let mut point = || {
        let placed = &shapes[random.usize(..shapes.len())];
        let at = placed
            .pose
            .transform_point(on_surface(&placed.shape, &mut random));
        let noise = Vec3::new(random.f64(), random.f64(), random.f64()) - 0.5;
        (at + noise * 4e-4).to_array()
    };
    (0..count).map(|_| point()).collect()
}

fn model(robot: &Arc<RobotModel>, scene: Scene) -> CollisionModel {
    CollisionModel::new(robot.clone(), Arc::new(scene)).expect("robot and scene go together")
}

fn among(robot: &Arc<RobotModel>, cloud: Arc<Cloud>) -> CollisionModel {
    let pose = taut::math::Pose::identity();
    let shape = Shape::Cloud(cloud);
    let object = Obstacle::new("cloud", vec![PlacedShape { pose, shape }]);
    let scene = Scene::new("cloud", vec![object], Vec::new(), Vec::new());
    model(robot, scene.expect("a cloud is an object"))
}

fn run(model: &CollisionModel, path: &Path, mode: Mode, repeat: usize) -> (f64, Outcome) {
    let mut workspace = Workspace::default();
    let settings = Settings {
        mode,
        contacts: false,
        ..Settings::default()
    };
    timed(repeat, || {
        let mut never = || false;
        optimize::run(
            model,
            path,
            &settings,
            &mut workspace,
            &mut never,
            &mut |_| {},
        )
        .expect("the request is sound")
    })
}

fn sampled(model: &CollisionModel, path: &Path) -> (f64, bool) {
    const HELD: [f64; 16] = [0.0; 16];
    let mut scratch = Scratch::default();
    let robot = model.robot();
    let held = &HELD[..robot.held().len()];
    timed(REPEAT, || {
        let mut validator = Validator::new(model, robot.space(), held, 1e-3, &mut scratch);
        validator.samples_are_free(path, 1.0 / 32.0)
    })
}

fn told(outcome: &Outcome) -> String {
    let lowered = outcome.floors_lowered.len();
    format!(
        "{} {:.3} ({lowered} lowered, {} work)",
        if outcome.proved { "proved" } else { "refused" },
        outcome.length_after / outcome.length_before,
        outcome.work
    )
}

/// Clouds of a problem, by kind.
type Clouds<'a> = dyn Fn(&Problem) -> Vec<(String, Vec<[f64; 3]>)> + 'a;

fn measure(file: &File, clouds: &Clouds<'_>, geometry: Geometry, modes: &[Mode], radius: f64) {
    let problem: Problem = Reader::new(Packages::default())
        .problem(file, geometry)
        .expect("the problem reads");
    let robot = Arc::new(problem.model().expect("the robot is sound"));
    let exact = model(&robot, problem.scene.clone());
    let path = &problem.path;
    println!("{} ({geometry:?})", problem.name);
    let (check, outcome) = run(&exact, path, Mode::Check, REPEAT);
    let (sample, _) = sampled(&exact, path);
    println!(
        "  exact   proof {:8.1} us  samples {:8.1} us  {}",
        check * 1e6,
        sample * 1e6,
        told(&outcome)
    );
    let exact_times: Vec<_> = modes
        .iter()
        .map(|mode| run(&exact, path, *mode, 3))
        .collect();
    for (kind, points) in clouds(&problem) {
        let (build, cloud) = timed(5, || {
            Cloud::of_points(points.iter().copied(), radius).expect("a cloud")
        });
        let cloud = Arc::new(cloud);
        let (prepare, among) = timed(3, || among(&robot, cloud.clone()));
        let (check, outcome) = run(&among, path, Mode::Check, REPEAT);
        let (sample, free) = sampled(&among, path);
        println!(
            "  {kind:<7} {:>7} points: build {:.2} ms, model {:.2} ms, proof {:8.1} us = {:.2} of samples {:8.1} us ({free}), {}",
            points.len(),
            build * 1e3,
            prepare * 1e3,
            check * 1e6,
            check / sample,
            sample * 1e6,
            told(&outcome)
        );
        for (mode, (exact_s, exact)) in modes.iter().zip(&exact_times) {
            let (time, outcome) = run(&among, path, *mode, 3);
            println!(
                "        {:<18} {:9.2} ms = {:.2} of {:9.2} ms; {} against {}",
                mode.name(),
                time * 1e3,
                time / exact_s,
                exact_s * 1e3,
                told(&outcome),
                told(exact)
            );
        }
    }
}

fn main() {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from);
    let radius = std::env::var("RADIUS").map_or(0.0025, |text| text.parse().expect("metres"));
    let asked = std::env::var("MODES").unwrap_or_else(|_| "contact,hybrid".to_owned());
    let modes: Vec<Mode> = asked
        .split(',')
        .filter_map(|name| {
            Mode::ALL
                .into_iter()
                .find(|mode| mode.name() == name)
        })
        .collect();
    let geometry = match std::env::var("MESHES") {
        Ok(_) => Geometry::Given,
        Err(_) => Geometry::Spheres,
    };
    let (Some(recorded), Some(problems)) = (folder("CLOUDS"), folder("PROBLEMS")) else {
        let problems = File::new(env!("CARGO_MANIFEST_DIR")).join("../config/problems");
        let sizes = [10_000, 100_000, 1_000_000];
        let clouds = |problem: &Problem| {
            let sampled =
                |count: usize| (count.to_string(), sampled_surfaces(&problem.scene, count));
            sizes.map(sampled).into()
        };
        for name in ["arm_shelf", "arm_window"] {
            let file = problems.join(format!("{name}.json"));
            measure(&file, &clouds, Geometry::Given, &modes, radius);
        }
        return;
    };
    let clouds = |problem: &Problem| {
        let name = problem
            .file
            .file_stem()
            .expect("a file")
            .display()
            .to_string();
        let file = |kind| recorded.join(format!("{name}.{kind}.bin"));
        KINDS
            .map(|kind| (kind.to_owned(), points(&file(kind))))
            .into()
    };
    let mut names: Vec<_> = std::fs::read_dir(&recorded)
        .expect("the folder is there")
        .filter_map(|entry| {
            Some(
                entry
                    .ok()?
                    .file_name()
                    .to_str()?
                    .strip_suffix(".10k.bin")?
                    .to_owned(),
            )
        })
        .filter(|name| {
            std::env::var("ONLY").is_ok_and(|only| name.contains(&only))
                || std::env::var("ONLY").is_err()
        })
        .collect();
    names.sort();
    for name in names {
        measure(
            &problems.join(format!("{name}.json")),
            &clouds,
            geometry,
            &modes,
            radius,
        );
    }
}
