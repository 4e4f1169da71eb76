//! The rules of ARCHITECTURE.md that a reader relies on: who may import whom, and what the core
//! never does.

mod imports;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use imports::Crate;

/// What each room may import besides itself, `math`, `hash` and `warning`.
fn allowed() -> BTreeMap<&'static str, Vec<&'static str>> {
    let core = [
        "robot",
        "scene",
        "constraint",
        "shape",
        "solid",
        "collision",
        "path",
        "validation",
        "optimize",
    ];
    BTreeMap::from([
        ("math", vec![]),
        ("hash", vec![]),
        ("warning", vec![]),
        ("shape", vec![]),
        ("lanes", vec![]),
        ("robot", vec!["shape", "lanes"]),
        ("scene", vec!["shape"]),
        ("constraint", vec!["collision", "robot", "scene", "shape"]),
        ("path", vec!["robot"]),
        ("solid", vec!["shape"]),
        ("collision", vec!["robot", "scene", "shape", "solid"]),
        (
            "validation",
            vec!["constraint", "solid", "collision", "path", "robot", "lanes"],
        ),
        (
            "optimize",
            vec![
                "validation",
                "constraint",
                "solid",
                "collision",
                "path",
                "robot",
            ],
        ),
        ("timing", vec!["validation", "path", "robot"]),
        ("store", vec!["collision", "robot", "scene"]),
        (
            "files",
            vec![
                "path",
                "robot",
                "scene",
                "shape",
                "constraint",
                "optimize",
                "validation",
                "timing",
            ],
        ),
        (
            "answer",
            [&core[..], &["store", "translate", "timing"]].concat(),
        ),
        (
            "local",
            [&core[..], &["store", "translate", "answer"]].concat(),
        ),
        (
            "translate",
            [&core[..], &["store", "files", "timing"]].concat(),
        ),
        (
            "view",
            vec![
                "constraint",
                "files",
                "robot",
                "scene",
                "shape",
                "validation",
            ],
        ),
        (
            "daemon",
            [
                &core[..],
                &["store", "files", "translate", "answer", "view", "timing"],
            ]
            .concat(),
        ),
        (
            "cli",
            [
                &core[..],
                &[
                    "timing",
                    "store",
                    "files",
                    "translate",
                    "local",
                    "daemon",
                    "view",
                ],
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
const CORE: [&str; 15] = [
    "math",
    "lanes",
    "hash",
    "warning",
    "shape",
    "solid",
    "robot",
    "scene",
    "constraint",
    "path",
    "collision",
    "validation",
    "optimize",
    "timing",
    "store",
];

/// Where the geometry library's queries are wrapped; everywhere else its types come from `math`.
const NAMES_LIBRARIES: [&str; 2] = ["math.rs", "solid/distance/convex.rs"];

fn sources() -> Vec<(String, PathBuf)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path
                .extension()
                .is_some_and(|extension| extension == "rs")
            {
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
    let text = text
        .split("#[cfg(test)]\nmod tests {")
        .next()
        .unwrap();
    let lines = text
        .lines()
        .map(|line| line.split("//").next().unwrap());
    lines.collect::<Vec<_>>().join("\n")
}

fn room(name: &str) -> &str {
    name.split('/')
        .next()
        .unwrap()
        .trim_end_matches(".rs")
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
    for (name, path) in sources()
        .iter()
        .filter(|(name, _)| !is_test(name))
    {
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
    for (name, path) in sources()
        .iter()
        .filter(|(name, _)| !is_test(name))
    {
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
            let lines = fs::read_to_string(path)
                .unwrap()
                .lines()
                .count();
            (lines > 600).then(|| format!("src/{name}: {lines} lines"))
        });
    let long: Vec<_> = long.collect();
    assert!(long.is_empty(), "split these: {}", long.join(", "));
}

/// Sources whose files are looked at for circles.
const SOURCES: [&str; 6] = [
    "src",
    "ipc/src",
    "ipc/python/src",
    "ipc/c/src",
    "ipc/zenoh/src",
    "benches/src",
];

/// Files that import each other, by their names from the repository's root.
fn circles() -> Vec<Vec<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let name = |file: &PathBuf| {
        file.strip_prefix(root)
            .unwrap()
            .display()
            .to_string()
    };
    let folders = SOURCES.map(|folder| root.join(folder));
    let there = folders.iter().filter(|folder| folder.is_dir());
    let circles = there.flat_map(|folder| Crate::read(folder).circles());
    circles
        .map(|files| files.iter().map(name).collect())
        .collect()
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let found: Vec<String> = circles()
        .iter()
        .map(|files| files.join(", "))
        .collect();
    assert!(
        found.is_empty(),
        "these files import each other; give what they share a file of its own:\n{}",
        found.join("\n")
    );
}

/// Names in `code` that look like paths of the repository.
fn paths_in(code: &str) -> impl Iterator<Item = &str> {
    let is_path = |word: &&str| {
        let is_file = [".rs", ".md", ".toml", ".js", ".py", ".json"]
            .iter()
            .any(|end| word.ends_with(end));
        (word.contains('/') || is_file) && !word.contains([' ', '<', '*', '{', ':', '='])
    };
    code.split('`')
        .skip(1)
        .step_by(2)
        .filter(is_path)
}

/// Whether a path of ARCHITECTURE.md is there, from the root or from a room; a bare name is that of
/// any source.
fn exists(path: &str, sources: &[(String, PathBuf)]) -> bool {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = path.trim_end_matches('/');
    if !path.contains('/') {
        let is_named = |name: &str| name.rsplit('/').next() == Some(path);
        return root.join(path).exists() || sources.iter().any(|(name, _)| is_named(name));
    }
    ["", "src"].iter().any(|start| {
        let whole = root.join(start).join(path);
        whole.exists() || whole.with_extension("rs").exists()
    })
}

#[test]
fn what_the_architecture_page_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let sources = sources();
    let mut wrong: Vec<String> = paths_in(&page)
        .filter(|path| !exists(path, &sources))
        .map(|path| format!("`{path}` is not there"))
        .collect();
    let rooms = page
        .split("```")
        .nth(1)
        .expect("the list of rooms");
    // A room stands at the start of a line, or two or four columns in; its words stand further in.
    let mut parent = "";
    for line in rooms.lines() {
        let indent = line.len() - line.trim_start().len();
        let word = line
            .split_whitespace()
            .next()
            .unwrap_or_default();
        if indent > 2 || !(word.ends_with('/') || word.ends_with(".rs")) {
            continue;
        }
        let path = if indent == 0 {
            word.to_owned()
        } else {
            format!("{parent}{word}")
        };
        if indent == 0 {
            parent = word;
        }
        if !root.join(&path).exists() {
            wrong.push(format!("the room {path} is not there"));
        }
    }
    assert!(wrong.is_empty(), "ARCHITECTURE.md:\n{}", wrong.join("\n"));
}
