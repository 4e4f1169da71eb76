//! The rules of ARCHITECTURE.md that a reader relies on: who may import whom, and what the core
//! never does.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What each room may import besides itself, `math`, `hash` and `warning`.
fn allowed() -> BTreeMap<&'static str, Vec<&'static str>> {
    let core = [
        "robot",
        "scene",
        "shape",
        "collision",
        "path",
        "validation",
        "optimize",
    ];
    BTreeMap::from([
        ("math", vec![]),
        ("hash", vec!["shape"]),
        ("warning", vec![]),
        ("shape", vec![]),
        ("lanes", vec![]),
        ("robot", vec!["shape", "lanes"]),
        ("scene", vec!["shape"]),
        ("path", vec!["robot"]),
        ("collision", vec!["robot", "scene", "shape"]),
        ("validation", vec!["collision", "path", "robot", "lanes"]),
        ("optimize", vec!["validation", "collision", "path", "robot"]),
        ("store", vec!["collision", "robot", "scene"]),
        (
            "files",
            vec!["path", "robot", "scene", "shape", "optimize", "validation"],
        ),
        ("answer", [&core[..], &["store", "translate"]].concat()),
        (
            "local",
            [&core[..], &["store", "translate", "answer"]].concat(),
        ),
        ("translate", [&core[..], &["store", "files"]].concat()),
        ("view", vec!["files", "robot", "scene", "shape"]),
        (
            "daemon",
            [
                &core[..],
                &["store", "files", "translate", "answer", "view"],
            ]
            .concat(),
        ),
        (
            "cli",
            [
                &core[..],
                &["store", "files", "translate", "local", "daemon", "view"],
            ]
            .concat(),
        ),
        ("main", vec!["cli"]),
        (
            "lib",
            [
                &core[..],
                &["store", "files", "translate", "answer", "local"],
            ]
            .concat(),
        ),
    ])
}

/// Rooms without clock, thread, disk, log or transport.
const CORE: [&str; 12] = [
    "math",
    "lanes",
    "hash",
    "warning",
    "shape",
    "robot",
    "scene",
    "path",
    "collision",
    "validation",
    "optimize",
    "store",
];

/// Where the geometry library's queries are wrapped; everywhere else its types come from `math`.
const NAMES_LIBRARIES: [&str; 2] = ["math.rs", "collision/distance/convex.rs"];

fn sources() -> Vec<(String, PathBuf)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    walk(&root, &mut found);
    found.sort();
    found
        .into_iter()
        .map(|path| {
            (
                path.strip_prefix(&root)
                    .unwrap()
                    .to_string_lossy()
                    .into_owned(),
                path,
            )
        })
        .collect()
}

/// Files that only tests compile.
fn is_test(name: &str) -> bool {
    let file = name.rsplit('/').next().unwrap();
    matches!(
        file,
        "testing.rs"
            | "tests.rs"
            | "soundness.rs"
            | "properties.rs"
            | "contracts.rs"
            | "scenarios.rs"
    )
}

/// The code of a file without comments and without its test module.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let lines = text.lines().map(|line| line.split("//").next().unwrap());
    lines.collect::<Vec<_>>().join("\n")
}

fn room(name: &str) -> &str {
    name.split('/').next().unwrap().trim_end_matches(".rs")
}

/// Rooms that a file names by `crate::room` or, in the binary, `taut::room`.
fn imports(code: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for prefix in ["crate::", "taut::"] {
        for (at, _) in code.match_indices(prefix) {
            if at > 0 && code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$')
            {
                continue;
            }
            let rest = &code[at + prefix.len()..];
            let listed = rest
                .strip_prefix('{')
                .and_then(|rest| rest.split('}').next());
            for item in listed.map_or(vec![rest], |inner| inner.split(',').collect()) {
                let name: String = item
                    .trim()
                    .chars()
                    .take_while(|c| c.is_ascii_lowercase() || *c == '_')
                    .collect();
                rooms.push(name);
            }
        }
    }
    rooms
}

#[test]
fn imports_point_downwards() {
    let allowed = allowed();
    let mut wrong = Vec::new();
    for (name, path) in sources().iter().filter(|(name, _)| !is_test(name)) {
        let own = room(name);
        let may = allowed
            .get(own)
            .unwrap_or_else(|| panic!("src/{name}: no rule for the room {own:?}"));
        for other in imports(&code(path)) {
            let known = allowed.contains_key(other.as_str());
            let is_for_all = ["math", "hash", "warning"].contains(&other.as_str());
            if known && other != own && !is_for_all && !may.contains(&other.as_str()) {
                wrong.push(format!(
                    "src/{name} imports {other}; {own} may import {may:?}"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_core_has_no_clock_thread_disk_log_or_transport() {
    let banned = [
        "std::time",
        "std::thread",
        "std::fs",
        "std::env",
        "std::process",
        "println!",
        "tracing::",
        "taut_ipc",
    ];
    let mut wrong = Vec::new();
    for (name, path) in sources()
        .iter()
        .filter(|(name, _)| !is_test(name) && CORE.contains(&room(name)))
    {
        let code = code(path);
        wrong.extend(
            banned
                .iter()
                .filter(|word| code.contains(**word))
                .map(|word| format!("src/{name}: {word}")),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn libraries_of_algebra_and_geometry_are_named_in_few_places() {
    let mut wrong = Vec::new();
    for (name, path) in sources().iter().filter(|(name, _)| !is_test(name)) {
        let code = code(path);
        let named = ["parry3d_f64", "nalgebra::", "glam"]
            .iter()
            .any(|library| code.contains(library));
        if named && !NAMES_LIBRARIES.contains(&name.as_str()) {
            wrong.push(format!(
                "src/{name} names an algebra or geometry library; take its types from math"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn only_translate_sees_wire_and_core_together() {
    let mut wrong = Vec::new();
    for (name, path) in sources()
        .iter()
        .filter(|(name, _)| name.starts_with("daemon/") && !is_test(name))
    {
        let code = code(path);
        let wire = ["ResponseHeader", "RequestView", "ResponseBody"]
            .iter()
            .any(|name| code.contains(name));
        let core = code.contains("Outcome");
        if wire && core {
            wrong.push(format!(
                "src/{name} sees both the wire's types and the core's"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn files_stay_readable() {
    let long = sources()
        .into_iter()
        .filter(|(name, _)| !is_test(name))
        .filter_map(|(name, path)| {
            let lines = fs::read_to_string(path).unwrap().lines().count();
            (lines > 530 && name != "robot/model.rs").then(|| format!("src/{name}: {lines} lines"))
        });
    let long: Vec<_> = long.collect();
    assert!(long.is_empty(), "split these: {}", long.join(", "));
}
