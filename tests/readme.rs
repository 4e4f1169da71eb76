//! README.md and the pages of `docs/`: each page's commands are run in the order in which a reader
//! would, by the binary of this build; every option that a page names is one that there is; every
//! link leads somewhere.
#![cfg(feature = "daemon")]

mod common;

use std::collections::BTreeMap;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::pages::{Block, Mention, Page, pages_of_users, takes};
use common::*;

/// What `tests/`, `benches/` and `.ci/run` run themselves, or what takes another machine: a comment
/// before the block says so.
const ELSEWHERE: [&str; 3] = ["build", "measured", "elsewhere"];

/// How large README.md may become, in bytes.
const README_BYTES: usize = 8_000;

/// Pages beside those of users, whose links and options are looked at too.
const MORE_PAGES: [&str; 7] = [
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "examples/planners/README.md",
    "ipc/WIRE.md",
    "ipc/c/README.md",
    "ipc/python/README.md",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A folder in which a page's commands run, as in a clone, with `taut` on the path.
struct Checkout {
    place: Place,
    folder: PathBuf,
    bin: PathBuf,
}

impl Checkout {
    fn new() -> Self {
        let place = Place::new();
        let folder = place.folder.path().join("clone");
        let bin = place.folder.path().join("bin");
        for new in [&folder, &bin] {
            std::fs::create_dir(new).unwrap();
        }
        for name in ["config", "examples", "ipc"] {
            symlink(root().join(name), folder.join(name)).unwrap();
        }
        symlink(env!("CARGO_BIN_EXE_taut"), bin.join("taut")).unwrap();
        Self { place, folder, bin }
    }

    fn run(&self, script: &str) -> Run {
        let path = format!("{}:{}", self.bin.display(), std::env::var("PATH").unwrap());
        let home = self.place.folder.path();
        let mut bash = Command::new("bash");
        bash.args(["-c", script])
            .current_dir(&self.folder)
            .env("PATH", path)
            .env("TAUT_INSTANCE", self.place.name())
            .env("HOME", home)
            .env("XDG_STATE_HOME", home.join("state"));
        Run::of(bash.output().unwrap())
    }
}

/// A line of a page as the script runs it.
fn step(line: &str) -> String {
    let mut step = format!("echo '+ {}' >&2\n{line}\n", line.replace('\'', ""));
    if line.starts_with("taut serve ") {
        step += "for _ in $(seq 300); do taut list >/dev/null 2>&1 && break; sleep 0.1; done\n";
    }
    step
}

/// Runs a page's commands; says how many there were.
fn run(page: &Page) -> usize {
    let checkout = Checkout::new();
    let mut script =
        "set -euo pipefail\ntrap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n".to_owned();
    let mut commands = 0;
    for Block {
        language,
        text,
        note,
    } in page.blocks()
    {
        match (language.as_str(), note.as_str()) {
            ("sh", "") => {
                commands += text
                    .lines()
                    .filter(|line| line.starts_with("taut "))
                    .count();
                script.extend(text.lines().map(step));
            }
            ("sh", note) => assert!(
                ELSEWHERE.contains(&note),
                "{}: a block of commands that is not run: {note:?}",
                page.file.display()
            ),
            ("json" | "text", name) if !name.is_empty() => {
                std::fs::write(checkout.folder.join(name), text).unwrap();
            }
            _ => {}
        }
    }
    if commands > 0 {
        let run = checkout.run(&script);
        assert_eq!(
            run.exit,
            0,
            "{}: {}\n{}",
            page.file.display(),
            run.out,
            run.err
        );
    }
    commands
}

#[test]
fn the_commands_run_as_they_stand() {
    let commands: usize = pages_of_users(root()).iter().map(run).sum();
    assert!(
        commands > 40,
        "{commands} commands; have the pages another form?"
    );
}

/// What `taut COMMAND --help` prints; nothing where there is no such command.
fn help(command: &[String]) -> Option<String> {
    let mut taut = Command::new(env!("CARGO_BIN_EXE_taut"));
    let run = Run::of(
        taut.args(&command[1..])
            .arg("--help")
            .output()
            .unwrap(),
    );
    (run.exit == 0).then_some(run.out)
}

/// The commands that a help text lists.
fn commands_in(help: &str) -> Vec<String> {
    let listed = help
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty());
    let names = listed.filter_map(|line| line.split_whitespace().next());
    names
        .filter(|name| !["bench", "zenoh", "help"].contains(name))
        .map(str::to_owned)
        .collect()
}

/// Help texts of `taut` and of all its commands, each asked for once.
struct Helps(BTreeMap<Vec<String>, Option<String>>);

impl Helps {
    fn of_all_commands() -> Self {
        let taut = vec!["taut".to_owned()];
        let whole = help(&taut).unwrap();
        let mut helps = Self(BTreeMap::new());
        for name in commands_in(&whole) {
            let command = [taut.clone(), vec![name]].concat();
            let nested = helps.get(&command).map(commands_in);
            for name in nested.unwrap_or_default() {
                helps.get(&[command.clone(), vec![name]].concat());
            }
        }
        helps
    }

    fn get(&mut self, command: &[String]) -> Option<&str> {
        let text = self
            .0
            .entry(command.to_owned())
            .or_insert_with(|| help(command));
        text.as_deref()
    }

    /// What a page says wrongly.
    fn objection(&mut self, mention: &Mention) -> Option<String> {
        let Mention {
            command,
            options,
            text,
        } = mention;
        let unknown = if command.is_empty() {
            options
                .iter()
                .find(|option| !self.any_takes(option))
        } else {
            let Some(help) = self.get(command) else {
                return Some(format!("`{text}`: there is no {}", command.join(" ")));
            };
            options
                .iter()
                .find(|option| !takes(help, option))
        };
        unknown.map(|option| format!("`{text}`: no {option}"))
    }

    fn any_takes(&self, option: &str) -> bool {
        self.0
            .values()
            .flatten()
            .any(|help| takes(help, option))
    }
}

/// What `taut-bench` takes is looked at beside it, in `benches/tests`; `taut-zenoh` is not built here.
fn is_of_taut(mention: &Mention) -> bool {
    let words: Vec<&str> = mention
        .command
        .iter()
        .map(String::as_str)
        .collect();
    !matches!(
        words[..],
        ["taut-bench" | "taut-zenoh", ..] | ["taut", "bench" | "zenoh", ..]
    )
}

#[test]
fn every_command_and_option_that_a_page_names_is_there() {
    let mut helps = Helps::of_all_commands();
    let more =
        ["ipc/c/README.md", "ipc/python/README.md"].map(|name| Page::read(root().join(name)));
    let mut wrong = Vec::new();
    let mut named = 0;
    for page in pages_of_users(root()).iter().chain(&more) {
        for mention in page
            .mentions()
            .iter()
            .filter(|mention| is_of_taut(mention))
        {
            named += mention.options.len();
            let objection = helps.objection(mention);
            wrong.extend(objection.map(|text| format!("{}: {text}", page.file.display())));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(named > 60, "{named} options; have the pages another form?");
}

#[test]
fn every_link_leads_somewhere_and_readme_leads_to_every_page() {
    let users = pages_of_users(root());
    let more = MORE_PAGES.map(|name| Page::read(root().join(name)));
    let mut wrong = Vec::new();
    for page in users.iter().chain(&more) {
        let broken = page
            .links()
            .into_iter()
            .filter(|link| !link.exists());
        wrong.extend(broken.map(|link| format!("{}: {}", page.file.display(), link.display())));
    }
    assert!(
        wrong.is_empty(),
        "these lead nowhere:\n{}",
        wrong.join("\n")
    );
    let (readme, pages) = users.split_first().unwrap();
    let links = readme.links();
    for page in pages {
        assert!(
            links.contains(&page.file),
            "README.md does not lead to {}",
            page.file.display()
        );
    }
}

#[test]
fn readme_is_short() {
    let readme = Page::read(root().join("README.md"));
    assert!(
        readme.text.len() <= README_BYTES,
        "README.md has {} bytes; what is more than {README_BYTES} goes to a page of docs/",
        readme.text.len()
    );
}

/// Rows of the tables of a page, cell by cell.
fn rows(page: &Page) -> Vec<Vec<&str>> {
    let lines = page
        .text
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |"));
    lines
        .map(|line| line.split(" | ").collect())
        .collect()
}

#[test]
fn figures_of_readme_are_those_of_their_page() {
    let readme = Page::read(root().join("README.md"));
    let figures = Page::read(root().join("docs/figures.md"));
    let known = rows(&figures);
    let table = rows(&readme);
    let measured: Vec<_> = table
        .iter()
        .filter(|row| {
            row.iter()
                .any(|cell| cell.ends_with(" s") || cell.ends_with(" ms"))
        })
        .collect();
    assert!(!measured.is_empty(), "README.md has no table of figures");
    for row in measured {
        let is_there = known.iter().any(|there| {
            there[0].starts_with(row[0])
                && row
                    .iter()
                    .skip(1)
                    .all(|cell| there.contains(cell))
        });
        assert!(is_there, "docs/figures.md has no such row: {row:?}");
    }
}
