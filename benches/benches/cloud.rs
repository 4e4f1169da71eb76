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
use taut::optimize::{self, Mode, Outcome, Settings, Workspace};
use taut::path::Path;
use taut::robot::RobotModel;
use taut::scene::{Obstacle, Scene};
use taut::shape::{Cloud, PlacedShape, Shape};
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

fn measure(file: &File, clouds: &File, geometry: Geometry, modes: &[Mode], radius: f64) {
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
    for kind in KINDS {
        let file = clouds.join(format!(
            "{}.{kind}.bin",
            file.file_stem().expect("a file").display()
        ));
        let points = points(&file);
        let (build, cloud) = timed(5, || {
            Cloud::of_points(points.iter().copied(), radius).expect("a cloud")
        });
        let cloud = Arc::new(cloud);
        let (prepare, among) = timed(3, || among(&robot, cloud.clone()));
        let (check, outcome) = run(&among, path, Mode::Check, REPEAT);
        let (sample, free) = sampled(&among, path);
        println!(
            "  {kind:<5} {:>7} points: build {:.2} ms, model {:.2} ms, proof {:8.1} us = {:.2} of samples {:8.1} us ({free}), {}",
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
    let (Some(clouds), Some(problems)) = (folder("CLOUDS"), folder("PROBLEMS")) else {
        return;
    };
    let radius = std::env::var("RADIUS").map_or(0.0025, |text| text.parse().expect("metres"));
    let modes: Vec<Mode> = std::env::var("MODES")
        .unwrap_or_default()
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
    let mut names: Vec<_> = std::fs::read_dir(&clouds)
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
