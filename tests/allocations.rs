//! A warm check allocates nothing: not to prove a path, not to refuse one.

use std::path::Path as File;
use std::sync::Arc;

use taut::collision::CollisionModel;
use taut::files::{Geometry, Packages, Problem, Reader};
use taut::path::Path;
use taut::validation::{Scratch, SegmentVerdict, SegmentsVerdict, Validator};

fn problem(name: &str) -> (Problem, CollisionModel) {
    let file = File::new(env!("CARGO_MANIFEST_DIR"))
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
    (problem, model)
}

/// Proves the path, refuses the straight way from its first to its last waypoint, and looks for the
/// first hit.
fn check(model: &CollisionModel, path: &Path, scratch: &mut Scratch) -> (SegmentsVerdict, bool) {
    let robot = model.robot();
    let held = [0.0; 16];
    let held = &held[..robot.held().len()];
    let mut validator = Validator::new(model, robot.space(), held, 1e-3, scratch);
    let proved = validator.segments(path.segments(), &mut || false);
    let first = path.waypoint(0);
    let last = path.waypoint(path.len() - 1);
    let straight = validator.proves(first, last, &mut || false);
    let hit = validator.first_hit(first, last, &mut || false);
    (
        proved,
        straight == Some(false) && matches!(hit, SegmentVerdict::Refused(_)),
    )
}

#[test]
fn a_warm_check_allocates_nothing() {
    for name in [
        "arm_shelf.json",
        "arm_window.json",
        "ell_window.json",
        "exchange_arms.json",
        "rooms.json",
    ] {
        let (problem, model) = problem(name);
        let mut scratch = Scratch::default();
        let cold = check(&model, &problem.path, &mut scratch);
        let mut warm = (SegmentsVerdict::Stopped, false);
        let counted =
            allocation_counter::measure(|| warm = check(&model, &problem.path, &mut scratch));
        assert_eq!(warm, cold, "{name}");
        assert_eq!(cold, (SegmentsVerdict::Proved, true), "{name}");
        assert_eq!(counted.count_total, 0, "{name}: {counted:?}");
    }
}
