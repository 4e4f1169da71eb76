//! A Python with this project's package in it, made once for all tests that need it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// What the tests need besides the package itself.
const NEEDED: [&str; 4] = [
    "numpy>=1.22",
    "pytest==9.2.0",
    "mypy==2.4.1",
    "maturin==1.16.0",
];

static INSTALLED: OnceLock<()> = OnceLock::new();

/// The interpreter of a virtual environment below the target folder that has the package `taut`,
/// built from this source, and `more` packages; `None`, with a printed reason, where there is no
/// Python or no package index. With TAUT_REQUIRE_ALL=1 that fails instead.
pub fn python(more: &[&str]) -> Option<PathBuf> {
    match made(more) {
        Ok(python) => Some(python),
        Err(reason) if std::env::var_os("TAUT_REQUIRE_ALL").is_some_and(|value| value == "1") => {
            panic!("{reason}")
        }
        Err(reason) => {
            println!("skipped: {reason}");
            None
        }
    }
}

fn made(more: &[&str]) -> Result<PathBuf, String> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = target.join("python");
    // Tests of several binaries may want it at once.
    let lock = fs::File::create(target.join("python.lock"))
        .map_err(|error| format!("python.lock: {error}"))?;
    lock.lock()
        .map_err(|error| format!("python.lock: {error}"))?;
    let python = folder.join("bin/python");
    if !python.is_file() {
        run(
            Command::new("python3")
                .args(["-m", "venv"])
                .arg(&folder),
            "python3 -m venv",
        )?;
    }
    let needed = [&NEEDED[..], more].concat();
    let stamp = folder.join("installed");
    let has = fs::read_to_string(&stamp).unwrap_or_default();
    let missing: Vec<&str> = needed
        .into_iter()
        .filter(|name| !has.lines().any(|line| line == *name))
        .collect();
    if !missing.is_empty() {
        let what = format!("pip install {}", missing.join(" "));
        run(
            Command::new(&python)
                .args(["-m", "pip", "install", "--quiet"])
                .args(&missing),
            &what,
        )?;
        fs::write(
            &stamp,
            missing
                .iter()
                .fold(has, |text, name| text + name + "\n"),
        )
        .map_err(|e| e.to_string())?;
    }
    // Once in this process: installing again would take it away from a test that uses it.
    INSTALLED.get_or_init(|| install(&python, target));
    Ok(python)
}

/// Installs the package; a failure is its own. Cargo finds out what has to be built again.
fn install(python: &Path, target: &Path) {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("ipc/python");
    let mut install = Command::new(python);
    install
        .args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--no-build-isolation",
            "--no-deps",
            "--force-reinstall",
        ])
        .arg(&package)
        // What is compiled already is not compiled again, and the next run finds what this one
        // compiles.
        .env("CARGO_TARGET_DIR", target.parent().unwrap_or(target))
        .env("PATH", path_with(&target.join("python/bin")))
        .env("MATURIN_PEP517_ARGS", "--profile dev");
    if let Err(error) = run(&mut install, "pip install ./ipc/python") {
        panic!("{error}");
    }
}

/// The search path with the environment's programs (maturin) first.
fn path_with(folder: &Path) -> std::ffi::OsString {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let all = std::iter::once(folder.to_owned()).chain(std::env::split_paths(&paths));
    std::env::join_paths(all).expect("the search path had no bad entry before")
}

fn run(command: &mut Command, what: &str) -> Result<(), String> {
    let output = command
        .output()
        .map_err(|error| format!("{what}: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let error = String::from_utf8_lossy(&output.stderr);
    let last = error.lines().rev().take(20).collect::<Vec<_>>();
    Err(format!(
        "{what} failed: {}",
        last.into_iter()
            .rev()
            .collect::<Vec<_>>()
            .join("\n")
    ))
}
