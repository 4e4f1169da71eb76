//! Robots and scenes with meshes from a machine whose files the daemon does not see.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::*;
use taut_ipc::content::{Progress, carry};
use taut_ipc::control::{
    ControlReply, ControlRequest, RobotDescription, RobotSource, SceneSummary,
};
use taut_ipc::limits::GIVE_MAX;
use taut_ipc::wire::Code;
use taut_ipc::{Client, ClientError};

const TETRAHEDRON: &str =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const SRDF: &str =
    "<robot name='leg'><disable_collisions link1='hip' link2='foot' reason='Adjacent'/></robot>";

/// A robot of three meshes, two of them with equal content, by all kinds of names.
fn urdf() -> String {
    let link = |name: &str, mesh: &str| {
        format!(
            "<link name='{name}'><collision><geometry><mesh filename='{mesh}' scale='1 1 2'/></geometry></collision></link>"
        )
    };
    let joint = |parent: &str, child: &str| {
        format!(
            "<joint name='to_{child}' type='revolute'><parent link='{parent}'/><child link='{child}'/>\
             <origin xyz='0.5 0 0'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
        )
    };
    [
        "<robot name='leg'>".to_owned(),
        link("hip", "package://legs/meshes/hip.obj"),
        link("knee", "meshes/same%20again.obj"),
        link("foot", "foot.stl"),
        joint("hip", "knee"),
        joint("knee", "foot"),
        "</robot>".to_owned(),
    ]
    .concat()
}

/// A folder of pieces beyond a message's size, so that the file takes several.
fn stl() -> Vec<u8> {
    let corners = [
        [0.0_f32, 0.0, 0.0],
        [0.1, 0.0, 0.0],
        [0.0, 0.1, 0.0],
        [0.0, 0.0, 0.1],
    ];
    let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let copies = GIVE_MAX * 5 / 2 / 200;
    let mut bytes = vec![b' '; 80];
    bytes.extend((copies as u32 * 4).to_le_bytes());
    for copy in 0..copies {
        let offset = copy as f32 * 1e-5;
        for side in sides {
            bytes.extend([0; 12]);
            for corner in side {
                bytes.extend(
                    corners[corner]
                        .iter()
                        .flat_map(|x| (x + offset).to_le_bytes()),
                );
            }
            bytes.extend([0; 2]);
        }
    }
    bytes
}

/// The planner's machine: files that it loads from, and that are hidden from the daemon whenever
/// that has a message to deal with.
struct Machine {
    client: Client,
    place: Place,
    _daemon: Daemon,
    /// Bytes of files that were sent.
    sent: u64,
    /// Messages that were sent.
    messages: u32,
}

impl Machine {
    fn new() -> Self {
        let place = Place::new();
        let daemon = place.serve("");
        let machine = Self {
            client: place.client(),
            place,
            _daemon: daemon,
            sent: 0,
            messages: 0,
        };
        let legs = machine.shown();
        fs::create_dir_all(legs.join("meshes")).unwrap();
        fs::write(legs.join("package.xml"), "<package/>").unwrap();
        fs::write(legs.join("leg.urdf"), urdf()).unwrap();
        fs::write(legs.join("leg.srdf"), SRDF).unwrap();
        fs::write(legs.join("meshes/hip.obj"), TETRAHEDRON).unwrap();
        fs::write(legs.join("meshes/same again.obj"), TETRAHEDRON).unwrap();
        fs::write(legs.join("foot.stl"), stl()).unwrap();
        fs::write(legs.join("secret.txt"), "nobody's business").unwrap();
        machine
    }

    fn shown(&self) -> PathBuf {
        self.place.folder.path().join("legs")
    }

    /// Sends it as to another machine.
    fn carry(&mut self, message: ControlRequest) -> ControlReply {
        let (shown, hidden) = (self.shown(), self.place.folder.path().join("hidden"));
        let client = self.client.clone();
        let (mut sent, mut messages) = (0, 0);
        let mut tell = |message: &ControlRequest| -> Result<ControlReply, ClientError> {
            messages += 1;
            if let ControlRequest::Give { bytes, .. } = message {
                sent += bytes.len() as u64;
            }
            fs::rename(&shown, &hidden).unwrap();
            let reply = client.control(message, PATIENCE);
            fs::rename(&hidden, &shown).unwrap();
            reply
        };
        let mut last = Vec::new();
        let mut progress = |progress: Progress<'_>| {
            last.push((progress.file.to_owned(), progress.sent, progress.bytes));
        };
        let reply = carry(message, &mut tell, &mut progress).unwrap();
        assert!(
            last.iter()
                .all(|(file, sent, bytes)| file.is_file() && sent <= bytes)
        );
        self.sent += sent;
        self.messages += messages;
        reply
    }

    fn load(&self, label: &str) -> ControlRequest {
        let legs = self.shown();
        ControlRequest::LoadRobot {
            label: label.to_owned(),
            source: RobotSource {
                urdf: legs.join("leg.urdf"),
                srdf: Some(legs.join("leg.srdf")),
                packages: [("legs".to_owned(), legs)].into(),
                ..RobotSource::default()
            },
            replace: false,
            files: None,
        }
    }

    fn by_path(&self, message: &ControlRequest) -> ControlReply {
        self.client.control(message, PATIENCE).unwrap()
    }
}

fn robot(reply: ControlReply) -> RobotDescription {
    match reply {
        ControlReply::Robot(robot) => *robot,
        other => panic!("{other:?}"),
    }
}

fn scene(reply: ControlReply) -> SceneSummary {
    match reply {
        ControlReply::Scene(scene) => scene,
        other => panic!("{other:?}"),
    }
}

fn refused(reply: ControlReply) -> (Code, String) {
    match reply {
        ControlReply::Refused(refusal) => (Code::try_from(refusal.code).unwrap(), refusal.message),
        other => panic!("{other:?}"),
    }
}

fn with_mesh(label: &str, file: &str, base_dir: &Path) -> ControlRequest {
    let json = format!(
        "{{\"objects\": [{{\"id\": \"stone\", \"meshes\": [{{\"file\": {file:?}}}], \"mesh_poses\": [{{}}]}}]}}"
    );
    ControlRequest::LoadScene {
        label: label.to_owned(),
        json,
        base_dir: Some(base_dir.to_owned()),
        replace: false,
        files: None,
        version: None,
    }
}

#[test]
fn what_is_carried_is_what_is_loaded_by_path() {
    let mut machine = Machine::new();
    let carried = robot(machine.carry(machine.load("carried")));
    let size = |name: &str| {
        fs::metadata(machine.shown().join(name))
            .unwrap()
            .len()
    };
    let all = ["leg.urdf", "leg.srdf", "meshes/hip.obj", "foot.stl"];
    let all: u64 = all.iter().map(|name| size(name)).sum();
    assert_eq!(machine.sent, all, "equal content once");
    let loaded = robot(machine.by_path(&machine.load("loaded")));
    assert_eq!(
        (carried.robot_hash, &carried.variables, &carried.warnings),
        (loaded.robot_hash, &loaded.variables, &loaded.warnings)
    );
    // What the daemon has it wants no more, whoever gave it.
    machine.messages = 0;
    let again = robot(machine.carry(machine.load("again")));
    assert_eq!(again.robot_hash, loaded.robot_hash);
    assert_eq!(
        (machine.sent, machine.messages),
        (all, 2),
        "names, then all"
    );
    // A scene, and a change to it.
    let legs = machine.shown();
    let stone = scene(machine.carry(with_mesh("stone", "meshes/hip.obj", &legs)));
    let by_path = scene(machine.by_path(&with_mesh("same", "meshes/hip.obj", &legs)));
    assert_eq!(stone.scene_hash, by_path.scene_hash);
    assert_eq!(machine.sent, all);
    let diff = |label: &str| {
        ControlRequest::DiffScene {
        label: label.to_owned(),
        json: r#"{"is_diff": true, "objects": [{"id": "foot", "operation": "ADD", "meshes": [{"file": "foot.stl"}], "mesh_poses": [{}]}]}"#
            .to_owned(),
        base_dir: Some(legs.clone()),
        base_version: 0,
        files: None,
        version: Some(5),
    }
    };
    let changed = scene(machine.carry(diff("stone")));
    let by_path = scene(machine.by_path(&diff("same")));
    assert_eq!(
        (changed.scene_hash, changed.version),
        (by_path.scene_hash, 5)
    );
    assert_eq!(machine.sent, all);
}

#[test]
fn what_cannot_be_carried_is_refused_by_the_users_own_name() {
    let mut machine = Machine::new();
    let legs = machine.shown();
    let missing = with_mesh("a", "nowhere.stl", &legs);
    let (code, text) = refused(machine.carry(missing));
    assert_eq!(code, Code::InvalidModel);
    assert!(
        text.contains("nowhere.stl") && !text.contains('\n'),
        "{text}"
    );
    let (code, text) = refused(machine.carry(with_mesh("a", "secret.txt", &legs)));
    let secret = legs.join("secret.txt").display().to_string();
    assert_eq!(code, Code::InvalidModel);
    assert!(
        text.contains(&secret) && text.contains("stl, obj, dae"),
        "{text}"
    );
    fs::write(legs.join("broken.obj"), "f 1 2 3\n").unwrap();
    let (code, text) = refused(machine.carry(with_mesh("a", "broken.obj", &legs)));
    assert_eq!(code, Code::InvalidModel);
    assert!(text.contains("broken.obj"), "{text}");
    fs::remove_file(legs.join("leg.srdf")).unwrap();
    let (code, text) = refused(machine.carry(machine.load("leg")));
    let srdf = legs.join("leg.srdf").display().to_string();
    assert_eq!(code, Code::UnreadableFile);
    assert!(text.starts_with(&srdf), "{text}");
    assert_eq!(machine.sent, 8, "the broken mesh, and nothing else");
}
