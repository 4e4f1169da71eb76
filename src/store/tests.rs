use std::sync::atomic::Ordering;

use super::*;
use crate::collision::Count;
use crate::robot::{LinkDescription, RobotDescription};
use crate::scene::Obstacle;

fn id_of(label: &str) -> u64 {
    label.bytes().map(u64::from).sum()
}

fn robot(link: &str) -> Arc<RobotModel> {
    let links = vec![LinkDescription {
        name: link.to_owned(),
        collision: Vec::new(),
    }];
    Arc::new(
        RobotModel::new(RobotDescription {
            links,
            ..RobotDescription::default()
        })
        .unwrap(),
    )
}

fn scene(object: &str) -> Arc<Scene> {
    let obstacle = Obstacle::new(object, Vec::new());
    Arc::new(Scene::new("scene", vec![obstacle], Vec::new(), Vec::new()).unwrap())
}

fn store() -> ModelStore {
    let mut store = ModelStore::new(id_of);
    assert_eq!(
        store.insert_robot("arm", robot("a"), Arc::new([]), false),
        Ok(Change::Created)
    );
    assert_eq!(
        store.insert_scene("cell", scene("table"), false),
        Ok(Change::Created)
    );
    store
}

fn wanted() -> Wanted {
    Wanted {
        robot_id: id_of("arm"),
        scene_id: id_of("cell"),
        ..Wanted::default()
    }
}

#[test]
fn a_label_names_one_content_until_replacing_is_asked_for() {
    let mut store = store();
    assert_eq!(
        store.insert_robot("arm", robot("a"), Arc::new([]), false),
        Ok(Change::Unchanged)
    );
    let error = store
        .insert_robot("arm", robot("b"), Arc::new([]), false)
        .unwrap_err();
    assert!(
        matches!(error, StoreError::LabelTaken { kind: "robot", .. }),
        "{error}"
    );
    let error = store
        .insert_scene("cell", scene("shelf"), false)
        .unwrap_err();
    assert!(
        matches!(error, StoreError::LabelTaken { kind: "scene", .. }),
        "{error}"
    );
    assert_eq!(store.scene_version(id_of("cell")), Some(1));
    assert_eq!(
        store.insert_scene("cell", scene("shelf"), true),
        Ok(Change::Replaced)
    );
    assert_eq!(store.scene_version(id_of("cell")), Some(2));
    // "rma" has the sum of "arm".
    assert!(matches!(
        store.insert_scene("rma", scene("x"), false),
        Err(StoreError::SameId { .. })
    ));
}

#[test]
fn a_snapshot_outlives_what_it_was_taken_from() {
    let mut store = store();
    let old = store.snapshot(&wanted()).unwrap();
    assert!(!old.model.is_ready());
    assert!(Arc::ptr_eq(
        &old.model,
        &store.snapshot(&wanted()).unwrap().model
    ));
    store
        .insert_scene("cell", scene("shelf"), true)
        .unwrap();
    let new = store.snapshot(&wanted()).unwrap();
    assert_eq!((old.scene_version, new.scene_version), (1, 2));
    store.remove_robot("arm").unwrap();
    assert!(old.model.get().is_ok() && old.model.is_ready());
    assert_eq!(old.model.get().unwrap().scene().hash(), old.scene_hash);
    assert!(store.models.is_empty(), "nothing unloaded is kept");
    assert_eq!(store.labels.len(), 1);
}

#[test]
fn what_is_not_there_or_not_the_same_is_refused() {
    let mut store = store();
    let mut refused = |wanted: Wanted| store.snapshot(&wanted).unwrap_err();
    let error = refused(Wanted {
        robot_id: 1,
        ..wanted()
    });
    assert!(
        matches!(&error, StoreError::UnknownRobot { known, .. } if known == "arm"),
        "{error}"
    );
    assert!(matches!(
        refused(Wanted {
            scene_id: 0,
            ..wanted()
        }),
        StoreError::UnknownScene { .. }
    ));
    // A scene's label is no robot's.
    assert!(matches!(
        refused(Wanted {
            robot_id: id_of("cell"),
            ..wanted()
        }),
        StoreError::UnknownRobot { .. }
    ));
    assert!(matches!(
        refused(Wanted {
            robot_hash: 1,
            ..wanted()
        }),
        StoreError::HashConflict { .. }
    ));
    assert!(matches!(
        refused(Wanted {
            scene_hash: 1,
            ..wanted()
        }),
        StoreError::HashConflict { .. }
    ));
    assert!(matches!(
        refused(Wanted {
            scene_version: 2,
            ..wanted()
        }),
        StoreError::UnknownVersion { .. }
    ));
    assert!(
        store
            .snapshot(&Wanted {
                scene_version: 1,
                ..wanted()
            })
            .is_ok()
    );
    assert!(matches!(
        store.remove_scene("none"),
        Err(StoreError::UnknownScene { .. })
    ));
}

/// The cell with one object after another, one version each.
fn store_of_versions(count: u64) -> ModelStore {
    let mut store = store();
    for version in 2..=count {
        let next = scene(&format!("object {version}"));
        assert_eq!(store.insert_scene("cell", next, true), Ok(Change::Replaced));
    }
    store
}

#[test]
fn the_last_versions_are_kept_and_older_ones_only_while_they_are_pinned() {
    let last = LAST_VERSIONS as u64;
    let mut store = store_of_versions(2);
    store.pin_scene("cell", 1).unwrap();
    for version in 3..=last + 5 {
        store
            .insert_scene("cell", scene(&format!("object {version}")), true)
            .unwrap();
    }
    let entry = store.scene("cell").unwrap();
    assert_eq!((entry.version, entry.kept_from()), (last + 5, 5));
    assert_eq!(
        entry
            .pinned()
            .iter()
            .copied()
            .collect::<Vec<_>>(),
        [1]
    );
    let named = |store: &mut ModelStore, version| {
        store.snapshot(&Wanted {
            scene_version: version,
            ..wanted()
        })
    };
    for (version, object) in [
        (1, "table".to_owned()),
        (5, "object 5".to_owned()),
        (0, format!("object {}", last + 5)),
    ] {
        let snapshot = named(&mut store, version).unwrap();
        assert_eq!(
            snapshot.scene_hash,
            scene(&object).hash(),
            "version {version}"
        );
        assert_eq!(
            store.scene_at("cell", version).unwrap().hash(),
            scene(&object).hash()
        );
    }
    let error = named(&mut store, 2).unwrap_err();
    let kept = format!("1, 5 to {}", last + 5);
    assert!(
        matches!(&error, StoreError::UnknownVersion { wanted: 2, .. })
            && error.to_string().contains(&kept),
        "{error}"
    );
    // The hash that a request names is that of the version it names.
    let both = Wanted {
        scene_version: 5,
        scene_hash: scene("table").hash(),
        ..wanted()
    };
    assert!(matches!(
        store.snapshot(&both),
        Err(StoreError::HashConflict { .. })
    ));

    assert!(matches!(
        store.remove_scene("cell"),
        Err(StoreError::Pinned { .. })
    ));
    assert!(matches!(
        store.unpin_scene("cell", 5),
        Err(StoreError::NotPinned { version: 5, .. })
    ));
    store.unpin_scene("cell", 1).unwrap();
    assert!(
        named(&mut store, 1).is_err(),
        "older than the last ones and no longer pinned"
    );
    assert!(matches!(
        store.pin_scene("cell", 1),
        Err(StoreError::UnknownVersion { .. })
    ));
    assert!(store.remove_scene("cell").is_ok());
}

#[test]
fn pins_are_bounded() {
    let mut store = store_of_versions(LAST_VERSIONS as u64 + 1);
    for version in 2..2 + MOST_PINNED as u64 {
        store.pin_scene("cell", version).unwrap();
    }
    assert!(store.pin_scene("cell", 2).is_ok(), "it is pinned already");
    assert!(matches!(
        store.pin_scene("cell", 1),
        Err(StoreError::TooManyPinned { .. })
    ));
}

#[test]
fn models_are_kept_of_the_newest_and_the_pinned_versions_only() {
    let mut store = store();
    store.pin_scene("cell", 1).unwrap();
    for version in 2..20 {
        store.snapshot(&wanted()).unwrap();
        store
            .insert_scene("cell", scene(&format!("object {version}")), true)
            .unwrap();
    }
    store.snapshot(&wanted()).unwrap();
    assert_eq!(
        store.models.len(),
        3,
        "and of the robot with nothing around it"
    );
}

#[test]
fn a_label_never_names_two_contents_by_one_version() {
    let mut store = store_of_versions(3);
    store.remove_scene("cell").unwrap();
    store
        .insert_scene("cell", scene("other"), false)
        .unwrap();
    assert_eq!(store.scene("cell").unwrap().version, 4);
    // However many labels come and go.
    store.remove_scene("cell").unwrap();
    for length in 10..1500 {
        let label = "x".repeat(length);
        store
            .insert_scene(&label, scene("other"), false)
            .unwrap();
        store.remove_scene(&label).unwrap();
    }
    store
        .insert_scene("cell", scene("other"), false)
        .unwrap();
    assert!(store.scene("cell").unwrap().version > 4);
}

#[test]
fn a_diff_has_to_be_against_the_newest_version() {
    let store = store_of_versions(3);
    assert_eq!(
        store.base_scene("cell", 0).unwrap().hash(),
        store.base_scene("cell", 3).unwrap().hash()
    );
    let error = store.base_scene("cell", 2).unwrap_err();
    assert!(
        matches!(
            error,
            StoreError::VersionConflict {
                wanted: 2,
                held: 3,
                ..
            }
        ),
        "{error}"
    );
    assert!(
        error.to_string().contains("version 3") && error.to_string().contains("version 2"),
        "{error}"
    );
}

#[test]
fn a_restored_scene_goes_on_counting_where_it_was() {
    let mut store = store();
    store
        .restore_scene("old", scene("a"), 7)
        .unwrap();
    assert!(matches!(
        store.restore_scene("old", scene("b"), 9),
        Err(StoreError::LabelTaken { .. })
    ));
    store
        .insert_scene("old", scene("b"), true)
        .unwrap();
    let entry = store.scene("old").unwrap();
    assert_eq!((entry.version, entry.kept_from()), (8, 7));
}

#[test]
fn versions_that_may_have_been_given_are_left_out() {
    let mut store = store();
    store.skip_versions("cell", 10).unwrap();
    assert_eq!(store.scene_version(id_of("cell")), Some(1));
    store
        .insert_scene("cell", scene("shelf"), true)
        .unwrap();
    assert_eq!(store.scene_version(id_of("cell")), Some(12));
    assert!(store.scene_at("cell", 1).is_ok() && store.scene_at("cell", 11).is_err());
    assert!(matches!(
        store.skip_versions("hall", 1),
        Err(StoreError::UnknownScene { .. })
    ));
}

#[test]
fn every_solid_is_made_once_whatever_robots_and_scenes_it_is_in() {
    let plain = crate::testing::plain_model(&mut fastrand::Rng::with_seed(3));
    let robot = plain.robot();
    let scene = plain.scene().clone();
    let mut store = ModelStore::new(id_of);
    let weights: Arc<[f64]> = Arc::new([]);
    let renamed = RobotDescription {
        name: "other".to_owned(),
        variables: Some(Vec::new()),
        ..robot.description().clone()
    };
    let held = Arc::new(RobotModel::new(renamed).unwrap());
    for (label, robot) in [("arm", robot), ("held", &held)] {
        store
            .insert_robot(label, robot.clone(), weights.clone(), false)
            .unwrap();
    }
    let prepared = Arc::new(PreparedScene::new(scene));
    let solids = prepared.solids().clone();
    store
        .insert_prepared_scene("cell", prepared, false)
        .unwrap();
    store
        .insert_scene("bare", Arc::new(Scene::default()), false)
        .unwrap();
    let mut model = |robot: &str, scene: &str| {
        let wanted = Wanted {
            robot_id: id_of(robot),
            scene_id: id_of(scene),
            ..Wanted::default()
        };
        store.snapshot(&wanted).unwrap().model
    };
    let models = [("arm", "cell"), ("held", "cell"), ("arm", "bare")];
    let models = models.map(|(robot, scene)| model(robot, scene));
    let bodies = models
        .each_ref()
        .map(|model| model.get().unwrap().bodies());
    assert!(
        Arc::ptr_eq(&bodies[0][0].solid, &bodies[1][0].solid),
        "of one link"
    );
    assert!(
        Arc::ptr_eq(&bodies[0][0].solid, &bodies[2][0].solid),
        "in no scene"
    );
    let last = |index: usize| &bodies[index].last().unwrap().solid;
    assert!(Arc::ptr_eq(last(0), last(1)), "of one object");
    assert!(Arc::ptr_eq(&solids, models[0].prepared_scene().solids()));
    assert!(Arc::ptr_eq(&models[2], store.alone(robot).unwrap()));
    let made = store.made();
    let counts = [&made.robots, &made.models].map(|count| count.load(Ordering::Relaxed));
    assert_eq!(counts, [1, 2]);
}

#[test]
fn what_is_missing_is_made_step_by_step() {
    let (robot, scene, _) = crate::testing::two_scenes(&mut fastrand::Rng::with_seed(4));
    let alone = Arc::new(PreparedModel::alone(robot, Arc::default()));
    let objects = scene.objects().count();
    let scene = Arc::new(PreparedScene::new(scene));
    let model = PreparedModel::of(alone.clone(), scene.clone());
    let step = || model.missing().map(|missing| missing.step);
    assert_eq!(step(), Some(Step::Links(alone.links())));
    alone.begin(7);
    assert_eq!(model.missing().unwrap().begun_ns, Some(7));
    assert!(alone.get().is_ok() && alone.link_bytes() > 0);
    assert_eq!(step(), Some(Step::Objects(scene.count())));
    let next = || PreparedScene::after(&scene, scene.scene().clone());
    assert_eq!(next().missing(), scene.count());
    scene.solids();
    assert_eq!(
        next().missing(),
        Count::default(),
        "the next version takes them over"
    );
    assert_eq!(step(), Some(Step::Together(objects)));
    assert!(model.claim() && !model.claim(), "it is made ahead once");
    assert!(model.get().is_ok());
    assert_eq!(step(), None);
    assert!(!model.claim(), "it is there");
}

#[test]
fn a_version_that_is_named_goes_up_also_where_the_label_was_unloaded() {
    let mut store = store();
    let at = |version| Place {
        replace: true,
        version: Some(version),
    };
    assert_eq!(
        store.insert_scene("cell", scene("chair"), at(5)),
        Ok(Change::Replaced)
    );
    assert_eq!(
        store.insert_scene("cell", scene("chair"), at(5)),
        Ok(Change::Unchanged)
    );
    for version in [0, 1, 5] {
        let error = store
            .insert_scene("cell", scene("lamp"), at(version))
            .unwrap_err();
        assert!(
            matches!(error, StoreError::VersionTaken { held: 5, .. }),
            "{error}"
        );
    }
    assert!(store.scene_at("cell", 1).is_ok(), "what is kept stays");
    store.remove_scene("cell").unwrap();
    let error = store.insert_scene("cell", scene("lamp"), at(5));
    assert!(matches!(
        error,
        Err(StoreError::VersionTaken { held: 5, .. })
    ));
    assert_eq!(
        store.insert_scene("cell", scene("lamp"), at(6)),
        Ok(Change::Created)
    );
    assert_eq!(
        store.insert_scene("cell", scene("chair"), true),
        Ok(Change::Replaced)
    );
    assert_eq!(store.scene("cell").unwrap().version, 7);
}
