//! The SRDF that belongs to a URDF, where nobody names it.

use std::path::{Path, PathBuf};

use super::{folder_of, text};

/// Folders in which an SRDF is looked for, from the URDF's, as packages of robots and MoveIt's
/// configurations have it.
const FOLDERS: [&str; 4] = ["srdf", "config", "../srdf", "../config"];

/// The SRDF of a URDF: one of the same file name beside it; else one of that name, or of the
/// robot's own, in `srdf/` or `config/` there or one folder up. An SRDF of another name may switch
/// off what another check needs, so it is not taken.
pub fn srdf_of(urdf: &Path) -> Option<PathBuf> {
    let beside = urdf.with_extension("srdf");
    if beside.is_file() {
        return Some(beside);
    }
    let stem = urdf.file_stem()?.to_str()?.to_owned();
    let places: Vec<PathBuf> = FOLDERS
        .iter()
        .map(|folder| folder_of(urdf).join(folder))
        .collect();
    if !places.iter().any(|folder| folder.is_dir()) {
        return None;
    }
    let names = [Some(stem), robot_name(urdf)]
        .into_iter()
        .flatten();
    let files = names.flat_map(|name| {
        places
            .iter()
            .map(move |folder| folder.join(format!("{name}.srdf")))
    });
    files.into_iter().find(|file| file.is_file())
}

/// The name that a robot's file gives it, unless that is no file's.
fn robot_name(file: &Path) -> Option<String> {
    let bytes = std::fs::read(file).ok()?;
    let (text, _) = text::xml(&bytes).ok()?;
    crate::robot::xml_name(&text).filter(|name| !name.contains(['/', '\\']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_srdf_is_found_beside_the_urdf_and_where_packages_have_it() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, robot: &str| {
            let file = folder.path().join(name);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(&file, format!("<robot name='{robot}'/>")).unwrap();
            file
        };
        let same = |found: Option<PathBuf>, file: &Path| {
            assert_eq!(
                found.unwrap().canonicalize().unwrap(),
                file.canonicalize().unwrap()
            );
        };
        let urdf = write("p/urdf/arm.urdf", "panda");
        assert_eq!(srdf_of(&urdf), None);
        for other in [
            "p/urdf/other.srdf",
            "p/config/other.srdf",
            "arm.srdf",
            "p/urdf/panda.srdf",
        ] {
            write(other, "panda");
            assert_eq!(srdf_of(&urdf), None, "{other}");
        }
        let by_robot = write("p/config/panda.srdf", "panda");
        same(srdf_of(&urdf), &by_robot);
        let by_file = write("p/srdf/arm.srdf", "whatever");
        same(srdf_of(&urdf), &by_file);
        let beside = write("p/urdf/arm.srdf", "whatever");
        same(srdf_of(&urdf), &beside);
    }
}
