//! The robots and scenes that come with taut, which travel inside its programs: they run wherever they
//! are started. `taut-bench` has this file too.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Problems by name, each of another robot or another scene than the one before.
pub(crate) const PROBLEMS: [&str; 6] = [
    "arm_window",
    "rooms",
    "arm_shelf",
    "ell_window",
    "corner",
    "slalom",
];

macro_rules! shipped {
    ($($file:literal),* $(,)?) => {
        [$( ($file, include_str!(concat!("../../../config/", $file))), )*]
    };
}

/// Files below `config/` and their text.
const FILES: [(&str, &str); 16] = shipped![
    "problems/arm_window.json",
    "problems/rooms.json",
    "problems/arm_shelf.json",
    "problems/ell_window.json",
    "problems/corner.json",
    "problems/slalom.json",
    "robots/panda_like.urdf",
    "robots/panda_like.srdf",
    "robots/disc.urdf",
    "robots/disc.srdf",
    "robots/ell.urdf",
    "robots/ell.srdf",
    "robots/bar.urdf",
    "robots/bar.srdf",
    "robots/lift.urdf",
    "robots/lift.srdf",
];

/// Writes the files below a folder, where daemon and planners read them.
pub(crate) fn unpack(folder: &Path) -> io::Result<()> {
    for (name, text) in FILES {
        let file = folder.join(name);
        fs::create_dir_all(file.parent().unwrap_or(folder))?;
        fs::write(file, text)?;
    }
    Ok(())
}

/// The file of a problem below that folder.
pub(crate) fn problem_file(folder: &Path, name: &str) -> PathBuf {
    folder
        .join("problems")
        .join(format!("{name}.json"))
}
