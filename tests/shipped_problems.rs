//! Every problem and scene of `config/` can be read, and every path of a problem is proved.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::files::{Geometry, Packages, Problem, Reader};
use taut::optimize::{self, Mode, Outcome, Settings, Workspace};
use taut::path;

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("config").join(folder);
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn check(problem: &Problem, path: &path::Path) -> Outcome {
    let robot = Arc::new(problem.model().unwrap());
    let model = CollisionModel::new(robot, Arc::new(problem.scene.clone())).unwrap();
    let settings = Settings { mode: Mode::Check, strict: true, ..Settings::default() };
    optimize::run(&model, path, &settings, &mut Workspace::default(), &mut || false, &mut |_| {}).unwrap()
}

#[test]
fn every_shipped_path_is_proved_and_its_straight_line_collides() {
    for file in files("problems") {
        let problem = Reader::new(Packages::default()).problem(&file, Geometry::Given).unwrap();
        assert_eq!(Some(problem.name.as_str()), file.file_stem().and_then(|stem| stem.to_str()));
        assert!(check(&problem, &problem.path).proved, "{}", problem.name);
        let ends = [problem.path.waypoint(0), problem.path.waypoint(problem.path.len() - 1)].concat();
        let line = path::Path::from_rows(problem.path.nq(), ends).unwrap();
        assert!(!check(&problem, &line).proved, "{} is too easy", problem.name);
    }
}

#[test]
fn shipped_robots_and_scenes_are_read_without_a_warning() {
    for file in files("robots").iter().filter(|file| file.extension().is_some_and(|e| e == "urdf")) {
        let robot = Reader::default().robot(file, Some(&file.with_extension("srdf"))).unwrap();
        let model = taut::robot::RobotModel::new(robot).unwrap();
        assert!(model.warnings().is_empty(), "{}: {:?}", file.display(), model.warnings());
    }
    for file in files("scenes") {
        assert!(Reader::default().scene(&file).unwrap().warnings().is_empty(), "{}", file.display());
    }
}
