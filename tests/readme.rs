//! Every command of the README's is run, in the order in which a reader would, by the binary of
//! this build.
#![cfg(feature = "daemon")]

mod common;

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use common::*;

/// A fenced block of a Markdown text.
struct Block {
    language: String,
    text: String,
    /// What stands in a comment right before it.
    note: String,
}

fn blocks(markdown: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut note = String::new();
    let mut lines = markdown.lines();
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let text = lines
                .by_ref()
                .take_while(|line| *line != "```")
                .collect::<Vec<_>>()
                .join("\n");
            blocks.push(Block {
                language: language.to_owned(),
                text,
                note: std::mem::take(&mut note),
            });
        } else if !line.is_empty() {
            note = line
                .strip_prefix("<!-- ")
                .and_then(|line| line.strip_suffix(" -->"))
                .unwrap_or("")
                .to_owned();
        }
    }
    blocks
}

/// What `tests/` and `.ci/run` run themselves, or what is not ours to try: a comment before the
/// block says so.
const ELSEWHERE: [&str; 4] = ["build", "install", "promises", "output"];

#[test]
fn the_commands_run_as_they_stand() {
    let place = Place::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = place.folder.path().join("clone");
    let bin = place.folder.path().join("bin");
    for new in [&folder, &bin] {
        std::fs::create_dir(new).unwrap();
    }
    for name in ["config", "examples", "ipc"] {
        symlink(root.join(name), folder.join(name)).unwrap();
    }
    symlink(env!("CARGO_BIN_EXE_taut"), bin.join("taut")).unwrap();
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let mut script =
        "set -euo pipefail\ntrap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n".to_owned();
    let mut commands = 0;
    for Block {
        language,
        text,
        note,
    } in blocks(&readme)
    {
        match (language.as_str(), note.as_str()) {
            ("sh", "") => {
                for line in text.lines() {
                    commands += usize::from(line.starts_with("taut "));
                    script += &format!("echo '+ {}' >&2\n{line}\n", line.replace('\'', ""));
                    if line.starts_with("taut serve &") {
                        script += "for _ in $(seq 300); do taut list >/dev/null 2>&1 && break; sleep 0.1; done\n";
                    }
                }
            }
            ("sh", note) => assert!(
                ELSEWHERE.contains(&note),
                "a block of commands that is not run: {note:?}"
            ),
            ("json", name) if !name.is_empty() => std::fs::write(folder.join(name), text).unwrap(),
            _ => {}
        }
    }
    assert!(
        commands > 15,
        "{commands} commands; has the README another form?"
    );
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let mut bash = Command::new("bash");
    bash.args(["-c", &script])
        .current_dir(&folder)
        .env("PATH", path)
        .env("TAUT_INSTANCE", place.name());
    bash.env("HOME", place.folder.path())
        .env("XDG_STATE_HOME", place.folder.path().join("state"));
    let run = Run::of(bash.output().unwrap());
    assert_eq!(run.exit, 0, "{}\n{}", run.out, run.err);
}
