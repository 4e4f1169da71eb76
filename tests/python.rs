//! The Python package: its own tests against a real daemon and in its own process, and its types.

mod common;

use std::path::Path;
use std::process::Command;

use common::{Place, config, python::python};

fn package() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/ipc/python"))
}

#[test]
fn the_package_works() {
    let Some(python) = python(&[]) else { return };
    let place = Place::new();
    let _daemon = place.serve("");
    let output = Command::new(&python)
        .args(["-m", "pytest", "--quiet", "--color=no"])
        .arg(package().join("tests"))
        .current_dir(place.folder.path())
        .env("TAUT_CONFIG", config(""))
        .env("TAUT_BIN", env!("CARGO_BIN_EXE_taut"))
        .env("TAUT_TEST_INSTANCE", place.name())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(
        text.contains(" passed") && !text.contains(" skipped"),
        "{text}"
    );
}

#[test]
fn its_types_are_strict() {
    let Some(python) = python(&[]) else { return };
    // The package, and, by what is installed, a program that uses it.
    for what in ["python/taut", "tests/typed_use.py"] {
        let place = Place::new();
        let mut mypy = Command::new(&python);
        mypy.args(["-m", "mypy", "--strict", "--cache-dir"])
            .arg(place.folder.path())
            .arg(package().join(what))
            .current_dir(place.folder.path());
        let output = mypy.output().unwrap();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stdout)
        );
    }
}
