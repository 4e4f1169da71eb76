//! Every condition has its code and its exit, and the daemon serves on after each.
#![cfg(feature = "daemon")]

mod common;

use common::*;
use taut_ipc::client::Response;
use taut_ipc::control::{ControlReply, ControlRequest, RobotSource};
use taut_ipc::wire::{Code, RequestBody, RequestHeader};
use taut_ipc::{Client, ClientError};

struct Served {
    place: Place,
    daemon: Daemon,
    client: Client,
    arm: Models,
}

impl Served {
    fn new(lines: &str) -> Self {
        let place = Place::new();
        let daemon = place.serve(lines);
        let client = place.client();
        let arm = Models::of(&client, "arm_shelf");
        Self {
            place,
            daemon,
            client,
            arm,
        }
    }

    fn ask(&self, models: &Models, change: impl FnOnce(&mut RequestHeader)) -> Response {
        let loan = models.request(&self.client, RequestBody::default(), change);
        loan.send().unwrap().wait(PATIENCE).unwrap()
    }

    /// The request is answered with this code and says why; then the daemon still serves.
    fn refuses(
        &mut self,
        code: Code,
        part: &str,
        models: &Models,
        change: impl FnOnce(&mut RequestHeader),
    ) {
        let response = self.ask(models, change);
        assert_eq!(response.code(), code, "{}", response.message());
        assert!(
            response.message().contains(part),
            "{code}: {}",
            response.message()
        );
        self.serves();
    }

    fn serves(&mut self) {
        assert_eq!(self.ask(&self.arm, |_| ()).code(), Code::Success);
        assert!(self.daemon.is_alive());
    }

    fn control(&self, message: &ControlRequest) -> Result<ControlReply, (Code, String)> {
        match self.client.control(message, PATIENCE).unwrap() {
            ControlReply::Refused(refusal) => {
                Err((Code::try_from(refusal.code).unwrap(), refusal.message))
            }
            reply => Ok(reply),
        }
    }

    fn load_scene(&self, label: &str, json: &str) -> Result<ControlReply, (Code, String)> {
        let label = label.to_owned();
        let json = json.to_owned();
        self.control(&ControlRequest::LoadScene {
            label,
            json,
            base_dir: None,
            replace: false,
            files: None,
            version: None,
        })
    }
}

/// A path of `rooms` from its first waypoint, with a waypoint in the middle of a wall.
fn into_the_wall(rooms: &Models) -> [f64; 2] {
    let wall = problem("rooms")["scene"]["objects"][0]["primitive_poses"][0]["position"].clone();
    assert_eq!(rooms.nq(), 2);
    [wall[0].as_f64().unwrap(), wall[1].as_f64().unwrap()]
}

#[test]
fn collisions_have_their_place_and_their_exit() {
    let mut served = Served::new("");
    let rooms = Models::of(&served.client, "rooms");
    let free = [rooms.path[0], rooms.path[1]];
    let wall = into_the_wall(&rooms);
    for (path, code) in [
        (vec![free, wall, free], Code::InvalidMotionPlan),
        (vec![wall, free], Code::StartStateInCollision),
        (
            vec![free, wall, [wall[0], wall[1] - 0.1]],
            Code::GoalInCollision,
        ),
    ] {
        let models = Models {
            path: path.concat(),
            ..rooms.clone()
        };
        let response = served.ask(&models, |_| ());
        assert_eq!(response.code(), code);
        assert_eq!(
            response.path(),
            models.path,
            "what collides comes back as it was"
        );
        let view = response.view().unwrap();
        let refusal = view.refusal.unwrap();
        let names = refusal.requirement.names(view.names).unwrap();
        assert!(
            names.iter().any(|name| name == "wall_left_low"),
            "{names:?}"
        );
        served.serves();

        let rows: Vec<Vec<f64>> = path.iter().map(|row| row.to_vec()).collect();
        let text = serde_json::json!({ "variables": ["x", "y"], "path": rows }).to_string();
        let file = served.place.file("path.json", &text);
        let problem = config("problems/rooms.json");
        let arguments = ["check", &file, "--problem", &problem, "--format", "json"];
        let remote = served.place.taut(&arguments);
        let local = served
            .place
            .taut(&[&arguments[..], &["--local"]].concat());
        assert_eq!((remote.exit, local.exit), (1, 1), "{}", remote.err);
        let mut remote = remote.json();
        let mut local = local.json();
        assert_eq!(remote["code"].as_i64(), Some(i64::from(i32::from(code))));
        for cost in ["cpu_s", "time_s", "request_id"] {
            remote[cost] = 0.into();
            local[cost] = 0.into();
        }
        assert_eq!(remote, local);
    }
}

#[test]
fn what_is_too_near_is_uncertified() {
    let mut served = Served::new("");
    let arm = served.arm.clone();
    let response = served.ask(&arm, |header| (header.clearance_m, header.flags) = (0.3, 1));
    assert_eq!(
        (response.code(), response.path()),
        (Code::Uncertified, &arm.path[..])
    );
    served.serves();
    let file = config("problems/arm_shelf.json");
    let run = served
        .place
        .taut(&["check", &file, "--clearance", "0.3", "--strict"]);
    assert_eq!(run.exit, 2);
    assert!(run.out.starts_with("TOO_CLOSE segment "), "{}", run.out);
}

#[test]
fn wrong_numbers_are_an_invalid_state() {
    let mut served = Served::new("");
    let arm = served.arm.clone();
    let with = |index: usize, value: f64| {
        let mut models = arm.clone();
        models.path[index] = value;
        models
    };
    let state = Code::InvalidRobotState;
    served.refuses(state, "joint1 is NaN", &with(7, f64::NAN), |_| ());
    served.refuses(state, "joint2 is inf", &with(8, f64::INFINITY), |_| ());
    let above = with(7, arm.robot.variables[0].upper + 1e-3);
    served.refuses(state, "outside [", &above, |_| ());
    served.refuses(state, "the path has 6 columns", &arm, |header| {
        header.variables = 6
    });
    served.refuses(state, "layout hash", &arm, |header| header.layout_hash += 1);
    served.refuses(state, "layout hash", &arm, |header| header.layout_hash = 0);
    let mut ell = Models::of(&served.client, "ell_window");
    ell.path[7 + 3] *= 2.0;
    ell.path[7 + 6] += 0.5;
    served.refuses(state, "norm", &ell, |_| ());

    let mut problem = problem("rooms");
    problem["path"][1][0] = 1e6.into();
    let text = problem
        .to_string()
        .replace("../robots", &config("robots"));
    let file = served.place.file("far.json", &text);
    let run = served.place.taut(&["check", &file]);
    assert_eq!(run.exit, 65);
    assert!(
        run.err.contains("INVALID_ROBOT_STATE") && run.err.lines().count() == 1,
        "{}",
        run.err
    );
}

#[test]
fn what_is_unknown_is_named_with_what_is_known() {
    let mut served = Served::new("");
    let arm = served.arm.clone();
    served.refuses(Code::InvalidGroupName, "arm 0", &arm, |header| {
        header.group = 5
    });
    served.refuses(Code::UnknownRobot, "arm_shelf", &arm, |header| {
        header.robot_id = 1
    });
    served.refuses(Code::UnknownScene, "arm_shelf", &arm, |header| {
        header.scene_id = 0
    });
    served.refuses(Code::VersionConflict, "hash", &arm, |header| {
        header.robot_hash = 1
    });
    served.refuses(Code::VersionConflict, "hash", &arm, |header| {
        header.scene_hash = 1
    });
    served.refuses(Code::VersionConflict, "version 1", &arm, |header| {
        header.scene_version = 2
    });

    // A scene may allow pairs that this robot does not have.
    let object = r#""objects": [{"id": "cup", "primitives": [{"type": "sphere", "dimensions": [0.01]}],
        "primitive_poses": [{"position": [9, 9, 9]}]}]"#;
    let link = arm.robot.variables.len(); // any number: the labels only have to differ
    let first_link = "link7";
    for (label, pair, code) in [
        (
            "no_link",
            r#"["cup", "gripper"]"#.to_owned(),
            Code::InvalidLinkName,
        ),
        (
            "no_object",
            format!("[\"{first_link}\", \"mug\"]"),
            Code::InvalidObjectName,
        ),
    ] {
        let json = format!("{{ {object}, \"allowed_collisions\": [{pair}] }}");
        let Ok(ControlReply::Scene(scene)) = served.load_scene(label, &json) else {
            panic!("{label} {link}")
        };
        let models = Models {
            scene,
            ..arm.clone()
        };
        served.refuses(code, "neither a link nor an object", &models, |_| ());
    }
    let message = ControlRequest::UnloadScene {
        label: "no_scene".to_owned(),
    };
    assert_eq!(served.control(&message).unwrap_err().0, Code::UnknownScene);
    let message = ControlRequest::Describe {
        label: "no_robot".to_owned(),
    };
    assert_eq!(served.control(&message).unwrap_err().0, Code::UnknownRobot);
    assert_eq!(
        served
            .place
            .taut(&["describe", "no_robot"])
            .exit,
        66
    );
    assert_eq!(
        served
            .place
            .taut(&["unload-scene", "no_scene"])
            .exit,
        66
    );
}

#[test]
fn malformed_requests_name_the_valid_values() {
    let mut served = Served::new("");
    let arm = served.arm.clone();
    let malformed = Code::MalformedRequest;
    served.refuses(malformed, "mode", &arm, |header| header.mode = 17);
    served.refuses(malformed, "flags", &arm, |header| header.flags = 1 << 9);
    served.refuses(malformed, "clearance_m", &arm, |header| {
        header.clearance_m = f64::NAN
    });
    served.refuses(malformed, "clearance 0.0000001 m", &arm, |header| {
        header.clearance_m = 1e-7
    });
    for (body, part) in [
        (
            RequestBody {
                weights: &[1.0, 2.0],
                ..Default::default()
            },
            "2 weights given",
        ),
        (
            RequestBody {
                held_values: &[1.0],
                ..Default::default()
            },
            "held values",
        ),
        (
            RequestBody {
                group_mask: &[1, 1, 2, 0, 0, 0, 0],
                ..Default::default()
            },
            "valid: 0, 1",
        ),
    ] {
        let response = arm
            .request(&served.client, body, |_| ())
            .send()
            .unwrap()
            .wait(PATIENCE)
            .unwrap();
        assert_eq!(response.code(), malformed, "{}", response.message());
        assert!(response.message().contains(part), "{}", response.message());
        served.serves();
    }
}

#[test]
fn what_is_too_large_is_refused_before_it_is_sent() {
    let served = Served::new("");
    let error = served
        .client
        .request(1_000_000, 7)
        .loan()
        .unwrap_err();
    assert_eq!(error.code(), Code::ResourceExhausted);
    let row = "[-4.2, -3.8]";
    let rows = vec![row; 150_000].join(",");
    let file = served.place.file(
        "long.json",
        &format!(r#"{{"variables": ["x", "y"], "path": [{rows}]}}"#),
    );
    let run = served
        .place
        .taut(&["check", &file, "--problem", &config("problems/rooms.json")]);
    assert_eq!(run.exit, 67, "{}", run.err);
    let json = format!(r#"{{"objects": [], "name": "{}"}}"#, "x".repeat(17 << 20));
    let message = ControlRequest::LoadScene {
        label: "huge".to_owned(),
        json,
        base_dir: None,
        replace: false,
        files: None,
        version: None,
    };
    let error = served
        .client
        .control(&message, PATIENCE)
        .unwrap_err();
    assert_eq!(error.code(), Code::ResourceExhausted);
}

#[test]
fn a_panic_costs_its_own_request_only() {
    let mut served = Served::new("workers = 1");
    let arm = served.arm.clone();
    // Different ones: what crashed twice is not tried again.
    for work_budget in 1..4 {
        let crash = |header: &mut RequestHeader| {
            (header.seed, header.work_budget) = (PANIC_SEED, work_budget)
        };
        served.refuses(Code::Crash, "injected fault", &arm, crash);
    }
    let file = config("problems/arm_shelf.json");
    let run = served
        .place
        .taut(&["shorten", &file, "--seed", &PANIC_SEED.to_string()]);
    assert_eq!(run.exit, 70, "{}", run.err);
    assert_eq!(stats(&served.client).numbers["worker_panics"], 4.0);
}

#[test]
fn a_label_names_one_content() {
    let served = Served::new("");
    let scene = |id: &str| {
        let id = format!(
            r#"{{"objects": [{{"id": "{id}", "primitives": [{{"type": "sphere", "dimensions": [0.1]}}]"#
        );
        format!(r#"{id}, "primitive_poses": [{{"position": [9, 9, 9]}}]}}]}}"#)
    };
    let first = served.place.file("a.json", &scene("a"));
    let second = served.place.file("b.json", &scene("b"));
    let load = |arguments: &[&str]| {
        served
            .place
            .taut(&[&["load-scene", "cell"], arguments].concat())
    };
    assert_eq!(
        load(&[&first]).out.split("  ").next(),
        Some("scene cell v1")
    );
    assert_eq!(load(&[&first]).exit, 0, "the same again is no conflict");
    let run = load(&[&second]);
    assert_eq!(run.exit, 66);
    assert!(
        run.err.contains("LABEL_TAKEN") && run.err.contains("replace"),
        "{}",
        run.err
    );
    assert_eq!(
        load(&[&second, "--replace"])
            .out
            .split("  ")
            .next(),
        Some("scene cell v2")
    );
    assert_eq!(
        served
            .place
            .taut(&["unload-scene", "cell"])
            .exit,
        0
    );
    assert!(
        !served
            .place
            .taut(&["list"])
            .out
            .contains("cell")
    );

    let urdf = config("robots/disc.urdf");
    let run = served
        .place
        .taut(&["load-robot", "arm_shelf", "--urdf", &urdf]);
    assert_eq!(run.exit, 66, "{}", run.err);
    let run = served
        .place
        .taut(&["load-robot", "disc", "--urdf", &urdf, "--format", "json"]);
    assert_eq!(run.json()["nq"].as_u64(), Some(2), "{}", run.err);
    let problem = config("problems/ell_window.json");
    assert_eq!(
        served
            .place
            .taut(&["load-robot", "ell", "--problem", &problem])
            .exit,
        0
    );
    let described = served.place.taut(&["describe", "ell"]);
    assert!(
        described.out.contains("root_joint/rot_w"),
        "{}",
        described.out
    );
    assert_eq!(served.place.taut(&["unload-robot", "ell"]).exit, 0);
}

#[test]
fn bad_files_are_told_with_their_place() {
    let mut served = Served::new("");
    let link = |name: &str| format!("<link name=\"{name}\"/>");
    let joint = |name: &str, parent: &str, child: &str, limit: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 0 1\"/><limit {limit} effort=\"1\" velocity=\"1\"/></joint>"
        )
    };
    let fine = "lower=\"-1\" upper=\"1\"";
    let mesh = |file: &str| {
        format!(
            "<link name=\"a\"><collision><geometry><mesh filename=\"{file}\"/></geometry></collision></link>"
        )
    };
    served.place.file(
        "cut.stl",
        "solid cut\nfacet normal 0 0 1\nouter loop\nvertex 0 0",
    );
    let cases = [
        (
            "loop",
            [
                link("a"),
                link("b"),
                joint("j", "a", "b", fine),
                joint("k", "b", "a", fine),
            ]
            .concat(),
            "loop",
        ),
        (
            "parent",
            [link("a"), joint("j", "nobody", "a", fine)].concat(),
            "nobody",
        ),
        ("twice", [link("a"), link("a")].concat(), "defined twice"),
        (
            "limits",
            [
                link("a"),
                link("b"),
                joint("j", "a", "b", "lower=\"NaN\" upper=\"1\""),
            ]
            .concat(),
            "limit",
        ),
        ("no_mesh", mesh("nowhere.stl"), "nowhere.stl"),
        ("cut_mesh", mesh("cut.stl"), "cut.stl"),
        ("no_xml", "<link".to_owned(), "no_xml.urdf"),
    ];
    for (name, body, part) in cases {
        let file = served.place.file(
            &format!("{name}.urdf"),
            &format!("<robot name=\"r\">{body}</robot>"),
        );
        let run = served
            .place
            .taut(&["load-robot", name, "--urdf", &file]);
        assert_eq!(run.exit, 65, "{name}: {}{}", run.out, run.err);
        assert!(
            run.err.contains("INVALID_MODEL") && run.err.contains(part),
            "{name}: {}",
            run.err
        );
        served.serves();
    }
    let run = served
        .place
        .taut(&["load-robot", "none", "--urdf", "/nowhere/none.urdf"]);
    assert_eq!(run.exit, 66, "{}", run.err);
    assert!(run.err.contains("UNREADABLE_FILE"), "{}", run.err);
    let source = RobotSource {
        urdf: "relative.urdf".into(),
        ..RobotSource::default()
    };
    let message = ControlRequest::LoadRobot {
        label: "r".to_owned(),
        source,
        replace: false,
        files: None,
    };
    assert_eq!(
        served.control(&message).unwrap_err().0,
        Code::MalformedRequest
    );

    for (json, part) in [
        ("{", "not a scene"),
        (r#"{"objects": [{"id": "a"}, {"id": "a"}]}"#, "a"),
    ] {
        let file = served.place.file("scene.json", json);
        let run = served.place.taut(&["load-scene", "bad", &file]);
        assert_eq!(run.exit, 65, "{}{}", run.out, run.err);
        assert!(
            run.err.contains("INVALID_MODEL") && run.err.contains(part),
            "{}",
            run.err
        );
        served.serves();
    }
    assert_eq!(
        served
            .place
            .taut(&["load-scene", "bad", "/nowhere/scene.json"])
            .exit,
        66
    );
}

#[test]
fn usage_and_a_missing_daemon_have_their_exits() {
    let place = Place::new();
    let file = config("problems/rooms.json");
    let run = place.taut(&["check", &file]);
    assert_eq!(run.exit, 69);
    assert!(
        run.err.contains("taut serve") && run.err.contains("--local"),
        "{}",
        run.err
    );
    for arguments in [vec!["list"], vec!["stop"], vec!["load-scene", "a", &file]] {
        assert_eq!(place.taut(&arguments).exit, 69);
    }
    assert!(matches!(
        Client::connect(&place.instance),
        Err(ClientError::DaemonLost { .. })
    ));
    assert_eq!(
        place
            .taut(&["serve", "--instance", "Not A Name"])
            .exit,
        64
    );
    assert_eq!(place.taut(&["load-robot", "r"]).exit, 64);
    assert_eq!(
        place
            .taut(&["serve", "--config", "/nowhere.toml"])
            .exit,
        66
    );
    let config = place.file("bad.toml", "workers = 1\nworkres = 2\n");
    let run = place.taut(&["serve", "--config", &config]);
    assert_eq!(run.exit, 65);
    assert!(
        run.err.contains("line 2") && run.err.contains("workres"),
        "{}",
        run.err
    );
    let config = place.file(
        "bad.toml",
        "[[scenes]]\nlabel = \"a\"\nfile = \"none.json\"\n",
    );
    assert_eq!(place.taut(&["serve", "--config", &config]).exit, 66);
    let _daemon = place.serve("");
    let run = place.taut(&["serve"]);
    assert_eq!(run.exit, 69);
    assert!(run.err.contains("another daemon serves"), "{}", run.err);
}

#[test]
fn a_scene_on_its_way_is_loading() {
    let served = Served::new("");
    let objects: Vec<String> = (0..20_000)
        .map(|i| {
            format!(
                r#"{{"id": "o{i}", "primitives": [{{"type": "sphere", "dimensions": [0.1]}}], "primitive_poses": [{{"position": [9, 9, {i}]}}]}}"#
            )
        })
        .collect();
    let json = format!(r#"{{"objects": [{}]}}"#, objects.join(","));
    let other = served.place.client();
    let arm = &served.arm;
    let id = taut_ipc::wire::label_id("large");
    std::thread::scope(|scope| {
        let load = scope.spawn(|| served.load_scene("large", &json).unwrap());
        let mut seen = None;
        until("the scene is loading", || {
            let loan = arm.request(&other, RequestBody::default(), |header| {
                header.scene_id = id;
                header.mode = 0;
                header.deadline_ns = 1;
            });
            let response = loan.send().unwrap().wait(PATIENCE).unwrap();
            seen = (response.code() != Code::UnknownScene)
                .then(|| (response.code(), response.header().retry_after_ms));
            seen.is_some()
        });
        assert!(matches!(seen, Some((Code::Loading, 1..))), "{seen:?}");
        load.join().unwrap();
    });
}

#[test]
fn a_full_queue_is_told_at_once() {
    let served = Served::new("workers = 1\nqueue = 1");
    let clients: Vec<Client> = (0..3).map(|_| served.place.client()).collect();
    let slow = |client: &Client| {
        served
            .arm
            .request(client, RequestBody::default(), patient)
            .send()
            .unwrap()
    };
    let _running = served
        .arm
        .request(&clients[0], RequestBody::default(), endless)
        .send()
        .unwrap();
    until("the first one runs", || {
        stats(&served.client).numbers["requests_running"] == 1.0
    });
    let _waiting = slow(&clients[1]);
    until("the second one waits", || {
        stats(&served.client).numbers["requests_queued"] == 1.0
    });
    let response = slow(&clients[2]).wait(PATIENCE).unwrap();
    assert_eq!(response.code(), Code::Overloaded);
    assert!(
        response.header().retry_after_ms > 0,
        "{}",
        response.message()
    );
}
