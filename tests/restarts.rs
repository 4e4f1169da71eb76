//! Daemons that die, hang and come back: with every robot and scene as it was acknowledged, or with
//! a reason.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use common::*;
use taut_ipc::control::{ControlReply, ControlRequest, Listing};
use taut_ipc::wire::{Code, Mode, RequestBody, ResponseFlags};
use taut_ipc::{Client, DaemonState, deadline_after};

/// A configuration with one problem.
fn configured(place: &Place, lines: &str) -> String {
    let problem = config("problems/arm_shelf.json");
    let text = format!(
        "fault_injection = true\n{lines}\n[[problems]]\nfile = {problem:?}\nrobot = \"arm_shelf\"\nscene = \"arm_shelf\"\n"
    );
    place.file("restarts.toml", &text)
}

/// A daemon, supervised or not, with its messages in a file.
struct Served {
    child: Daemon,
    messages: String,
}

impl Served {
    fn start(place: &Place, arguments: &[&str]) -> Self {
        let messages = place.file("messages", "");
        let err = fs::File::create(&messages).unwrap();
        let mut command = place.command(&[&["serve"], arguments].concat());
        let child: Child = command
            .stdout(Stdio::null())
            .stderr(err)
            .spawn()
            .unwrap();
        let served = Self {
            child: Daemon(child),
            messages,
        };
        until("a daemon is up", || pid(place).is_some());
        served
    }

    fn messages(&self) -> String {
        fs::read_to_string(&self.messages).unwrap()
    }
}

fn pid(place: &Place) -> Option<u32> {
    match taut_ipc::daemon_state(&place.instance) {
        Ok(DaemonState::Running { pid, .. }) => Some(pid),
        _ => None,
    }
}

fn signal(pid: u32, signal: &str) {
    assert!(
        Command::new("kill")
            .args([signal, &pid.to_string()])
            .status()
            .unwrap()
            .success()
    );
}

/// Kills the daemon and waits for the next one.
fn kill_and_wait(place: &Place) {
    let killed = pid(place).unwrap();
    signal(killed, "-KILL");
    let back = until("the next daemon is up", || {
        pid(place).is_some_and(|pid| pid != killed)
    });
    println!("killed -> the next daemon is up: {back:?}");
}

/// What is loaded, by label: hashes, and versions of scenes.
fn listing(client: &Client) -> Listing {
    match taut_ipc::client::retry(PATIENCE, || client.control(&ControlRequest::List, PATIENCE)) {
        Ok(ControlReply::Listing(mut listing)) => {
            // Only the newest versions come back.
            listing
                .scenes
                .iter_mut()
                .for_each(|scene| scene.kept_from = 0);
            // How far they are made is no part of what they are.
            listing.models.clear();
            listing
        }
        other => panic!("{other:?}"),
    }
}

fn load_scene(place: &Place, label: &str, file: &str) {
    let run = place.taut(&["load-scene", label, file, "--replace"]);
    assert_eq!(run.exit, 0, "{}", run.err);
}

#[test]
fn a_supervised_daemon_comes_back_with_everything_and_requests_are_answered() {
    let place = Place::new();
    let config_file = configured(&place, "");
    let served = Served::start(&place, &["--config", &config_file, "--supervise"]);
    load_scene(&place, "cell", &config("scenes/arm_window.json"));
    load_scene(&place, "arm_shelf", &config("scenes/arm_window.json"));
    load_scene(&place, "arm_shelf", &config("scenes/arm_shelf.json"));
    let client = place.client();
    let before = listing(&client);
    let arm = Models::of(&client, "arm_shelf");
    assert_eq!(arm.scene.version, 3);
    for _ in 0..3 {
        // One request is only sent, one goes on until it is answered.
        let lost = arm
            .request(&client, RequestBody::default(), endless)
            .send()
            .unwrap();
        let recovering = std::thread::spawn({
            let client = client.clone();
            let arm = arm.clone();
            move || {
                let mut request = client.request(0, 0);
                request.header = arm.header();
                endless(&mut request.header);
                request.header.deadline_ns = deadline_after(Duration::from_secs(3));
                request
                    .answer(&arm.path, PATIENCE, &mut |_| ())
                    .map(|response| (response.code(), *response.header()))
            }
        });
        until("both run", || {
            stats(&client).numbers["requests_running"] == 2.0
        });
        let boot_id = stats(&client).boot_id;
        kill_and_wait(&place);
        assert_eq!(lost.wait(PATIENCE).unwrap_err().code(), Code::DaemonLost);
        let (code, header) = recovering.join().unwrap().unwrap();
        assert_eq!(
            (code, header.flags & ResponseFlags::PROVED),
            (Code::Success, ResponseFlags::PROVED)
        );
        assert_ne!(header.boot_id, boot_id);
        assert_eq!(
            (header.scene_version, header.scene_hash),
            (3, arm.scene.scene_hash)
        );
        assert_eq!(listing(&client), before);
    }
    let file = config("problems/arm_shelf.json");
    assert_eq!(place.taut(&["check", &file]).exit, 0);
    let messages = served.messages();
    assert_eq!(
        messages
            .matches("died of signal 9; it is started again")
            .count(),
        3,
        "{messages}"
    );
    signal(served.child.pid(), "-TERM");
    assert_eq!(served.child.wait(), 0);
    assert_eq!(pid(&place), None);
}

#[test]
fn a_supervisor_gives_up_restarts_what_hangs_and_takes_its_daemon_along() {
    let place = Place::new();
    let config_file = configured(&place, "watchdog_s = 2.0");
    let served = Served::start(&place, &["--config", &config_file, "--supervise"]);
    let first = pid(&place).unwrap();
    let client = place.client();
    until("its supervisor has heard of it", || {
        stats(&client).uptime_ns > 2_000_000_000
    });
    signal(first, "-STOP");
    until("the one that hangs is replaced", || {
        pid(&place).is_some_and(|pid| pid != first)
    });
    assert!(
        served
            .messages()
            .contains("died of giving no sign of life"),
        "{}",
        served.messages()
    );
    let orphan = pid(&place).unwrap();
    served.child.kill();
    until("the daemon goes with its supervisor", || {
        pid(&place).is_none()
    });
    until("it has ended", || {
        fs::read_to_string(format!("/proc/{orphan}/stat"))
            .map_or(true, |stat| stat.contains(") Z "))
    });

    let served = Served::start(&place, &["--config", &config_file, "--supervise"]);
    for _ in 0..4 {
        kill_and_wait(&place);
    }
    signal(pid(&place).unwrap(), "-KILL");
    let messages = served.messages.clone();
    assert_eq!(served.child.wait(), 70);
    let messages = fs::read_to_string(messages).unwrap();
    assert!(
        messages.contains("died 5 times in a row") && messages.contains("signal 9"),
        "{messages}"
    );

    // What is wrong with the configuration is said once.
    let run = place.taut(&["serve", "--supervise", "--config", "/nowhere.toml"]);
    assert_eq!(run.exit, 66, "{}", run.err);
    let wrong = place.file(
        "wrong.toml",
        "[[scenes]]\nlabel = \"a\"\nfile = \"nowhere.json\"\n",
    );
    let run = place.taut(&["serve", "--supervise", "--config", &wrong]);
    assert_eq!((run.exit, run.err.lines().count()), (66, 1), "{}", run.err);
}

#[test]
fn what_was_acknowledged_survives_a_torn_end_and_damage_is_refused() {
    let place = Place::new();
    let journal = place.instance.root().join("state/journal");
    let served = Served::start(&place, &[]);
    load_scene(&place, "cell", &config("scenes/arm_window.json"));
    load_scene(&place, "cell", &config("scenes/arm_shelf.json"));
    load_scene(&place, "gone", &config("scenes/arm_shelf.json"));
    assert_eq!(place.taut(&["unload-scene", "gone"]).exit, 0);
    let before = listing(&place.client());
    assert_eq!((before.scenes.len(), before.scenes[0].version), (1, 2));
    served.child.kill();
    let whole = fs::read(&journal).unwrap();
    fs::write(
        &journal,
        [&whole[..], &1000_u32.to_le_bytes(), b"half a record"].concat(),
    )
    .unwrap();
    let served = Served::start(&place, &[]);
    assert_eq!(listing(&place.client()), before);
    assert!(
        served.messages().contains("half written"),
        "{}",
        served.messages()
    );
    served.child.kill();

    let mut damaged = whole.clone();
    damaged[40] ^= 1;
    fs::write(&journal, &damaged).unwrap();
    let run = place.taut(&["serve"]);
    assert_eq!(run.exit, 66);
    assert!(
        run.err.contains("is damaged at byte") && run.err.contains("--no-state"),
        "{}",
        run.err
    );
    let served = Served::start(&place, &["--no-state"]);
    assert!(listing(&place.client()).scenes.is_empty());
    served.child.kill();
    assert_eq!(fs::read(&journal).unwrap(), damaged);
}

const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

#[test]
fn contents_are_kept_and_not_the_files_they_came_from() {
    let place = Place::new();
    let mesh = place.file("part.obj", TETRAHEDRON);
    let scene = place.file(
        "part.json",
        r#"{"objects": [{"id": "part", "meshes": [{"file": "part.obj"}], "mesh_poses": [{}]}]}"#,
    );
    let first = place.file(
        "first.toml",
        &format!("[[scenes]]\nlabel = \"configured\"\nfile = {scene:?}\n"),
    );
    let served = Served::start(&place, &["--config", &first]);
    load_scene(&place, "loaded", &scene);
    let before = listing(&place.client());
    assert_eq!(before.scenes.len(), 2);
    fs::write(&mesh, TETRAHEDRON.replace("v 0 0 1", "v 0 0 2")).unwrap();
    // After a kill everything is as it was, what the configuration names too.
    served.child.kill();
    let served = Served::start(&place, &["--config", &first]);
    assert_eq!(listing(&place.client()), before);
    // After an end in order the configuration is read again; what a client loaded is not.
    assert_eq!(place.taut(&["stop"]).exit, 0);
    assert_eq!(served.child.wait(), 0);
    let served = Served::start(&place, &["--config", &first]);
    let after = listing(&place.client());
    let scene = |listing: &Listing, label: &str| {
        listing
            .scenes
            .iter()
            .find(|s| s.label == label)
            .unwrap()
            .clone()
    };
    assert_eq!(scene(&after, "loaded"), scene(&before, "loaded"));
    let old = scene(&before, "configured");
    let new = scene(&after, "configured");
    assert_eq!((old.version, new.version), (1, 2));
    assert_ne!(old.scene_hash, new.scene_hash);
    // A mesh that is gone from the state folder: its scene is not served, all others are.
    served.child.kill();
    for entry in fs::read_dir(place.instance.root().join("state/meshes")).unwrap() {
        fs::remove_file(entry.unwrap().path()).unwrap();
    }
    let served = Served::start(&place, &["--config", &first]);
    assert!(listing(&place.client()).scenes.is_empty());
    let messages = served.messages();
    assert!(
        messages.contains("scene loaded is not restored") && messages.contains("scene configured"),
        "{messages}"
    );
}

/// Runs a script as root in a mount namespace of its own; `None`, with the reason printed, where
/// that is not allowed.
fn in_namespace(place: &Place, script: &str) -> Option<Command> {
    let probe = Command::new("unshare")
        .args(["-m", "mount", "-t", "tmpfs", "none", "/mnt"])
        .output();
    match probe {
        Ok(output) if output.status.success() => {}
        other => {
            println!("skipped: no mount namespace here ({other:?})");
            return None;
        }
    }
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", script, env!("CARGO_BIN_EXE_taut")]);
    command
        .env("TAUT_INSTANCE", place.name())
        .env_remove("TAUT_LOG");
    Some(command)
}

#[test]
fn a_full_disk_is_told_and_nobody_hears_success_for_what_would_be_lost() {
    let place = Place::new();
    let state = place.folder.path().join("small");
    fs::create_dir(&state).unwrap();
    let script = format!(
        "mount -t tmpfs -o size=64k none {state} && exec \"$0\" serve --state {state}",
        state = state.display()
    );
    let Some(mut command) = in_namespace(&place, &script) else {
        return;
    };
    let daemon = Daemon(command.stdout(Stdio::null()).spawn().unwrap());
    until("a daemon is up", || pid(&place).is_some());
    let scene = |x: usize| {
        let objects: Vec<String> = (0..100)
            .map(|index| {
                format!(
                    r#"{{"id": "box{index}", "primitives": [{{"type": "box", "dimensions": [1, 1, 1]}}], "primitive_poses": [{{"position": [{x}, {index}, 0]}}]}}"#
                )
            })
            .collect();
        format!(r#"{{"objects": [{}]}}"#, objects.join(", "))
    };
    let mut loaded = 0;
    let refusal = loop {
        let file = place.file("scene.json", &scene(loaded));
        let run = place.taut(&["load-scene", &format!("scene{loaded}"), &file]);
        if run.exit != 0 {
            break run;
        }
        loaded += 1;
        assert!(loaded < 100, "64 kB hold no 100 scenes");
    };
    assert_eq!(refusal.exit, 67, "{}", refusal.err);
    assert!(
        refusal.err.contains("RESOURCE_EXHAUSTED") && refusal.err.contains("No space left"),
        "{}",
        refusal.err
    );
    assert!(loaded > 0);
    // It serves on, and says the same again for the same.
    let file = place.file("scene.json", &scene(loaded));
    assert_eq!(
        place
            .taut(&["load-scene", &format!("scene{loaded}"), &file])
            .exit,
        67
    );
    // With room again the next change keeps all of them.
    let mut enlarge = Command::new("nsenter");
    enlarge
        .args([
            "-m",
            "-t",
            &daemon.pid().to_string(),
            "mount",
            "-o",
            "remount,size=8m",
        ])
        .arg(&state);
    assert!(enlarge.status().unwrap().success());
    let run = place.taut(&["load-scene", &format!("scene{loaded}"), &file]);
    assert_eq!(run.exit, 0, "{}", run.err);
    let doctor = place.taut(&["doctor"]);
    assert_eq!(doctor.exit, 0, "{}", doctor.out);
    drop(daemon);
}

#[test]
fn full_shared_memory_is_a_coded_refusal() {
    let place = Place::new();
    let script = "mount -t tmpfs -o size=8m none /dev/shm && head -c 7500000 /dev/zero > /dev/shm/full; exec \"$0\" serve";
    let Some(mut command) = in_namespace(&place, script) else {
        return;
    };
    let run = Run::of(command.output().unwrap());
    assert_eq!(run.exit, 67, "{}", run.err);
    assert!(run.err.contains("/dev/shm is full"), "{}", run.err);
}

#[test]
fn few_open_files_leave_some_clients_out_and_harm_nobody() {
    let place = Place::new();
    let config_file = configured(&place, "workers = 1");
    let mut command = Command::new("sh");
    command.args([
        "-c",
        "ulimit -n 120; exec \"$0\" serve --config \"$1\"",
        env!("CARGO_BIN_EXE_taut"),
        &config_file,
    ]);
    command
        .env("TAUT_INSTANCE", place.name())
        .env_remove("TAUT_LOG");
    let mut daemon = Daemon(
        command
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap(),
    );
    until("a daemon is up", || pid(&place).is_some());
    let witness = place.client();
    let arm = Models::of(&witness, "arm_shelf");
    let check = |client: &Client| {
        let mut request = client.request(0, 0);
        request.header = arm.header();
        request.header.mode = Mode::Check.into();
        let mut loan = request.loan()?;
        loan.path_mut().copy_from_slice(&arm.path);
        loan.send()?
            .wait(Duration::from_secs(2))
            .map(|response| response.code())
    };
    let mut clients = Vec::new();
    let mut codes = std::collections::BTreeMap::<String, usize>::new();
    for _ in 0..40 {
        let answered = Client::connect(&place.instance).and_then(|client| {
            let code = check(&client);
            clients.push(client);
            code
        });
        let code = answered.unwrap_or_else(|error| error.code());
        *codes.entry(code.name().to_owned()).or_default() += 1;
    }
    println!("{codes:?}");
    let served = codes.remove("SUCCESS").unwrap_or(0);
    assert!(
        served > 0 && codes == [("OVERLOADED".to_owned(), 40 - served)].into(),
        "{served} and {codes:?}"
    );
    assert!(daemon.is_alive());
    assert_eq!(
        check(&witness).unwrap(),
        Code::Success,
        "whoever was there first is served on"
    );
    clients.clear();
    let client = Client::connect(&place.instance).unwrap();
    assert_eq!(
        check(&client).unwrap(),
        Code::Success,
        "there is room again"
    );
}
