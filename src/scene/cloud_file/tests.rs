use serde_json::{Value, json};

use crate::math::Vec3;
use crate::scene::diff_file::{DiffFile, SceneDiff};
use crate::scene::scene_file::{self, SceneFile};
use crate::scene::{Obstacle, Scene, SceneError};
use crate::shape::Cloud;

const POINTS: &str = "0 0 0\n0.01 0 0\n0 0.01 0\n0.02 0 0\nnan 0 0\n";

/// The child of greatest coordinates is occupied, that of least is free.
const MAP: &[u8] = b"# Octomap OcTree binary file\nid OcTree\nsize 3\nres 0.25\ndata\n\x01\x80";

fn bytes(name: &str) -> Result<Option<Vec<u8>>, String> {
    match name {
        "scan.xyz" => Ok(Some(POINTS.into())),
        "hall.bt" => Ok(Some(MAP.into())),
        "later.xyz" => Ok(None),
        other => Err(format!("there is no file {other}")),
    }
}

fn no_mesh(
    name: &str,
    _: Vec3,
) -> Result<std::sync::Arc<crate::shape::Mesh>, crate::shape::MeshError> {
    panic!("no mesh {name}")
}

fn build(text: &Value) -> Result<Scene, SceneError> {
    let mut file = SceneFile::read(&text.to_string())?;
    file.read_clouds(&mut bytes)?;
    file.build(&mut no_mesh)
}

fn of(object: Value) -> Value {
    json!({ "objects": [object] })
}

fn scan() -> Value {
    json!({ "id": "scan", "pose": { "position": [1, 2, 3] },
        "cloud": { "file": "scan.xyz", "radius": 0.006 } })
}

fn hall(unknown: &str) -> Value {
    json!({ "id": "hall", "octomap": { "file": "hall.bt", "unknown": unknown } })
}

fn cloud(object: &Obstacle) -> &Cloud {
    object.shapes[0].shape.cloud().unwrap()
}

#[test]
fn a_cloud_is_the_object_that_names_it() {
    let scene = build(&of(scan())).unwrap();
    let object = scene.object("scan").unwrap();
    assert_eq!(object.pose.translation, Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(cloud(object).len(), 4);
    let warnings: Vec<&str> = scene
        .warnings()
        .iter()
        .map(|w| w.text())
        .collect();
    assert_eq!(
        warnings,
        ["object \"scan\": cloud scan.xyz: 1 of 5 points are not finite: left out"]
    );
}

#[test]
fn an_octomap_is_what_its_unknown_space_is_said_to_be() {
    let free = build(&of(hall("free"))).unwrap();
    assert_eq!(cloud(free.object("hall").unwrap()).len(), 1);
    assert!(free.warnings()[0].contains("unknown space is taken as free"));
    let solid = build(&of(hall("obstacle"))).unwrap();
    let cells = cloud(solid.object("hall").unwrap());
    assert_eq!(cells.len(), 7);
    assert!(!(0..7).any(|place| {
        let name = cells.words(place);
        name.contains("unknown") != cells.is_unknown(place)
    }));
    assert_ne!(free.hash(), solid.hash());
}

/// By its files, and by its cells where there is no file any more.
#[test]
fn a_text_makes_the_same_scene_again() {
    let placed = json!({ "id": "low", "cloud": { "file": "scan.xyz", "radius": 0.006, "thin": 0.015,
        "pose": { "position": [0, 0, -1] } } });
    let scene = build(&json!({ "objects": [scan(), hall("obstacle"), placed] })).unwrap();
    let read = |with_content| {
        let text = scene_file::text(&scene, with_content);
        (build(&serde_json::from_str(&text).unwrap()).unwrap(), text)
    };
    let (by_files, text) = read(false);
    assert!(!text.contains("cells"), "{text}");
    assert_eq!(by_files.hash(), scene.hash());
    assert_eq!(by_files.warnings(), scene.warnings());
    let (by_cells, text) = read(true);
    assert!(!SceneFile::read(&text).unwrap().names_files());
    assert_eq!(by_cells.hash(), scene.hash());
    assert!(cloud(by_cells.object("hall").unwrap()).is_unknown(0));
    assert_eq!(
        scene_file::text(&by_cells, false),
        scene_file::text(&scene, false)
    );
    let uncovered = |scene: &Scene| -> Vec<String> {
        let warnings = scene.warnings().iter();
        warnings
            .filter(|w| w.is_uncovered())
            .map(|w| w.to_string())
            .collect()
    };
    assert_eq!(uncovered(&by_cells), uncovered(&scene));
}

#[test]
fn a_diff_brings_a_cloud_and_takes_the_place_of_one() {
    let add = |object: Value| {
        let mut object = object;
        object["operation"] = "ADD".into();
        let text = json!({ "is_diff": true, "objects": [object] }).to_string();
        let mut file = DiffFile::parse(&text).unwrap();
        assert!(file.names_files());
        file.read_clouds(&mut bytes).unwrap();
        SceneDiff::try_from(file).unwrap()
    };
    let first = add(scan()).apply(&Scene::default()).unwrap();
    assert_eq!(first.hash(), build(&of(scan())).unwrap().hash());
    let mut other = scan();
    other["cloud"]["radius"] = 0.02.into();
    let second = add(other).apply(&first).unwrap();
    assert_eq!(second.obstacles().len(), 1);
    assert_ne!(second.hash(), first.hash());
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let changed = |mut object: Value, word: &str, field: &str, value: Value| {
        object[word][field] = value;
        of(object)
    };
    let mut beside = scan();
    beside["primitives"] = json!([{ "type": "sphere", "dimensions": [1] }]);
    beside["primitive_poses"] = json!([{}]);
    let appended = json!({ "objects": [{ "id": "scan" }, { "id": "scan", "operation": "APPEND",
        "cloud": { "file": "scan.xyz", "radius": 0.006 } }] });
    for (text, part) in [
        (
            changed(scan(), "cloud", "radius", 0.into()),
            "its radius is 0 m, it must be finite and greater than 0; its points lie 10.00 mm apart",
        ),
        (
            changed(scan(), "cloud", "radius", Value::Null),
            "cloud scan.xyz: it has no radius",
        ),
        (changed(scan(), "cloud", "thin", (-1).into()), "thin is -1"),
        (
            changed(scan(), "cloud", "unknown", "obstacle".into()),
            "can only be \"free\"",
        ),
        (
            changed(scan(), "cloud", "file", "gone.xyz".into()),
            "object \"scan\": gone.xyz: there is no file gone.xyz",
        ),
        (
            changed(scan(), "cloud", "file", "hall.bt".into()),
            "\"bt\" is no format of clouds",
        ),
        (
            changed(scan(), "cloud", "file", "".into()),
            "a cloud of nothing",
        ),
        (
            changed(scan(), "cloud", "hash", "00".into()),
            "not 00; give the file that is meant",
        ),
        (
            changed(scan(), "cloud", "radios", 1.into()),
            "did you mean `radius`",
        ),
        (
            changed(hall("free"), "octomap", "unknown", Value::Null),
            "octomap hall.bt has 211 106 232 532 992 unknown cells of 0.25 m within its bounds, and all space outside them is unknown; say \"unknown\": \"free\"",
        ),
        (
            changed(hall("free"), "octomap", "unknown", "maybe".into()),
            "unknown is \"maybe\"; valid: \"unknown\"",
        ),
        (
            changed(hall("free"), "octomap", "radius", 1.into()),
            "leave out radius and thin",
        ),
        (
            changed(hall("free"), "octomap", "file", "scan.xyz".into()),
            "it is no octomap",
        ),
        (of(beside), "other shapes beside its cloud or octomap"),
        (appended, "nothing is appended to"),
    ] {
        let error = build(&text).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let unread = SceneFile::read(&of(scan()).to_string()).unwrap();
    let error = unread
        .build(&mut no_mesh)
        .unwrap_err()
        .to_string();
    assert!(error.contains("files are not read here"), "{error}");
}

/// What is not there yet is wanted, not refused: all files of a scene are found in one look.
#[test]
fn a_file_that_nobody_gave_yet_stands_as_a_point() {
    let mut later = scan();
    later["cloud"]["file"] = "later.xyz".into();
    assert!(build(&of(later)).is_ok());
}

fn message(unknown: &Value, matrix: &Value) -> Value {
    json!({ "world": { "collision_objects": [], "octomap": {
            "header": { "frame_id": "shelf" }, "origin": { "position": { "x": 1, "y": 0, "z": 0 } }, "unknown": unknown,
            "octomap": { "header": { "frame_id": "shelf" }, "binary": true, "id": "OcTree", "resolution": 0.25, "data": [1, -128] } } },
        "fixed_frame_transforms": [{ "child_frame_id": "shelf", "transform": { "translation": [0, 5, 0] } }],
        "allowed_collision_matrix": matrix })
}

fn matrix() -> Value {
    json!({ "entry_names": ["<octomap>", "hand"], "default_entry_names": ["<octomap>"], "default_entry_values": [true],
        "entry_values": [{ "enabled": [false, true] }, { "enabled": [true, false] }] })
}

#[test]
fn the_octomap_of_a_message_is_an_object() {
    let scene = build(&message(&"free".into(), &matrix())).unwrap();
    let object = scene.object("<octomap>").unwrap();
    assert_eq!(object.pose.translation, Vec3::new(1.0, 5.0, 0.0));
    let wanted = build(&of(hall("free"))).unwrap();
    assert_eq!(
        cloud(object).hash(),
        cloud(wanted.object("hall").unwrap()).hash()
    );
    assert_eq!(scene.allowed().collect::<Vec<_>>(), [("<octomap>", "hand")]);
    let texts: String = scene
        .warnings()
        .iter()
        .map(|w| w.text())
        .collect();
    assert!(
        texts.contains("octomap world.octomap: unknown space is taken as free"),
        "{texts}"
    );
    assert!(
        texts.contains("lets <octomap> touch anything by default"),
        "{texts}"
    );
    // Its cells are written: it is no file's.
    let again = serde_json::from_str(&scene_file::text(&scene, false)).unwrap();
    assert_eq!(build(&again).unwrap().hash(), scene.hash());
}

#[test]
fn a_message_says_of_its_octomap_what_has_to_be_said() {
    let error = |change: &dyn Fn(&mut Value)| {
        let mut text = message(&"free".into(), &json!({}));
        change(&mut text["world"]["octomap"]);
        build(&text).unwrap_err().to_string()
    };
    for (change, part) in [
        (
            (&|map: &mut Value| map["unknown"] = Value::Null) as &dyn Fn(&mut Value),
            "object \"<octomap>\": octomap world.octomap has",
        ),
        (
            &|map| map["octomap"]["id"] = "ColorOcTree".into(),
            "world.octomap: it is a tree of kind \"ColorOcTree\"",
        ),
        (
            &|map| map["octomap"]["resolution"] = 0.into(),
            "resolution is 0",
        ),
        (&|map| map["octomap"]["data"] = json!([1]), "cut short"),
        (
            &|map| map["octomap"]["data"] = json!([1, 256]),
            "whole numbers from -128 to 127",
        ),
        (&|map| map["octomap"]["binary"] = false.into(), "cut short"),
    ] {
        let error = error(change);
        assert!(error.contains(part), "{error}");
    }
    let mut empty = message(&Value::Null, &matrix());
    empty["world"]["octomap"]["octomap"]["data"] = json!([]);
    let scene = build(&empty).unwrap();
    assert_eq!((scene.objects().count(), scene.allowed().count()), (0, 0));
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
}
