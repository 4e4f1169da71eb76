//! `taut demo` from an empty folder, and the example planner against a daemon.
#![cfg(feature = "daemon")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use taut_ipc::control::ControlRequest;
use taut_ipc::{Client, DaemonState, INSTANCE_VARIABLE, Instance, daemon_state};

const PATIENCE: Duration = Duration::from_secs(60);

/// The demo, at home in a folder: it runs there and has its temporary files there.
fn demo(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taut"));
    let work = folder.join("work");
    let tmp = folder.join("tmp");
    fs::create_dir_all(&work)
        .and_then(|()| fs::create_dir_all(&tmp))
        .unwrap();
    command
        .arg("demo")
        .current_dir(work)
        .env("TMPDIR", tmp)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Files in the folder for temporary files, shared memory of the instance, and processes that know
/// of it.
fn left_behind(folder: &Path, demo_id: u32) -> Vec<String> {
    let tmp = folder.join("tmp");
    let root = tmp
        .join(format!("taut-demo-{demo_id}"))
        .join("run");
    let prefix = Instance::new("demo", &root)
        .unwrap()
        .prefix()
        .to_owned();
    let names = |folder: &Path| -> Vec<String> {
        let entries = fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten();
        entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect()
    };
    let shared = names(Path::new("/dev/shm"))
        .into_iter()
        .filter(|name| name.starts_with(&prefix));
    let knows = |process: &String| {
        let environment =
            fs::read(Path::new("/proc").join(process).join("environ")).unwrap_or_default();
        String::from_utf8_lossy(&environment).contains(root.to_str().unwrap())
    };
    let processes = names(Path::new("/proc"))
        .into_iter()
        .filter(knows);
    names(&tmp)
        .into_iter()
        .chain(shared)
        .chain(processes)
        .collect()
}

fn finish(child: Child) -> Output {
    child.wait_with_output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn classes<'a>(node: roxmltree::Node<'a, 'a>, class: &str) -> usize {
    node.descendants()
        .filter(|node| node.attribute("class") == Some(class))
        .count()
}

#[test]
fn four_planners_have_their_paths_shortened_and_proved_and_nothing_stays() {
    let folder = tempfile::tempdir().unwrap();
    let child = demo(folder.path())
        .args(["--format", "json"])
        .spawn()
        .unwrap();
    let id = child.id();
    let output = finish(child);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(left_behind(folder.path(), id), Vec::<String>::new());

    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = report["planners"].as_array().unwrap();
    assert_eq!((rows.len(), report["proved"].as_bool()), (4, Some(true)));
    for row in rows {
        let length = |name: &str| row[name].as_f64().unwrap();
        assert_eq!(
            (row["proved"].as_bool(), row["code"].as_str()),
            (Some(true), Some("SUCCESS"))
        );
        assert!(length("length_after") <= length("length_before"), "{row}");
        assert!(
            row["clearance_m"]
                .as_f64()
                .is_none_or(|metres| metres >= 1e-3),
            "{row}"
        );
    }
    let robots: std::collections::BTreeSet<_> = rows
        .iter()
        .map(|row| row["robot"].as_str().unwrap())
        .collect();
    assert!(robots.len() >= 2, "{robots:?}");

    let picture = fs::read_to_string(folder.path().join("work/taut-demo.svg")).unwrap();
    let document = roxmltree::Document::parse(&picture).unwrap();
    for planner in 1..=4 {
        let id = format!("planner-{planner}");
        let card = document
            .descendants()
            .find(|node| node.attribute("id") == Some(&id))
            .unwrap();
        for class in ["before", "after", "start", "goal", "obstacle", "proved"] {
            assert!(classes(card, class) > 0, "{id} has no {class}");
        }
    }
}

#[test]
fn the_table_has_a_row_for_each_planner_and_plain_lines_tell_what_happens() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = demo(folder.path());
    let output = finish(
        command
            .args(["--planners", "2", "--seed", "7", "--svg", "picture.svg"])
            .spawn()
            .unwrap(),
    );
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let lines: Vec<&str> = text(&output.stdout).lines().collect();
    assert!(
        lines[0].starts_with("planner")
            && lines[0].contains("before")
            && lines[0].contains("clearance")
    );
    assert!(
        lines[1].starts_with("1 arm_window") && lines[2].starts_with("2 rooms"),
        "{lines:?}"
    );
    assert!(
        lines[3].starts_with("2 of 2 proved") && lines[3].ends_with("picture: picture.svg"),
        "{lines:?}"
    );
    assert!(
        text(&output.stderr).contains("1  arm_window: planned "),
        "{}",
        text(&output.stderr)
    );
    assert!(folder.path().join("work/picture.svg").is_file());
}

#[test]
fn an_interrupted_demo_stops_what_it_started() {
    let folder = tempfile::tempdir().unwrap();
    // Planners of the L search for long enough to be met while they search.
    let child = demo(folder.path())
        .args(["--planners", "24", "--svg", "none.svg"])
        .spawn()
        .unwrap();
    let id = child.id();
    let instance = Instance::new(
        "demo",
        folder
            .path()
            .join("tmp")
            .join(format!("taut-demo-{id}"))
            .join("run"),
    );
    wait_until_up(&instance.unwrap());
    let killed = Command::new("kill")
        .args(["-INT", &id.to_string()])
        .status()
        .unwrap();
    assert!(killed.success());
    let output = finish(child);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert!(
        text(&output.stderr).contains("interrupted"),
        "{}",
        text(&output.stderr)
    );
    assert_eq!(left_behind(folder.path(), id), Vec::<String>::new());
    assert!(!folder.path().join("work/none.svg").exists());
}

#[test]
fn a_path_that_cannot_be_proved_in_time_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let child = demo(folder.path())
        .args(["--planners", "1", "--deadline", "0us"])
        .spawn()
        .unwrap();
    let id = child.id();
    let output = finish(child);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stdout));
    assert!(
        text(&output.stdout).contains("0 of 1 proved"),
        "{}",
        text(&output.stdout)
    );
    assert_eq!(left_behind(folder.path(), id), Vec::<String>::new());
}

fn wait_until_up(instance: &Instance) {
    let end = Instant::now() + PATIENCE;
    while !matches!(daemon_state(instance), Ok(DaemonState::Running { .. })) {
        assert!(Instant::now() < end, "the daemon does not come up");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A daemon that ends with the test, however that ends.
struct Daemon(Child);

impl Drop for Daemon {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_example_planner_gets_a_proved_answer() {
    // Cargo builds examples beside the programs before it runs tests, though not for `--test demo`
    // alone.
    let bin = PathBuf::from(env!("CARGO_BIN_EXE_taut"));
    let example = bin.with_file_name("examples").join("planner");
    if !example.is_file() {
        eprintln!(
            "skipped: {} is not built; run `cargo build --example planner`",
            example.display()
        );
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let name = format!("planner:{}", folder.path().join("run").display());
    let instance = Instance::new("planner", folder.path().join("run")).unwrap();
    let serve = Command::new(bin)
        .arg("serve")
        .env(INSTANCE_VARIABLE, &name)
        .stdout(Stdio::null())
        .spawn();
    let mut daemon = Daemon(serve.unwrap());
    wait_until_up(&instance);

    let problem = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/config/problems/arm_window.json"
    );
    let planners = Command::new(example)
        .args([problem, "--planners", "4"])
        .env(INSTANCE_VARIABLE, &name)
        .output();
    let planners = planners.unwrap();
    assert!(planners.status.success(), "{}", text(&planners.stderr));
    assert_eq!(
        text(&planners.stdout)
            .matches("proved, clearance at least")
            .count(),
        4
    );

    Client::connect(&instance)
        .unwrap()
        .control(&ControlRequest::Shutdown, PATIENCE)
        .unwrap();
    assert!(daemon.0.wait().unwrap().success());
    // The client may have been there longer than the daemon.
    taut_ipc::server::tidy(&instance);
}
