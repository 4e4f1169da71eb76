use std::sync::mpsc;

use taut::math::{Pose, Vec3};
use taut::robot::{LinkDescription, RobotDescription};
use taut::scene::{Obstacle, SceneChange};
use taut::shape::{Mesh, PlacedShape, Shape};
use taut::warning::Warning;

use super::*;

fn tetrahedron(size: f64) -> Arc<Mesh> {
    let corners = vec![Vec3::ZERO, Vec3::X * size, Vec3::Y * size, Vec3::Z * size];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    Arc::new(Mesh::new("tetrahedron", corners, triangles).unwrap())
}

fn placed(shape: Shape) -> PlacedShape {
    PlacedShape {
        pose: Pose::from_translation(Vec3::new(0.1, -0.2, 0.3)),
        shape,
    }
}

fn robot(size: f64) -> Content {
    let collision = vec![
        placed(Shape::Mesh(tetrahedron(size))),
        placed(Shape::sphere(0.1).unwrap()),
    ];
    let links = vec![LinkDescription {
        name: "base".into(),
        collision,
    }];
    let warnings = vec![Warning::uncovered("odd")];
    let robot = RobotModel::new(RobotDescription {
        links,
        warnings,
        ..RobotDescription::default()
    })
    .unwrap();
    Content::Robot(
        Arc::new(robot.with_warnings(vec![Warning::uncovered("found later")])),
        Arc::new([]),
    )
}

fn scene(size: f64) -> Arc<Scene> {
    let mesh = Obstacle::new("mesh", vec![placed(Shape::Mesh(tetrahedron(size)))]);
    let many = (0..50).map(|index| {
        Obstacle::new(
            format!("box{index}"),
            vec![placed(Shape::cuboid(Vec3::ONE).unwrap())],
        )
    });
    let allowed = vec![("mesh".to_owned(), "box1".to_owned())];
    Arc::new(
        Scene::new(
            "cell",
            std::iter::once(mesh).chain(many).collect(),
            allowed,
            vec![Warning::cosmetic("file", "of the file")],
        )
        .unwrap(),
    )
}

fn moved(scene: &Scene, id: &str, x: f64) -> Arc<Scene> {
    Arc::new(
        scene
            .with([SceneChange::Move {
                id: id.into(),
                pose: Pose::from_translation(Vec3::X * x),
            }])
            .unwrap(),
    )
}

fn key(kind: Kind, label: &str) -> Key {
    (kind, label.to_owned())
}

fn of_client(content: Content) -> State {
    State {
        content,
        configured: false,
    }
}

/// Writes as the daemon's thread does.
fn write(writer: &mut Writer, key: Key, content: Content) {
    writer.take(key, of_client(content));
    writer.write(false).unwrap();
}

fn same(kept: &Kept, key: &Key, content: &Content) {
    let state = kept.states[key].as_ref().unwrap();
    assert!(state.content.is_same(content), "{state:?}");
}

#[test]
fn robots_and_scenes_come_back_with_their_hashes_versions_and_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let arm = key(Kind::Robot, "arm");
    let cell = key(Kind::Scene, "cell");
    let gone = key(Kind::Scene, "gone");
    let first = scene(1.0);
    let robot = robot(0.5);
    let second = moved(&first, "box7", 3.0);
    let third = moved(&second, "mesh", -1.0);
    let (mut journal, kept) = open(folder.path()).unwrap();
    assert!(kept.states.is_empty() && !kept.ended);
    let writer = &mut journal.writer;
    write(writer, arm.clone(), robot.clone());
    write(writer, gone.clone(), Content::Scene(1, first.clone()));
    write(writer, cell.clone(), Content::Scene(4, first.clone()));
    let size = || {
        std::fs::metadata(file(folder.path()))
            .unwrap()
            .len()
    };
    let before = size();
    write(writer, cell.clone(), Content::Scene(5, second));
    assert!(
        size() - before < 200,
        "what moved is written, not the scene: {} bytes",
        size() - before
    );
    write(writer, cell.clone(), Content::Scene(6, third.clone()));
    write(writer, gone.clone(), Content::Gone);
    assert!(matches!(open(folder.path()), Err(JournalError::Locked(_))));
    drop(journal);

    let (_journal, kept) = open(folder.path()).unwrap();
    same(&kept, &arm, &robot);
    same(&kept, &cell, &Content::Scene(6, third));
    same(&kept, &gone, &Content::Gone);
    let Content::Robot(arm, _) = &kept.states[&arm].as_ref().unwrap().content else {
        panic!()
    };
    let Content::Robot(robot, _) = &robot else {
        panic!()
    };
    assert_eq!(arm.warnings(), robot.warnings());
    let Content::Scene(_, cell) = &kept.states[&cell].as_ref().unwrap().content else {
        panic!()
    };
    assert_eq!(cell.warnings(), first.warnings());
}

#[test]
fn a_mesh_that_is_not_what_it_was_is_not_served() {
    let folder = tempfile::tempdir().unwrap();
    let arm = key(Kind::Robot, "arm");
    let cell = key(Kind::Scene, "cell");
    let other = key(Kind::Scene, "other");
    let (mut journal, _) = open(folder.path()).unwrap();
    write(&mut journal.writer, arm.clone(), robot(0.5));
    write(
        &mut journal.writer,
        cell.clone(),
        Content::Scene(1, scene(1.0)),
    );
    write(
        &mut journal.writer,
        other.clone(),
        Content::Scene(1, scene(2.0)),
    );
    drop(journal);
    let mesh = |size| {
        folder
            .path()
            .join(format!("meshes/{:016x}", tetrahedron(size).hash()))
    };
    std::fs::copy(mesh(0.5), mesh(1.0)).unwrap();
    std::fs::remove_file(mesh(2.0)).unwrap();
    let (_journal, kept) = open(folder.path()).unwrap();
    assert!(kept.states[&arm].is_ok());
    let why = |key| kept.states[key].as_ref().err().unwrap();
    assert!(
        why(&cell).contains("its content has hash"),
        "{}",
        why(&cell)
    );
    assert!(why(&other).contains("No such file"), "{}", why(&other));
}

#[test]
fn what_could_not_be_written_is_written_with_the_next_change() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_owned();
    let arm = key(Kind::Robot, "arm");
    let cell = key(Kind::Scene, "cell");
    let first = scene(1.0);
    let (mut journal, _) = open(&place).unwrap();
    let writer = &mut journal.writer;
    write(writer, cell.clone(), Content::Scene(1, first.clone()));
    // Where a mesh is written first.
    std::fs::create_dir(place.join("meshes/new")).unwrap();
    writer.take(arm.clone(), of_client(robot(0.5)));
    let reason = writer.write(false).unwrap_err();
    assert!(reason.contains("meshes/"), "{reason}");
    std::fs::remove_dir(place.join("meshes/new")).unwrap();
    let second = moved(&first, "mesh", 1.0);
    write(writer, cell.clone(), Content::Scene(2, second.clone()));
    drop(journal);
    let (_journal, kept) = open(&place).unwrap();
    same(&kept, &arm, &robot(0.5));
    same(&kept, &cell, &Content::Scene(2, second));
}

#[test]
fn changes_that_wait_are_written_as_the_newest_and_the_end_in_order_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let cell = key(Kind::Scene, "cell");
    let (journal, _) = open(folder.path()).unwrap();
    let (told, heard) = mpsc::channel();
    let told = Box::new(move |ticket, failure| told.send((ticket, failure)).unwrap());
    let (entries, thread) = journal
        .start(BTreeMap::new(), BTreeSet::new(), told)
        .unwrap();
    let mut newest = scene(1.0);
    for ticket in 1..=100 {
        newest = moved(&newest, "mesh", ticket as f64);
        let state = of_client(Content::Scene(ticket, newest.clone()));
        entries
            .send(Entry::Changed(ticket, cell.clone(), state))
            .unwrap();
    }
    let mut last = 0;
    while last < 100 {
        let (ticket, failure) = heard.recv().unwrap();
        assert!(
            ticket > last && failure.is_none(),
            "{ticket} after {last}: {failure:?}"
        );
        last = ticket;
    }
    entries.send(Entry::End).unwrap();
    drop(entries);
    thread.join().unwrap();
    let (_journal, kept) = open(folder.path()).unwrap();
    assert!(kept.ended);
    same(&kept, &cell, &Content::Scene(100, newest));
}
