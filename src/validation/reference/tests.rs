//! Every certificate of the validator is verified, every forged one refused, for the right reason.

use fastrand::Rng;

use super::*;
use crate::optimize::{self, Mode, Settings, Workspace};
use crate::testing::{self, Oracle};
use crate::validation::soundness::cases;
use crate::validation::{Certificate, SegmentClaim};

/// A random model, a path and its certificate; `None` where the path is refused.
fn proved(rng: &mut Rng) -> Option<(CollisionModel, Path, Certificate)> {
    let model = testing::model(rng);
    let robot = model.robot();
    if robot.space().nq() == 0 {
        return None;
    }
    let mut rows = testing::configuration(rng, robot);
    let mut at = rows.clone();
    for _ in 0..rng.usize(0..4) {
        at = if rng.f64() < 0.2 { at } else { testing::neighbour(rng, robot, &at) };
        rows.extend_from_slice(&at);
    }
    let path = Path::from_rows(robot.space().nq(), rows)?;
    let clearance_m = [1e-3, 1e-4, 2e-2][rng.usize(0..3)];
    let settings = Settings { mode: Mode::Check, clearance_m, unwrapped: rng.bool(), ..Settings::default() };
    let answer = optimize::run(&model, &path, &settings, &mut Workspace::default(), &mut || false, &mut |_| {});
    let certificate = answer.ok()?.certificate?;
    Some((model, path, certificate))
}

fn verified(model: &CollisionModel, path: &Path, certificate: &Certificate) -> Result<Effort, Objection> {
    verify(model, path, certificate, &mut || false, &mut |_| {})
}

#[test]
fn what_the_validator_proves_is_verified() {
    let (count, mut rng) = cases(600);
    let (mut met, mut lowered, mut effort) = (0, 0, Effort::default());
    for case in 0..count {
        let Some((model, path, certificate)) = proved(&mut rng) else { continue };
        let found = verified(&model, &path, &certificate);
        let found = found.unwrap_or_else(|objection| panic!("case {case}: {objection}"));
        met += 1;
        lowered += usize::from(!certificate.lowered.is_empty());
        effort.intervals += found.intervals;
        effort.distances += found.distances;
    }
    println!("{met} certificates, {lowered} with lowered floors, {effort:?}");
    assert!(met > count / 6 && lowered > 0);
}
