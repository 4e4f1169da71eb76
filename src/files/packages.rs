//! Where the files are that a robot or a scene names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Finds files by the names that robots give them: `package://NAME/…`, `file://…`, absolute, or
/// relative to the folder of the robot's own file.
#[derive(Clone, Debug, Default)]
pub struct Packages {
    named: BTreeMap<String, PathBuf>,
    /// Entries of `ROS_PACKAGE_PATH`: packages, or folders of packages.
    ros: Vec<PathBuf>,
    /// Entries of `AMENT_PREFIX_PATH`: packages are in `share/`.
    ament: Vec<PathBuf>,
}

impl Packages {
    /// Packages by name, and nothing else.
    pub fn new(named: BTreeMap<String, PathBuf>) -> Self {
        Self { named, ..Self::default() }
    }

    /// Packages by name, then those of `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`.
    pub fn with_environment(named: BTreeMap<String, PathBuf>) -> Self {
        let entries = |variable: &str| match std::env::var_os(variable) {
            Some(value) => std::env::split_paths(&value).filter(|entry| !entry.as_os_str().is_empty()).collect(),
            None => Vec::new(),
        };
        Self { named, ros: entries("ROS_PACKAGE_PATH"), ament: entries("AMENT_PREFIX_PATH") }
    }

    /// The same, with more packages by name, which go first.
    pub(super) fn with(&self, named: &BTreeMap<String, PathBuf>) -> Self {
        let mut all = self.clone();
        all.named.extend(named.clone());
        all
    }

    /// The file that `name` stands for in a file of `folder`.
    ///
    /// # Errors
    /// Where it was looked for, and what to do.
    pub fn resolve(&self, name: &str, folder: &Path) -> Result<PathBuf, String> {
        let packaged = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://"));
        let Some(packaged) = packaged else {
            let file = folder.join(name.strip_prefix("file://").unwrap_or(name));
            return if file.is_file() { Ok(file) } else { Err(format!("there is no file {}", file.display())) };
        };
        let (package, rest) = packaged.split_once('/').unwrap_or((packaged, ""));
        let candidates = self.candidates(package, rest, folder);
        candidates.iter().find(|file| file.is_file()).cloned().ok_or_else(|| {
            if let Some(named) = self.named.get(package) {
                return format!("there is no {rest:?} in package {package:?}, which is {}", named.display());
            }
            let places = "ROS_PACKAGE_PATH, AMENT_PREFIX_PATH or a folder above the robot's file";
            format!(
                "package {package:?} with a file {rest:?} is in none of {places}; name it: --package {package}=FOLDER"
            )
        })
    }

    /// Where the file of a package may be, best first. A package that is named is nowhere else.
    fn candidates(&self, package: &str, rest: &str, folder: &Path) -> Vec<PathBuf> {
        if let Some(named) = self.named.get(package) {
            return vec![named.join(rest)];
        }
        // A folder of that name is the package itself; any other may hold it.
        let in_or_below = |entry: &Path| match entry.file_name().is_some_and(|name| name == package) {
            true => vec![entry.join(rest), entry.join(package).join(rest)],
            false => vec![entry.join(package).join(rest)],
        };
        let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let ros = self.ros.iter().flat_map(|entry| in_or_below(entry));
        let ament = self.ament.iter().map(|entry| entry.join("share").join(package).join(rest));
        ros.chain(ament).chain(absolute.ancestors().flat_map(in_or_below)).collect()
    }
}
