//! The page of `taut view` and of the daemon, in a real browser: what it draws is what the answer
//! says.
#![cfg(feature = "daemon")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use common::waiter::{ROBOT, UPRIGHT, tilt};
use common::{Models, Place, config, endless, until};
use serde_json::Value;
use taut::files::{Packages, Reader, ResultFile};
use taut::math::Pose;
use taut::robot::{Drive, Kinematics, RobotModel};
use taut_ipc::wire::RequestBody;

/// The page's folder with its packages, below the target folder; `None` where Node or the packages
/// are out of reach.
fn page_folder() -> Option<&'static Path> {
    static FOLDER: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    available(
        FOLDER
            .get_or_init(installed)
            .as_ref()
            .map(PathBuf::as_path),
    )
}

fn chromium() -> Option<&'static str> {
    let names = [
        "/usr/bin/chromium",
        "/usr/bin/chromium-browser",
        "/usr/bin/google-chrome",
    ];
    let found = names
        .into_iter()
        .find(|name| Path::new(name).is_file());
    available(found.ok_or(&format!(
        "no Chromium at {}; install Debian's package chromium",
        names.join(", ")
    )))
}

fn available<T>(found: Result<T, &String>) -> Option<T> {
    match found {
        Ok(found) => Some(found),
        Err(reason) if std::env::var_os("TAUT_REQUIRE_ALL").is_some_and(|value| value == "1") => {
            panic!("{reason}")
        }
        Err(reason) => {
            println!("skipped: {reason}");
            None
        }
    }
}

/// Copies the sources, so that nothing is written among them, and installs what their lock file
/// names.
fn installed() -> Result<PathBuf, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page");
    let from = root.join("src/view/page");
    let to = copy.join("src/view/page");
    for folder in ["", "src", "test"] {
        fs::create_dir_all(to.join(folder)).unwrap();
        for entry in fs::read_dir(from.join(folder))
            .unwrap()
            .map(Result::unwrap)
        {
            if entry.file_type().unwrap().is_file() {
                fs::copy(entry.path(), to.join(folder).join(entry.file_name())).unwrap();
            }
        }
    }
    fs::copy(root.join("LICENSE-APACHE"), copy.join("LICENSE-APACHE")).unwrap();
    let mut npm = Command::new("npm");
    npm.args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"])
        .current_dir(&to);
    let output = npm
        .output()
        .map_err(|error| format!("no npm: {error}; install Node.js"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    output
        .status
        .success()
        .then_some(to)
        .ok_or_else(|| format!("npm ci failed: {said}"))
}

#[test]
fn the_committed_script_is_what_its_sources_make() {
    let Some(folder) = page_folder() else { return };
    let made = tempfile::tempdir().unwrap();
    let status = Command::new("node")
        .arg("build.mjs")
        .arg(made.path())
        .current_dir(folder)
        .status()
        .unwrap();
    assert!(status.success());
    for name in ["page.js", "THIRD-PARTY.txt"] {
        let committed = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("src/view/page")
            .join(name);
        let same = fs::read(committed).unwrap() == fs::read(made.path().join(name)).unwrap();
        assert!(
            same,
            "{name} is not what build.mjs makes; run `npm ci && npm run build` in src/view/page"
        );
    }
}

/// What a browser finds on a page.
fn look(url: &str, folder: &Path, browser: &str, scheme: &str) -> Value {
    let shot = tempfile::tempdir().unwrap();
    let mut node = Command::new("node");
    node.args(["test/look.mjs", browser, url])
        .arg(shot.path().join("page.png"))
        .arg(scheme)
        .current_dir(folder);
    let output = node.output().unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        found["said"],
        serde_json::json!([]),
        "errors on the console"
    );
    assert_eq!(
        found["unlabelled"],
        serde_json::json!([]),
        "controls without a name"
    );
    found
}

fn taut(arguments: &[&str]) -> common::Run {
    common::Run::of(
        Command::new(env!("CARGO_BIN_EXE_taut"))
            .args(arguments)
            .output()
            .unwrap(),
    )
}

/// Answers a problem in this process and writes the page of it.
fn page_of(place: &Place, arguments: &[&str]) -> (ResultFile, String) {
    let result = place.folder.path().join("result.json");
    let page = place.folder.path().join("view.html");
    let json = taut(&[arguments, &["--local", "--format", "json"]].concat());
    fs::write(&result, &json.out).unwrap();
    let run = taut(&[
        "view",
        result.to_str().unwrap(),
        "-o",
        page.to_str().unwrap(),
    ]);
    assert_eq!((run.exit, run.err.as_str()), (0, ""), "{}", json.err);
    (
        ResultFile::read(&result).unwrap(),
        format!("file://{}", page.display()),
    )
}

fn robot_of(result: &ResultFile) -> RobotModel {
    let files = result.subject.robot.files.as_ref().unwrap();
    RobotModel::new(
        Reader::new(Packages::default())
            .robot_of(files)
            .unwrap(),
    )
    .unwrap()
}

/// A matrix of the page, column by column, as a pose.
fn differs(matrix: &Value, pose: &Pose) -> f64 {
    let number = |i: usize| matrix[i].as_f64().unwrap();
    let axes = [
        taut::math::Vec3::X,
        taut::math::Vec3::Y,
        taut::math::Vec3::Z,
    ];
    let columns = axes
        .map(|axis| (pose.rotation * axis).to_array())
        .into_iter()
        .chain([pose.translation.to_array()]);
    let off = columns
        .enumerate()
        .flat_map(|(c, column)| [0, 1, 2].map(|r| (number(4 * c + r) - column[r]).abs()));
    off.fold(0.0, f64::max)
}

/// The robot on the page stands where the robot's own kinematics say, at every waypoint of the
/// answer.
fn stands_right(found: &Value, result: &ResultFile) {
    let robot = robot_of(result);
    let held: Vec<f64> = robot
        .held()
        .iter()
        .map(|held| held.default)
        .collect();
    let mut kinematics = Kinematics::default();
    let at = found["at"].as_array().unwrap();
    assert_eq!(at.len(), result.path.len());
    for (shown, row) in at.iter().zip(&result.path) {
        kinematics.update(&robot, row, &held);
        for (link, pose) in robot.links().iter().zip(kinematics.poses()) {
            let off = differs(&shown["links"][&link.name], pose);
            assert!(off < 1e-6, "{} is {off} m or so off", link.name);
        }
        for joint in robot.joints() {
            let Drive::Variable { q, .. } = joint.drive else {
                continue;
            };
            for (k, value) in shown["joints"][&joint.name]
                .as_array()
                .unwrap()
                .iter()
                .enumerate()
            {
                assert!(
                    (value.as_f64().unwrap() - row[q + k]).abs() < 1e-9,
                    "{} column {k}",
                    joint.name
                );
            }
        }
    }
    for trace in found["traces"].as_array().unwrap() {
        let rows = if trace["kind"] == "before" {
            &result.path_before
        } else {
            &result.path
        };
        let link = robot
            .link_index(trace["tip"].as_str().unwrap())
            .unwrap();
        let waypoints = trace["waypoints"].as_array().unwrap();
        assert_eq!(waypoints.len(), rows.len(), "{trace}");
        for (waypoint, row) in waypoints.iter().zip(rows) {
            kinematics.update(&robot, row, &held);
            let point = kinematics.poses()[link].translation.to_array();
            assert!(
                (0..3).all(|k| (waypoint[k].as_f64().unwrap() - point[k]).abs() < 1e-6),
                "{trace}"
            );
        }
    }
    let lengths = [0, 1].map(|i| found["length"][i].as_f64().unwrap());
    for (page, own) in lengths
        .into_iter()
        .zip([result.length_before, result.length_after])
    {
        assert!(
            (page - own).abs() < 1e-9 * own.max(1.0),
            "length {page} on the page, {own} in the answer"
        );
    }
}

fn share(found: &Value, color: &str) -> f64 {
    found["colors"][color].as_f64().unwrap() / found["colors"]["all"].as_f64().unwrap()
}

#[test]
fn an_answer_is_drawn_as_it_is() {
    let (Some(folder), Some(browser)) = (page_folder(), chromium()) else {
        return;
    };
    // An arm, a planar base with two arms, and a floating body.
    for (name, scheme) in [
        ("arm_shelf", "light"),
        ("exchange_arms", "dark"),
        ("ell_window", "light"),
    ] {
        let place = Place::new();
        let (result, url) = page_of(
            &place,
            &["shorten", &config(&format!("problems/{name}.json"))],
        );
        let found = look(&url, folder, browser, scheme);
        stands_right(&found, &result);
        let asked = found["asked"].as_array().unwrap();
        assert!(
            asked
                .iter()
                .all(|url| !url.as_str().unwrap().starts_with("http")),
            "{name} asks for {asked:?}"
        );
        let traces = found["traces"].as_array().unwrap();
        assert!(
            ["before", "after"].iter().all(|kind| traces
                .iter()
                .any(|trace| trace["kind"] == *kind)),
            "{name}"
        );
        let drawn = found["contacts"].as_array().map(Vec::len);
        assert!(
            drawn >= result.holds.as_ref().map(Vec::len),
            "{name}: {drawn:?} contacts"
        );
        assert!(
            found["verdict"]
                .as_str()
                .unwrap()
                .starts_with("Proved"),
            "{}",
            found["verdict"]
        );
        assert_eq!(
            (found["moved"].as_f64(), found["plays"].as_bool()),
            (Some(1.0), Some(true)),
            "{name}"
        );
        assert!(found["plots"].as_u64() >= Some(3), "{name}");
        let has_objects = found["objects"]
            .as_array()
            .is_some_and(|objects| !objects.is_empty());
        let object = if has_objects { 0.002 } else { 0.0 };
        for (color, least) in [
            ("green", 0.001),
            ("grey", 0.002),
            ("tan", object),
            ("different", 0.05),
        ] {
            assert!(
                share(&found, color) >= least,
                "{name}: {color} is {} of the picture",
                share(&found, color)
            );
        }
    }
}

#[test]
fn a_refusal_shows_where_and_what_collides() {
    let (Some(folder), Some(browser)) = (page_folder(), chromium()) else {
        return;
    };
    let place = Place::new();
    let problem = common::problem("arm_shelf");
    let path = problem["path"].as_array().unwrap();
    let line = serde_json::json!({ "variables": problem["variables"], "path": [path.first(), path.last()] });
    let line = place.file("line.json", &line.to_string());
    let shelf = config("problems/arm_shelf.json");
    let (result, url) = page_of(&place, &["check", &line, "--problem", &shelf]);
    let refusal = result.refusal.as_ref().unwrap();
    let found = look(&url, folder, browser, "light");
    stands_right(&found, &result);
    let marked = &found["marked"];
    assert!(
        (marked["position"].as_f64().unwrap() - refusal.t).abs() < 1e-3,
        "a straight line's place is its ratio"
    );
    assert_eq!(
        marked["highlighted"],
        serde_json::json!(refusal.requirement.names)
    );
    assert!(
        marked["label"]
            .as_str()
            .unwrap()
            .starts_with(&refusal.requirement.to_string()),
        "{marked}"
    );
    assert!(
        found["verdict"]
            .as_str()
            .unwrap()
            .starts_with("COLLISION"),
        "{}",
        found["verdict"]
    );
    assert!(
        share(&found, "red") > 0.002,
        "red is {} of the picture",
        share(&found, "red")
    );
}

/// The waiter with a hand beside its elbow, so that it goes somewhere.
fn waiter(place: &Place) -> String {
    let joint = "<child link=\"hand\"/>";
    let beside = format!("{joint}<origin xyz=\"0.3 0 0.2\"/>");
    place.file("waiter.urdf", &ROBOT.replace(joint, &beside))
}

/// Whether the page has a group where the robot has a frame.
fn is_at(shown: &Value, pose: &Pose) -> bool {
    let number = |i: usize| shown[i].as_f64().unwrap();
    let off = taut::math::Vec3::new(number(0), number(1), number(2)) - pose.translation;
    let turned = taut::math::Quat::from_xyzw(number(3), number(4), number(5), number(6));
    off.length() < 1e-6 && turned.dot(pose.rotation).abs() > 1.0 - 1e-9
}

/// The data of a page that was written.
fn data_of(url: &str) -> Value {
    let text = fs::read_to_string(url.trim_start_matches("file://")).unwrap();
    let (_, rest) = text.split_once("id=\"data\">").unwrap();
    let (data, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str(data).unwrap()
}

#[test]
fn what_a_path_keeps_is_drawn_where_it_is_and_read_along_the_path() {
    let (Some(folder), Some(browser)) = (page_folder(), chromium()) else {
        return;
    };
    let place = Place::new();
    let urdf = waiter(&place);
    let asked = serde_json::json!(["keep hand in cylinder 0.6,2 at 0,0,0.5", "keep hand in box 2,2,2 at 0,0,0 of elbow",
        "upright hand:z=0.1", { "joint_constraints": [{ "joint_name": "nod", "position": 0, "tolerance_above": 1,
            "tolerance_below": 1 }] }]);
    let text = serde_json::json!({ "variables": ["lean", "turn", "nod"], "path": UPRIGHT, "path_constraints": asked });
    let file = place.file("path.json", &text.to_string());
    let (result, url) = page_of(
        &place,
        &["shorten", &file, "--robot", &urdf, "--budget", "20000"],
    );
    let found = look(&url, folder, browser, "light");
    stands_right(&found, &result);
    // Where the page stands: at the last waypoint.
    let robot = robot_of(&result);
    let mut kinematics = Kinematics::default();
    kinematics.update(&robot, result.path.last().unwrap(), &[]);
    let link = |name: &str| kinematics.poses()[robot.link_index(name).unwrap()];
    let [hand, elbow] = ["hand", "elbow"].map(link);
    let at_hand = Pose::from_translation(hand.translation);
    let kept = found["kept"].as_array().unwrap();
    let expected = [(Pose::identity(), 1), (elbow, 1), (at_hand, 0)];
    assert_eq!(kept.len(), expected.len(), "a joint is nowhere");
    for (shown, (region, solids)) in kept.iter().zip(expected) {
        assert!(is_at(&shown["region"], &region), "{shown}");
        assert!(is_at(&shown["watched"], &hand), "{shown}");
        assert_eq!(shown["solids"], solids);
    }
    assert_eq!(kept[2]["trails"].as_u64(), Some(result.path.len() as u64));
    assert!(found["plots"].as_u64() >= Some(4 + 2));
    assert!(
        share(&found, "violet") > 0.002,
        "{}",
        share(&found, "violet")
    );
    let data = &data_of(&url)["kept"];
    let tilts = &data["constraints"][3];
    assert_eq!(
        (&tilts["name"], &tilts["unit"]),
        (&"hand".into(), &"rad".into())
    );
    assert_eq!(tilts["allowed"], serde_json::json!([0.1]));
    let places = data["after"].as_array().unwrap();
    assert!(places.len() > 100);
    for (at, read) in places
        .iter()
        .zip(tilts["after"].as_array().unwrap())
    {
        let segment = at[0].as_u64().unwrap() as usize;
        let t = at[1].as_f64().unwrap();
        let column = |row: usize, q: usize| result.path[row][q];
        let q =
            std::array::from_fn(|q| column(segment, q) * (1.0 - t) + column(segment + 1, q) * t);
        let read = read.as_f64().unwrap();
        assert!(
            (read - tilt(q)).abs() < 1e-7 && read <= 0.1,
            "{read}, {}",
            tilt(q)
        );
    }
}

#[test]
fn a_refused_constraint_is_shown_as_what_it_is() {
    let (Some(folder), Some(browser)) = (page_folder(), chromium()) else {
        return;
    };
    let place = Place::new();
    let urdf = waiter(&place);
    let text = serde_json::json!({ "variables": ["lean", "turn", "nod"], "path": [UPRIGHT[0], UPRIGHT[3]] });
    let file = place.file("path.json", &text.to_string());
    let asked = [
        "check",
        &file,
        "--robot",
        &urdf,
        "--keep-upright",
        "hand:z=0.1",
    ];
    let (result, url) = page_of(&place, &asked);
    let refusal = result.refusal.as_ref().unwrap();
    let found = look(&url, folder, browser, "light");
    stands_right(&found, &result);
    let marked = &found["marked"];
    let label = marked["label"].as_str().unwrap();
    assert_eq!(
        label,
        format!("upright: hand outside by {:.5} rad", -refusal.amount)
    );
    let verdict = found["verdict"].as_str().unwrap();
    assert!(
        verdict.starts_with("OUTSIDE") && verdict.contains("outside by"),
        "{verdict}"
    );
    assert_eq!(marked["inks"][0], "d2232a", "the colour of what is bad");
    assert!(share(&found, "red") > 0.0005, "{}", share(&found, "red"));
}

#[test]
fn the_daemons_page_shows_what_runs_and_each_answer() {
    let (Some(folder), Some(browser)) = (page_folder(), chromium()) else {
        return;
    };
    let place = Place::new();
    let _daemon = place.serve("workers = 2\nhttp = \"127.0.0.1:0\"");
    let said = place.said("page at ");
    let url = said
        .trim_start_matches("page at ")
        .trim()
        .to_owned();
    let client = place.client();
    let corner = Models::of(&client, "corner");
    let running = corner
        .request(&client, RequestBody::default(), endless)
        .send()
        .unwrap();
    let shelf = config("problems/arm_shelf.json");
    let result = place.folder.path().join("result.json");
    let ball = ["--keep", "hand in ball 2 at 0,0,0"];
    let run = place.taut(
        &[
            &["shorten", &shelf, "--out", result.to_str().unwrap()],
            &ball[..],
        ]
        .concat(),
    );
    assert_eq!(run.exit, 0, "{}", run.err);
    let found = look(&url, folder, browser, "light");
    stands_right(&found, &ResultFile::read(&result).unwrap());
    assert_eq!(found["kept"][0]["name"], "hand");
    let live = found["live"].as_str().unwrap().to_lowercase();
    assert!(
        live.contains("running (1)")
            && live.contains("corner in corner")
            && live.contains("arm_shelf"),
        "{live}"
    );
    assert!(
        live.contains(&format!("process {}", std::process::id())),
        "{live}"
    );
    let asked = found["asked"].as_array().unwrap();
    assert!(
        asked
            .iter()
            .all(|asked| asked.as_str().unwrap().starts_with(&url)),
        "{asked:?}"
    );
    drop(running);
    // It goes from the page when its client has dropped it.
    until("the request is gone from the page", || {
        get(&url, "state", None).contains("\"running\":[]")
    });
}

#[test]
fn the_daemons_page_answers_to_its_own_names_only() {
    let place = Place::new();
    let _daemon = place.serve("http = \"127.0.0.1:0\"");
    let url = place
        .said("page at ")
        .trim_start_matches("page at ")
        .trim()
        .to_owned();
    assert!(get(&url, "", None).contains("data-kind=\"live\""));
    let state: Value = serde_json::from_str(
        get(&url, "state", None)
            .split("\r\n\r\n")
            .nth(1)
            .unwrap(),
    )
    .unwrap();
    assert_eq!(
        (&state["running"], &state["answers"]),
        (&serde_json::json!([]), &serde_json::json!([]))
    );
    assert!(get(&url, "state", Some("evil.example")).starts_with("HTTP/1.1 403"));
    assert!(get(&url, "answer/7", None).starts_with("HTTP/1.1 404"));
    let run = taut(&["serve", "--no-state", "--http", "0.0.0.0:8642"]);
    assert!(
        run.exit == 64 && run.err.contains("0.0.0.0:8642") && run.err.contains("127.0.0.1:8642"),
        "{}",
        run.err
    );
}

/// What an address answers, with its head, asked by this `Host` or its own.
fn get(url: &str, path: &str, host: Option<&str>) -> String {
    use std::io::{Read, Write};
    let address = url
        .trim_start_matches("http://")
        .trim_end_matches('/');
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    let host = host.unwrap_or(address);
    write!(
        stream,
        "GET /{path} HTTP/1.0\r\nHost: {host}\r\nConnection: close\r\n\r\n"
    )
    .unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    text.replacen("HTTP/1.0", "HTTP/1.1", 1)
}
