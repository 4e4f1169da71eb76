use super::*;
use crate::robot::{LinkDescription, RobotDescription};
use crate::scene::Obstacle;

fn id_of(label: &str) -> u64 {
    label.bytes().map(u64::from).sum()
}

fn robot(link: &str) -> Arc<RobotModel> {
    let links = vec![LinkDescription { name: link.to_owned(), collision: Vec::new() }];
    Arc::new(RobotModel::new(RobotDescription { links, ..RobotDescription::default() }).unwrap())
}

fn scene(object: &str) -> Arc<Scene> {
    let obstacle = Obstacle::new(object, Vec::new());
    Arc::new(Scene::new("scene", vec![obstacle], Vec::new(), Vec::new()).unwrap())
}

fn store() -> ModelStore {
    let mut store = ModelStore::new(id_of);
    assert_eq!(store.insert_robot("arm", robot("a"), Arc::new([]), false), Ok(Change::Created));
    assert_eq!(store.insert_scene("cell", scene("table"), false), Ok(Change::Created));
    store
}

fn wanted() -> Wanted {
    Wanted { robot_id: id_of("arm"), scene_id: id_of("cell"), ..Wanted::default() }
}

#[test]
fn a_label_names_one_content_until_replacing_is_asked_for() {
    let mut store = store();
    assert_eq!(store.insert_robot("arm", robot("a"), Arc::new([]), false), Ok(Change::Unchanged));
    let error = store.insert_robot("arm", robot("b"), Arc::new([]), false).unwrap_err();
    assert!(matches!(error, StoreError::LabelTaken { kind: "robot", .. }), "{error}");
    let error = store.insert_scene("cell", scene("shelf"), false).unwrap_err();
    assert!(matches!(error, StoreError::LabelTaken { kind: "scene", .. }), "{error}");
    assert_eq!(store.scene_version(id_of("cell")), Some(1));
    assert_eq!(store.insert_scene("cell", scene("shelf"), true), Ok(Change::Replaced));
    assert_eq!(store.scene_version(id_of("cell")), Some(2));
    // "rma" has the sum of "arm".
    assert!(matches!(store.insert_scene("rma", scene("x"), false), Err(StoreError::SameId { .. })));
}

#[test]
fn a_snapshot_outlives_what_it_was_taken_from() {
    let mut store = store();
    let old = store.snapshot(&wanted()).unwrap();
    assert!(!old.model.is_ready());
    assert!(Arc::ptr_eq(&old.model, &store.snapshot(&wanted()).unwrap().model));
    store.insert_scene("cell", scene("shelf"), true).unwrap();
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
    let error = refused(Wanted { robot_id: 1, ..wanted() });
    assert!(matches!(&error, StoreError::UnknownRobot { known, .. } if known == "arm"), "{error}");
    assert!(matches!(refused(Wanted { scene_id: 0, ..wanted() }), StoreError::UnknownScene { .. }));
    // A scene's label is no robot's.
    assert!(matches!(refused(Wanted { robot_id: id_of("cell"), ..wanted() }), StoreError::UnknownRobot { .. }));
    assert!(matches!(refused(Wanted { robot_hash: 1, ..wanted() }), StoreError::HashConflict { .. }));
    assert!(matches!(refused(Wanted { scene_hash: 1, ..wanted() }), StoreError::HashConflict { .. }));
    assert!(matches!(refused(Wanted { scene_version: 2, ..wanted() }), StoreError::VersionConflict { .. }));
    assert!(store.snapshot(&Wanted { scene_version: 1, ..wanted() }).is_ok());
    assert!(matches!(store.remove_scene("none"), Err(StoreError::UnknownScene { .. })));
}
