//! A Python with what ROS 2 users have of PyPI, made once below the target folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Not of this project: what others make of the same bytes. Pinned, since what they do is what is compared.
const NEEDED: [&str; 3] = [
    "zenoh-ros2-sdk==0.1.8",
    "eclipse-zenoh==1.10.2",
    "rosbags==0.11.9",
];

/// Its interpreter; `None`, with a printed reason, where there is no Python or no package index. With
/// TAUT_REQUIRE_ALL=1 that fails instead.
pub fn python() -> Option<PathBuf> {
    match made(Path::new(env!("CARGO_TARGET_TMPDIR"))) {
        Ok(python) => Some(python),
        Err(reason) => {
            let is_required =
                std::env::var_os("TAUT_REQUIRE_ALL").is_some_and(|value| value == "1");
            assert!(!is_required, "{reason}");
            println!("skipped: {reason}");
            None
        }
    }
}

fn made(target: &Path) -> Result<PathBuf, String> {
    let folder = target.join("ros-python");
    // Tests of several binaries may want it at once.
    let lock = fs::File::create(target.join("ros-python.lock")).map_err(|e| e.to_string())?;
    lock.lock().map_err(|e| e.to_string())?;
    let python = folder.join("bin/python");
    let stamp = folder.join("installed");
    let needed = NEEDED.join(" ");
    if fs::read_to_string(&stamp).is_ok_and(|has| has == needed) {
        return Ok(python);
    }
    run(Command::new("python3")
        .args(["-m", "venv"])
        .arg(&folder))?;
    run(Command::new(&python)
        .args(["-m", "pip", "install", "--quiet"])
        .args(NEEDED))?;
    fs::write(&stamp, needed).map_err(|e| e.to_string())?;
    Ok(python)
}

/// Runs it to its end; gives what it prints.
pub fn run(command: &mut Command) -> Result<String, String> {
    let output = command
        .output()
        .map_err(|error| format!("{command:?}: {error}"))?;
    let error = String::from_utf8_lossy(&output.stderr);
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(format!("{command:?} failed: {error}")),
    }
}

/// Writes the definitions of messages as their packages have them, one file each.
pub fn write_definitions(folder: &Path, definitions: Vec<(&'static str, String)>) {
    for (name, text) in definitions {
        let file = folder.join(format!("{name}.msg"));
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    }
}
