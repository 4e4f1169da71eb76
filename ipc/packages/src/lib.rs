//! Where the files are that a robot or a scene names: for who reads them, and for who sends them to
//! another machine.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

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
        Self {
            named,
            ..Self::default()
        }
    }

    /// Packages by name, then those of `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`.
    pub fn with_environment(named: BTreeMap<String, PathBuf>) -> Self {
        let entries = |variable: &str| match std::env::var_os(variable) {
            Some(value) => std::env::split_paths(&value)
                .filter(|entry| !entry.as_os_str().is_empty())
                .collect(),
            None => Vec::new(),
        };
        Self {
            named,
            ros: entries("ROS_PACKAGE_PATH"),
            ament: entries("AMENT_PREFIX_PATH"),
        }
    }

    /// The same, with more packages by name, which go first.
    #[must_use]
    pub fn with(&self, named: &BTreeMap<String, PathBuf>) -> Self {
        let mut all = self.clone();
        all.named.extend(named.clone());
        all
    }

    /// The file that `name` stands for in a file of `folder`.
    ///
    /// # Errors
    /// Where it was looked for, and what to do.
    pub fn resolve(&self, name: &str, folder: &Path) -> Result<PathBuf, String> {
        let plain = self.find(name, folder);
        // As it stands first: a file may have a `%` in its name.
        match unescaped(name) {
            Some(name) if plain.is_err() => self.find(&name, folder).or(plain),
            _ => plain,
        }
    }

    fn find(&self, name: &str, folder: &Path) -> Result<PathBuf, String> {
        let packaged = name
            .strip_prefix("package://")
            .or_else(|| name.strip_prefix("model://"));
        let Some(packaged) = packaged else {
            let file = folder.join(of_file_address(name));
            return if file.is_file() {
                Ok(file)
            } else {
                Err(format!("there is no file {}", file.display()))
            };
        };
        let (package, rest) = packaged
            .split_once('/')
            .unwrap_or((packaged, ""));
        let Some(inner) = inside(rest) else {
            return Err(format!(
                "{rest:?} is not in package {package:?}; name the package that it is in"
            ));
        };
        let candidates = self.candidates(package, &inner, folder);
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
    fn candidates(&self, package: &str, rest: &Path, folder: &Path) -> Vec<PathBuf> {
        if let Some(named) = self.named.get(package) {
            return vec![named.join(rest)];
        }
        // A folder of that name is the package itself; any other may hold it.
        let in_or_below = |entry: &Path| match entry
            .file_name()
            .is_some_and(|name| name == package)
        {
            true => vec![entry.join(rest), entry.join(package).join(rest)],
            false => vec![entry.join(package).join(rest)],
        };
        let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let ros = self
            .ros
            .iter()
            .flat_map(|entry| in_or_below(entry));
        let ament = self
            .ament
            .iter()
            .map(|entry| entry.join("share").join(package).join(rest));
        ros.chain(ament)
            .chain(absolute.ancestors().flat_map(in_or_below))
            .collect()
    }
}

/// The path in `file:///x`, `file://localhost/x`, `file:/x`, or in `file://x` and `file:x`, which
/// are relative.
fn of_file_address(name: &str) -> &str {
    let Some(path) = name.strip_prefix("file:") else {
        return name;
    };
    let path = path.strip_prefix("//").unwrap_or(path);
    match path.strip_prefix("localhost") {
        Some(rest) if rest.starts_with('/') => rest,
        _ => path,
    }
}

/// A relative path without `.` and `..`; `None` where it goes out of the folder that it starts in.
fn inside(path: &str) -> Option<PathBuf> {
    let mut parts = PathBuf::new();
    for part in Path::new(path).components() {
        match part {
            Component::ParentDir => parts.pop().then_some(())?,
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
            Component::Normal(name) => parts.push(name),
        }
    }
    Some(parts)
}

/// The name with `%20` and its like read as in an address; `None` where there is none.
fn unescaped(name: &str) -> Option<String> {
    let mut parts = name.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    let mut is_escaped = false;
    for part in parts {
        match part
            .get(..2)
            .and_then(|digits| u8::from_str_radix(digits, 16).ok())
        {
            Some(byte) => {
                bytes.push(byte);
                bytes.extend_from_slice(&part.as_bytes()[2..]);
                is_escaped = true;
            }
            None => {
                bytes.push(b'%');
                bytes.extend_from_slice(part.as_bytes());
            }
        }
    }
    String::from_utf8(bytes)
        .ok()
        .filter(|_| is_escaped)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_addresses_and_escapes_are_read() {
        for (address, path) in [
            ("file:///a/b.stl", "/a/b.stl"),
            ("file:/a/b.stl", "/a/b.stl"),
            ("file://localhost/a/b.stl", "/a/b.stl"),
            ("file://a/b.stl", "a/b.stl"),
            ("localhost/b.stl", "localhost/b.stl"),
        ] {
            assert_eq!(of_file_address(address), path);
        }
        assert_eq!(unescaped("a%20b%C3%B6.stl").as_deref(), Some("a bö.stl"));
        assert_eq!(unescaped("100%.stl"), None);
        assert_eq!(unescaped("%é0"), None);
    }

    #[test]
    fn a_name_stays_in_its_package() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("p/my meshes");
        std::fs::create_dir_all(&place).unwrap();
        std::fs::write(place.join("a.STL"), "").unwrap();
        std::fs::write(folder.path().join("secret.stl"), "").unwrap();
        let packages = Packages::new([("p".to_owned(), folder.path().join("p"))].into());
        let find = |name: &str| packages.resolve(name, folder.path());
        for name in [
            "package://p/my meshes/a.STL",
            "package://p//my%20meshes/a.STL",
            "package://p/x/../my meshes/./a.STL",
        ] {
            assert!(find(name).is_ok(), "{name}: {:?}", find(name));
        }
        let outside = folder
            .path()
            .join("secret.stl")
            .display()
            .to_string();
        for name in [
            format!("package://p/{outside}"),
            format!("package://p//{outside}"),
        ] {
            assert!(find(&name).is_err(), "{name}");
        }
        for name in [
            "package://p/../secret.stl",
            "package://p/x/../../secret.stl",
            "package://p/%2e%2e/secret.stl",
        ] {
            let error = find(name).unwrap_err();
            assert!(error.contains("package \"p\""), "{error}");
        }
    }
}
