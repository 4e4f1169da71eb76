//! The SRDF that belongs to a URDF, where nobody names it.

use std::path::{Path, PathBuf};

use super::folder_of;

/// Folders in which an SRDF is looked for, from the URDF's: beside it, and as packages of robots and MoveIt's
/// configurations have it.
const FOLDERS: [&str; 5] = [".", "srdf", "config", "../srdf", "../config"];

/// The SRDF of a URDF: one of the same name beside it, in `srdf/` or `config/` there or one folder up; else the only
/// one in these whose `<robot name>` is the URDF's.
pub fn srdf_of(urdf: &Path) -> Option<PathBuf> {
    let folders: Vec<PathBuf> = FOLDERS.iter().map(|folder| folder_of(urdf).join(folder)).collect();
    let stem = urdf.file_stem()?.to_str()?;
    // `robot.urdf.xml` and the like are called after the robot too.
    let stem = stem.strip_suffix(".urdf").unwrap_or(stem);
    let named = [urdf.with_extension("srdf")].into_iter();
    let named = named.chain(folders.iter().map(|folder| folder.join(format!("{stem}.srdf"))));
    named.into_iter().find(|file| file.is_file()).or_else(|| of_name(&folders, &robot_name(urdf)?))
}

/// The only SRDF in the folders that is for a robot of this name.
fn of_name(folders: &[PathBuf], name: &str) -> Option<PathBuf> {
    let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
    let srdfs = files.map(|entry| entry.path()).filter(|file| file.extension().is_some_and(|e| e == "srdf"));
    let mut found = srdfs.filter(|file| robot_name(file).as_deref() == Some(name));
    let first = found.next()?;
    found.next().is_none().then_some(first)
}

/// The name that a robot's file gives it.
fn robot_name(file: &Path) -> Option<String> {
    let (text, _) = super::text::read_xml(file).ok()?;
    crate::robot::xml_name(&text)
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
        let urdf = write("p/urdf/arm.urdf", "panda");
        assert_eq!(srdf_of(&urdf), None);
        let other = write("p/config/other.srdf", "other");
        assert_eq!(srdf_of(&urdf), None, "another robot's");
        let by_name = write("p/config/x.srdf", "panda");
        let same = |found: Option<PathBuf>, file: &Path| {
            assert_eq!(found.unwrap().canonicalize().unwrap(), file.canonicalize().unwrap());
        };
        same(srdf_of(&urdf), &by_name);
        let second = write("p/srdf/y.srdf", "panda");
        assert_eq!(srdf_of(&urdf), None, "two are none");
        std::fs::remove_file(second).unwrap();
        let in_srdf = write("p/srdf/arm.srdf", "whatever");
        same(srdf_of(&urdf), &in_srdf);
        let beside = write("p/urdf/arm.srdf", "whatever");
        same(srdf_of(&urdf), &beside);
        drop(other);
    }
}
