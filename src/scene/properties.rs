//! Random changes, against a scene that is nothing but lists.

use std::sync::Arc;

use fastrand::Rng;

use super::*;
use crate::shape::PlacedShape;
use crate::testing::{pose, shape, uniform};
use crate::validation::soundness::cases;

const NAMES: [&str; 7] = ["a", "b", "c", "d", "e", "f", "g"];
const LINKS: [&str; 3] = ["base", "arm", "hand"];

fn placed(rng: &mut Rng) -> PlacedShape {
    PlacedShape {
        pose: pose(rng, 1.0),
        shape: shape(rng),
    }
}

/// Any change to any of a few names; many of them cannot be made. Some poses and shapes come back
/// again and again.
fn change(rng: &mut Rng, known: &[PlacedShape]) -> SceneChange {
    let name = |rng: &mut Rng| NAMES[rng.usize(0..NAMES.len())].to_owned();
    let any = |rng: &mut Rng| {
        if rng.bool() {
            name(rng)
        } else {
            LINKS[rng.usize(0..LINKS.len())].to_owned()
        }
    };
    let place = |rng: &mut Rng| {
        if rng.bool() {
            pose(rng, 1.0)
        } else {
            known[rng.usize(0..known.len())].pose
        }
    };
    let shapes = |rng: &mut Rng| {
        (0..rng.usize(0..3))
            .map(|_| known[rng.usize(0..known.len())].clone())
            .collect()
    };
    let id = name(rng);
    match rng.u8(0..23) {
        20 => SceneChange::Subframe {
            object: id,
            name: name(rng),
            pose: rng.bool().then(|| place(rng)),
        },
        21 => SceneChange::World {
            id,
            frame: rng
                .bool()
                .then(|| LINKS[rng.usize(0..3)].to_owned()),
        },
        // A pose that is not set.
        22 => SceneChange::Add(Obstacle::new(
            id,
            vec![known[rng.usize(0..known.len())].clone()],
        )),
        0..4 => SceneChange::Add(Obstacle::new(id, shapes(rng)).at(place(rng))),
        4 => SceneChange::Append {
            id,
            shapes: shapes(rng),
        },
        5 | 6 => SceneChange::Remove { id },
        7 if rng.u8(0..6) == 0 => SceneChange::RemoveAll,
        7..10 => SceneChange::Move {
            id,
            pose: place(rng),
        },
        10 | 11 => {
            let touch_links = (0..rng.usize(0..3)).map(|_| any(rng)).collect();
            SceneChange::Attach {
                id,
                link_name: LINKS[rng.usize(0..3)].into(),
                touch_links,
                pose: place(rng),
            }
        }
        12 => SceneChange::Detach {
            id,
            pose: place(rng),
        },
        13 => SceneChange::Pad {
            name: any(rng),
            padding: [0.0, 0.1, 0.2, -1.0][rng.usize(0..4)],
        },
        14 => SceneChange::Scale {
            name: any(rng),
            scale: [1.0, 0.5, 2.0, 0.0][rng.usize(0..4)],
        },
        15 => SceneChange::Frame {
            name: id,
            pose: rng.bool().then(|| place(rng)),
        },
        16 => SceneChange::Allow(any(rng), any(rng)),
        17 => SceneChange::Replace(Obstacle::new(id, shapes(rng)).at(place(rng))),
        18 => SceneChange::Forbid(any(rng), any(rng)),
        _ => SceneChange::ClearPair(any(rng), any(rng)),
    }
}

/// The same change to plain lists; whether it can be made is asked of the scene.
fn apply(plain: &mut SceneDescription, change: SceneChange) {
    let same = |pair: &(String, String), a: &str, b: &str| {
        (pair.0 == a && pair.1 == b) || (pair.0 == b && pair.1 == a)
    };
    let clear = |plain: &mut SceneDescription, a: &str, b: &str| {
        plain.allowed.retain(|pair| !same(pair, a, b));
        plain.forbidden.retain(|pair| !same(pair, a, b));
    };
    match change {
        SceneChange::Add(object) => plain.obstacles.push(object),
        SceneChange::Replace(object) => *object_mut(plain, &object.id) = object.clone(),
        SceneChange::Append { id, shapes } => {
            let object = object_mut(plain, &id);
            object.shapes = [object.shapes.to_vec(), shapes].concat().into();
        }
        SceneChange::Remove { id } => {
            plain.obstacles.retain(|object| object.id != id);
            plain
                .attached
                .retain(|attached| attached.object.id != id);
            plain
                .attached
                .iter_mut()
                .for_each(|attached| attached.touch_links.retain(|name| *name != id));
            plain
                .allowed
                .retain(|(a, b)| *a != id && *b != id);
            plain
                .forbidden
                .retain(|(a, b)| *a != id && *b != id);
            plain.padding.remove(&id);
            plain.scale.remove(&id);
            plain
                .subframes
                .retain(|(object, _), _| *object != id);
            plain.worlds.remove(&id);
        }
        SceneChange::RemoveAll => {
            let ids: Vec<_> = plain
                .obstacles
                .iter()
                .map(|object| object.id.clone())
                .collect();
            ids.into_iter()
                .for_each(|id| apply(plain, SceneChange::Remove { id }));
        }
        SceneChange::Move { id, pose } => object_mut(plain, &id).pose = pose,
        SceneChange::Attach {
            id,
            link_name,
            touch_links,
            pose,
        } => {
            let index = plain
                .obstacles
                .iter()
                .position(|object| object.id == id)
                .unwrap();
            let object = plain.obstacles.remove(index).at(pose);
            plain.worlds.remove(&id);
            plain.attached.push(AttachedObject {
                link_name,
                object,
                touch_links,
            });
        }
        SceneChange::Detach { id, pose } => {
            let index = plain
                .attached
                .iter()
                .position(|attached| attached.object.id == id)
                .unwrap();
            plain
                .obstacles
                .push(plain.attached.remove(index).object.at(pose));
        }
        SceneChange::Pad { name, padding } => {
            plain.padding.insert(name, padding);
        }
        SceneChange::Scale { name, scale } => {
            plain.scale.insert(name, scale);
        }
        SceneChange::Frame { name, pose } => {
            plain.frames.remove(&name);
            plain
                .frames
                .extend(pose.map(|pose| (name, pose)));
        }
        SceneChange::Subframe { object, name, pose } => {
            let key = (object, name);
            plain.subframes.remove(&key);
            plain
                .subframes
                .extend(pose.map(|pose| (key, pose)));
        }
        SceneChange::World { id, frame } => {
            plain.worlds.remove(&id);
            plain
                .worlds
                .extend(frame.map(|frame| (id, frame)));
        }
        SceneChange::Allow(a, b) => {
            if !plain
                .allowed
                .iter()
                .any(|pair| same(pair, &a, &b))
            {
                clear(plain, &a, &b);
                plain.allowed.push((a, b));
            }
        }
        SceneChange::Forbid(a, b) => {
            if !plain
                .forbidden
                .iter()
                .any(|pair| same(pair, &a, &b))
            {
                clear(plain, &a, &b);
                plain.forbidden.push((a, b));
            }
        }
        SceneChange::ClearPair(a, b) => clear(plain, &a, &b),
    }
}

fn object_mut<'a>(plain: &'a mut SceneDescription, id: &str) -> &'a mut Obstacle {
    let attached = plain
        .attached
        .iter_mut()
        .map(|attached| &mut attached.object);
    plain
        .obstacles
        .iter_mut()
        .chain(attached)
        .find(|object| object.id == id)
        .unwrap()
}

/// All that a scene says.
fn said(scene: &Scene) -> String {
    let objects = (
        scene.obstacles().iter().collect::<Vec<_>>(),
        scene.attached().iter().collect::<Vec<_>>(),
    );
    let sizes = (
        scene.padded().collect::<Vec<_>>(),
        scene.scaled().collect::<Vec<_>>(),
    );
    let sorted = |(a, b): (&str, &str)| [a.min(b).to_owned(), a.max(b).to_owned()];
    let pairs = (
        scene.allowed().map(sorted).collect::<Vec<_>>(),
        scene
            .forbidden()
            .map(sorted)
            .collect::<Vec<_>>(),
    );
    let frames = (
        scene.frames().collect::<Vec<_>>(),
        scene.subframes().collect::<Vec<_>>(),
    );
    let worlds: Vec<_> = scene.worlds().collect();
    format!(
        "{objects:?} {sizes:?} {pairs:?} {frames:?} {worlds:?} {:?}",
        scene.warnings()
    )
}

/// However a scene was made, it is the one that its lists make; one that cannot be changed stays as
/// it is, and so does every one that another was made from.
#[test]
fn changed_scenes_are_those_that_their_lists_make() {
    let (count, mut rng) = cases(150);
    let mut made = 0;
    let mut refused = 0;
    for _ in 0..count {
        let known: Vec<_> = (0..4).map(|_| placed(&mut rng)).collect();
        let mut plain = SceneDescription::default();
        let mut versions = vec![(Scene::default(), said(&Scene::default()))];
        for _ in 0..40 {
            let scene = &versions[versions.len() - 1].0;
            let changes: Vec<_> = (0..rng.usize(1..4))
                .map(|_| change(&mut rng, &known))
                .collect();
            let Ok(next) = scene.with(changes.clone()) else {
                refused += 1;
                continue;
            };
            changes
                .into_iter()
                .for_each(|change| apply(&mut plain, change));
            let anew = Scene::of(plain.clone()).unwrap();
            assert_eq!((said(&next), next.hash()), (said(&anew), anew.hash()));
            assert_eq!(next.former_hash(), anew.former_hash());
            assert_eq!(next.obstacles().len(), next.obstacles().iter().count());
            for object in next.obstacles() {
                assert_eq!(next.obstacles().get(&object.id), Some(object));
            }
            let said = said(&next);
            versions.push((next, said));
            made += 1;
        }
        for (scene, before) in &versions {
            assert_eq!(said(scene), *before, "an old version has changed");
        }
    }
    assert!(
        made > 5 * count && refused > count,
        "{made} made, {refused} refused"
    );
}

/// Any scene is made of any other, and of two neighbours by few changes.
#[test]
fn the_changes_from_one_scene_to_another_make_it() {
    let (count, mut rng) = cases(150);
    let mut most = 0;
    for _ in 0..count {
        let known: Vec<_> = (0..4).map(|_| placed(&mut rng)).collect();
        let walk = |rng: &mut Rng, from: &Scene| {
            let mut scene = from.clone();
            for _ in 0..rng.usize(0..60) {
                scene = scene
                    .with([change(rng, &known)])
                    .unwrap_or(scene);
            }
            scene
        };
        let first = walk(&mut rng, &Scene::default());
        for second in [
            walk(&mut rng, &first),
            walk(&mut rng, &Scene::default()),
            first.clone(),
        ] {
            for (from, to) in [(&first, &second), (&second, &first)] {
                let changes = from.changes_to(to);
                let made = from.with(changes.clone()).unwrap();
                assert_eq!(
                    (made.hash(), said(&made)),
                    (to.hash(), said(to)),
                    "{changes:?}"
                );
                most = most.max(changes.len());
                assert_eq!(changes.is_empty(), from.hash() == to.hash());
            }
        }
        let pose = pose(&mut rng, 1.0);
        for object in first.objects() {
            let change = SceneChange::Move {
                id: object.id.clone(),
                pose,
            };
            assert_eq!(
                first.changes_to(&first.with([change.clone()]).unwrap()),
                [change]
            );
            let change =
                SceneChange::Replace(Obstacle::new(object.id.clone(), vec![placed(&mut rng)]));
            let changes = first.changes_to(&first.with([change.clone()]).unwrap());
            // One that had no shapes gets them, and is moved.
            assert_eq!(
                changes.len(),
                if object.shapes.is_empty() { 2 } else { 1 },
                "{changes:?}"
            );
        }
    }
    assert!(most > 10, "at most {most} changes");
}

/// Scenes that are made from one another have most of their objects in common in memory.
#[test]
fn versions_share_what_a_change_leaves() {
    let mut rng = Rng::with_seed(3);
    let obstacles: Vec<_> = (0..100)
        .map(|i| Obstacle::new(format!("o{i}"), vec![placed(&mut rng)]))
        .collect();
    let scene = Scene::new("many", obstacles, Vec::new(), Vec::new()).unwrap();
    let pose =
        crate::math::Pose::from_translation(crate::math::Vec3::splat(uniform(&mut rng, 0.0, 1.0)));
    let moved = scene
        .with([SceneChange::Move {
            id: "o50".into(),
            pose,
        }])
        .unwrap();
    let is_same = |id: &str| {
        std::ptr::eq(
            scene.obstacles().get(id).unwrap(),
            moved.obstacles().get(id).unwrap(),
        )
    };
    assert!(!is_same("o50"));
    assert_eq!(
        (0..100)
            .filter(|i| is_same(&format!("o{i}")))
            .count(),
        99
    );
    assert!(Arc::ptr_eq(
        &scene.obstacles()[50].shapes,
        &moved.obstacles()[50].shapes
    ));
}
