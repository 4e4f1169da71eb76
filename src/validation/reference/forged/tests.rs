//! Certificates of paths beside scans, forged by someone who computes the digest anew.

use super::super::*;
use crate::math::{Pose, Vec3};
use crate::optimize::{self, Mode, Settings, Workspace};
use crate::scene::{Obstacle, SceneChange};
use crate::shape::{Cloud, PlacedShape, Shape, Voxel};
use crate::testing;

/// Radius (m) of the ball that goes from x = -1 to 1.
const BALL_M: f64 = 0.05;
/// Radius of points, and half size of voxels (m).
const CELL_M: f64 = 0.01;
/// Where a map's grid has its cells, and coordinates of f32 are a quarter of a metre apart (m).
const FAR: Vec3 = Vec3::new(5.1e5, 5.4e6, 130.0);

/// Places along the ball's way, so far beside it; one of them is nearer by `nearer`.
fn places(y: f64, nearer: f64) -> Vec<Vec3> {
    let place = |index: u32| {
        let moved = if index == 17 { nearer } else { 0.0 };
        FAR + Vec3::new(-1.0 + 0.05 * f64::from(index), y - moved, 0.0)
    };
    (0..40).map(place).collect()
}

fn points(y: f64, nearer: f64) -> Cloud {
    let places = places(y, nearer);
    Cloud::of_points(places.iter().map(Vec3::to_array), CELL_M).unwrap()
}

fn voxels(y: f64, nearer: f64) -> Cloud {
    let voxel = |place: &Vec3| Voxel {
        center: place.to_array(),
        size: 2.0 * CELL_M,
    };
    let voxels: Vec<_> = places(y, nearer).iter().map(voxel).collect();
    Cloud::of_voxels(&voxels).unwrap()
}

/// The ball beside a scan.
fn beside(scan: Cloud) -> CollisionModel {
    let alone = testing::slider(&[]);
    let shape = PlacedShape {
        pose: Pose::identity(),
        shape: Shape::Cloud(scan.into()),
    };
    let scan = Obstacle::new("scan".to_owned(), vec![shape]).at(Pose::from_translation(-FAR));
    let scene = alone
        .scene()
        .with([SceneChange::Add(scan)])
        .unwrap();
    CollisionModel::new(alone.robot().clone(), scene.into()).unwrap()
}

fn way() -> Path {
    Path::from_rows(2, vec![-1.0, 0.0, 1.0, 0.0]).unwrap()
}

fn proved(model: &CollisionModel) -> Certificate {
    let settings = Settings {
        mode: Mode::Check,
        ..Settings::default()
    };
    let mut workspace = Workspace::default();
    let answer = optimize::run(
        model,
        &way(),
        &settings,
        &mut workspace,
        &mut || false,
        &mut |_| {},
    );
    answer.unwrap().certificate.unwrap()
}

fn verdict(model: &CollisionModel, certificate: &Certificate) -> Result<Effort, Objection> {
    verify(model, &way(), certificate, &mut || false, &mut |_| {})
}

/// The same claims of the scan of another scene.
fn of_other(certificate: &Certificate, model: &CollisionModel) -> Certificate {
    Certificate {
        scene_hash: model.scene().hash(),
        ..certificate.clone()
    }
    .sealed()
}

#[test]
fn a_scan_with_a_moved_point_is_another_scene_and_its_claims_are_seen_through() {
    for scan in [points, voxels] {
        let model = beside(scan(0.3, 0.0));
        let certificate = proved(&model);
        verdict(&model, &certificate).unwrap();
        // Into the ball's way; nearer than is claimed; nearer by a hair.
        for nearer in [0.28, 0.1, 1e-3] {
            let moved = beside(scan(0.3, nearer));
            let objection = verdict(&moved, &certificate).unwrap_err();
            assert!(
                matches!(objection, Objection::Other { kind: "scene", .. }),
                "{objection}"
            );
            let objection = verdict(&moved, &of_other(&certificate, &moved)).map(|_| ());
            let kept = 0.3 - nearer - BALL_M - CELL_M;
            let claimed = certificate.segments[0].clearance_m.unwrap();
            match kept < claimed {
                true => assert!(
                    matches!(objection, Err(Objection::Less(_) | Objection::NotProved(_))),
                    "{nearer}: {objection:?}"
                ),
                false => assert_eq!(objection, Ok(())),
            }
        }
    }
}

#[test]
fn a_larger_clearance_from_a_scan_is_refused() {
    for scan in [points, voxels] {
        let model = beside(scan(0.2, 0.0));
        let certificate = proved(&model);
        let kept = 0.2 - BALL_M - CELL_M;
        let claiming = |clearance_m: f64| {
            let mut forged = certificate.clone();
            forged.segments[0].clearance_m = Some(clearance_m);
            verdict(&model, &forged.sealed())
        };
        claiming(kept - 1e-4).unwrap();
        for more in [1.1 * RESOLUTION_M, 1e-3, 1.0] {
            let objection = claiming(kept + more).unwrap_err();
            assert!(
                matches!(objection, Objection::Less(_)),
                "{more}: {objection}"
            );
        }
    }
}
