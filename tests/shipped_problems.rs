//! Every problem and scene of `config/` can be read, and every path of a problem is proved.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::files::{Geometry, Packages, Problem, Reader};
use taut::optimize::{self, Mode, Outcome, RequestError, Settings, Workspace};
use taut::path;

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("config")
        .join(folder);
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn shorten(name: &str, mode: Mode) -> (Problem, Outcome) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("config/problems")
        .join(name);
    let problem = Reader::new(Packages::default())
        .problem(&file, Geometry::Given)
        .unwrap();
    let model = CollisionModel::new(
        Arc::new(problem.model().unwrap()),
        Arc::new(problem.scene.clone()),
    )
    .unwrap();
    let settings = Settings {
        mode,
        ..Settings::default()
    };
    let outcome = optimize::run(
        &model,
        &problem.path,
        &settings,
        &mut Workspace::default(),
        &mut || false,
        &mut |_| {},
    );
    (problem, outcome.unwrap())
}

/// `None` where the path does not say how it moves: a quaternion turns by half a turn.
fn check(problem: &Problem, path: &path::Path) -> Option<Outcome> {
    let robot = Arc::new(problem.model().unwrap());
    let model = CollisionModel::new(robot, Arc::new(problem.scene.clone())).unwrap();
    let settings = Settings {
        mode: Mode::Check,
        strict: true,
        ..Settings::default()
    };
    match optimize::run(
        &model,
        path,
        &settings,
        &mut Workspace::default(),
        &mut || false,
        &mut |_| {},
    ) {
        Err(RequestError::HalfTurn { .. }) => None,
        outcome => Some(outcome.unwrap()),
    }
}

#[test]
fn every_shipped_path_is_proved_and_its_straight_line_collides() {
    for file in files("problems") {
        let problem = Reader::new(Packages::default())
            .problem(&file, Geometry::Given)
            .unwrap();
        assert_eq!(
            Some(problem.name.as_str()),
            file.file_stem().and_then(|stem| stem.to_str())
        );
        assert!(
            check(&problem, &problem.path).unwrap().proved,
            "{}",
            problem.name
        );
        let ends = [
            problem.path.waypoint(0),
            problem.path.waypoint(problem.path.len() - 1),
        ]
        .concat();
        let line = path::Path::from_rows(problem.path.nq(), ends).unwrap();
        assert!(
            check(&problem, &line).is_none_or(|outcome| !outcome.proved),
            "{} is too easy",
            problem.name
        );
    }
}

#[test]
fn shipped_robots_and_scenes_are_read_without_a_warning() {
    for file in files("robots")
        .iter()
        .filter(|file| file.extension().is_some_and(|e| e == "urdf"))
    {
        let robot = Reader::default()
            .robot(file, Some(&file.with_extension("srdf")))
            .unwrap();
        let model = taut::robot::RobotModel::new(robot).unwrap();
        assert!(
            model.warnings().is_empty(),
            "{}: {:?}",
            file.display(),
            model.warnings()
        );
    }
    for file in files("scenes") {
        assert!(
            Reader::default()
                .scene(&file)
                .unwrap()
                .warnings()
                .is_empty(),
            "{}",
            file.display()
        );
    }
}

/// The paper's Fig. 1: two arms change places; the base, which the planner sent around, need not
/// move.
#[test]
fn the_base_stands_still_while_the_arms_change_places() {
    let (problem, outcome) = shorten("exchange_arms.json", Mode::Gradient);
    let travel = |path: &path::Path| -> f64 {
        let rows: Vec<&[f64]> = path.waypoints().collect();
        rows.windows(2)
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
            .sum()
    };
    let before = travel(&problem.path);
    let after = travel(&outcome.path);
    assert!(outcome.proved && before > 2.0, "{before} m before");
    assert!(after < 0.05 * before, "{after} m of {before} m are left");
}

/// The paper's Fig. 2: along the walls no shortcut is free and shorter, and the shortest path lies
/// in the plane of the ends.
#[test]
fn the_slalom_is_pulled_into_the_plane_of_its_ends_where_shortcuts_gain_nothing() {
    // Shortest curve in the plane around the walls grown by the base's radius, found by relaxing a
    // string of 2,240 pieces (the radius without clearance, so a proved path must be a little
    // longer).
    const PLANE_OPTIMUM: f64 = 12.272;
    let (_, outcome) = shorten("slalom.json", Mode::Gradient);
    assert!(
        outcome.proved && outcome.length_after < 1.02 * PLANE_OPTIMUM,
        "{} left",
        outcome.length_after
    );
    let (_, random) = shorten("slalom.json", Mode::RandomShortcut);
    assert!(
        random.length_after > 0.99 * random.length_before,
        "{} of {}",
        random.length_after,
        random.length_before
    );
}

/// Each part of a run is credited with what it gained: together they gained all of it.
#[test]
fn the_gains_of_the_stages_are_the_gain() {
    for name in ["arm_shelf.json", "corner.json", "rooms.json", "slalom.json"] {
        for mode in Mode::ALL {
            let (_, outcome) = shorten(name, mode);
            let gain = outcome.length_before - outcome.length_after;
            let sum = outcome
                .stages
                .iter()
                .map(|share| share.gain)
                .sum::<f64>();
            assert!(
                (gain - sum).abs() < 1e-9 * outcome.length_before,
                "{name}, {}: {gain} or {sum}",
                mode.name()
            );
            assert!(
                outcome
                    .stages
                    .iter()
                    .all(|share| share.gain >= 0.0),
                "{name}: {:?}",
                outcome.stages
            );
            let iterations: u64 = outcome
                .stages
                .iter()
                .map(|share| share.iterations)
                .sum();
            assert!(
                iterations <= outcome.iterations,
                "{name}: {iterations} of {}",
                outcome.iterations
            );
        }
    }
}

/// Shortcuts leap out of the minimum that the half-spaces end in; they must not cost what the
/// half-spaces gain.
#[test]
fn turns_end_no_longer_than_half_spaces_alone() {
    for name in [
        "arm_shelf.json",
        "corner.json",
        "ell_window.json",
        "rooms.json",
        "slalom.json",
    ] {
        let [contact, hybrid] =
            [Mode::Contact, Mode::Hybrid].map(|mode| shorten(name, mode).1.length_after);
        println!("{name}: contact {contact:.4}, hybrid {hybrid:.4}");
        assert!(
            hybrid < 1.02 * contact,
            "{name}: {hybrid}, but {contact} by half-spaces alone"
        );
    }
}
