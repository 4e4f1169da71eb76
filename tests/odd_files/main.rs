//! Odd but valid files, read as at least two independent readers read them, or refused in one line.
//!
//! The files are made here. `expected.json` holds what other programs read in them, each with its
//! version; `expect.py` makes it anew. Neither those programs nor a network is needed to run this.

mod case;
mod compare;
mod dae;
mod measure;
mod obj;
mod scene;
mod srdf;
mod stl;
mod urdf;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use case::{Case, Stance};
use compare::{Meaning, Readings, Table, difference};
use serde_json::Value;

fn cases() -> Vec<Case> {
    [
        stl::cases(),
        obj::cases(),
        dae::cases(),
        urdf::cases(),
        srdf::cases(),
        scene::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Files that others name.
fn companions() -> Vec<(&'static str, Vec<u8>)> {
    let content = |name: &str| {
        cases()
            .into_iter()
            .find(|case| case.name == name)
            .map(|case| case.bytes)
            .expect(name)
    };
    let stl = content("stl/binary_plain.stl");
    let mut files: Vec<(&str, Vec<u8>)> = [
        "urdf/part.stl",
        "urdf/PART.STL",
        "urdf/meshes/part.stl",
        "urdf/my part.stl",
        "urdf/part.xyz",
    ]
    .map(|name| (name, stl.clone()))
    .into();
    files.push(("urdf/part.obj", content("obj/quads.obj")));
    files.push(("urdf/part.dae", content("dae/unit_centimetre.dae")));
    files.push(("srdf/robot.urdf", srdf::ROBOT.into()));
    files.push(("scene/robot.urdf", scene::ROBOT.into()));
    files
}

/// Writes the corpus. `TAUT_ODD_FILES` names another folder, for `expect.py`.
fn written(folder: &Path) {
    let files = cases()
        .into_iter()
        .map(|case| (case.name, case.bytes));
    let companions = companions()
        .into_iter()
        .map(|(name, bytes)| (name.to_owned(), bytes));
    for (name, bytes) in files.chain(companions) {
        let file = folder.join(name);
        fs::create_dir_all(file.parent().expect("a folder of its kind")).unwrap();
        fs::write(file, bytes).unwrap();
    }
}

fn table() -> Table {
    let file: PathBuf = [env!("CARGO_MANIFEST_DIR"), "tests/odd_files/expected.json"]
        .iter()
        .collect();
    serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}

/// Whether a file is to us what it shall be; else how it is not.
fn judged(case: &Case, folder: &Path, table: &Table) -> Result<(), String> {
    let readings = table
        .files
        .get(&case.name)
        .ok_or("expected.json does not have it; run expect.py")?;
    if readings.digest != case.digest() {
        return Err("expected.json was made of another content; run expect.py".to_owned());
    }
    let read = measure::read(&folder.join(&case.name), case.kind());
    match (&case.stance, read) {
        (Stance::Refused(parts, _), Err(line)) => refusal(case, &line, parts),
        (Stance::Refused(_, why), Ok(read)) => {
            Err(format!("it shall be refused ({why}), and is read: {read}"))
        }
        (_, Err(line)) => Err(format!("it shall be read ({}): {line}", who(readings))),
        (Stance::Read, Ok(read)) => as_meant(&read, readings, |meanings| table.common(meanings)),
        (Stance::ReadAs(reader, why), Ok(read)) => as_meant(&read, readings, |meanings| {
            let theirs = meanings
                .iter()
                .find(|meaning| meaning.readers.contains(*reader));
            theirs.or_else(|| table.common(meanings))
        })
        .map_err(|how| format!("{how} ({why})")),
    }
}

fn refusal(case: &Case, line: &str, parts: &[&str]) -> Result<(), String> {
    let name = case
        .name
        .split('/')
        .next_back()
        .unwrap_or_default();
    let missing: Vec<&&str> = parts
        .iter()
        .chain([&name])
        .filter(|part| !line.contains(**part))
        .collect();
    match (missing.is_empty(), line.contains('\n')) {
        (true, false) => Ok(()),
        (_, true) => Err(format!("refused in more than one line: {line:?}")),
        (false, _) => Err(format!("the refusal lacks {missing:?}: {line}")),
    }
}

/// Compares each aspect that others read with the meaning that counts.
fn as_meant<'a>(
    read: &Value,
    readings: &'a Readings,
    meant: impl Fn(&'a [Meaning]) -> Option<&'a Meaning>,
) -> Result<(), String> {
    if readings.meanings.is_empty() {
        return Err(format!("nobody else reads it: {:?}", readings.refused));
    }
    for (aspect, meanings) in &readings.meanings {
        let Some(meaning) = meant(meanings) else {
            let split: Vec<_> = meanings
                .iter()
                .map(|meaning| (&meaning.readers, difference(&read[aspect], &meaning.value)))
                .collect();
            return Err(format!("readers do not agree on its {aspect}: {split:?}"));
        };
        if let Some(difference) = difference(&read[aspect], &meaning.value) {
            return Err(format!(
                "{aspect}{difference}, as {:?} read it",
                meaning.readers
            ));
        }
    }
    Ok(())
}

fn who(readings: &Readings) -> String {
    let meaning = |(aspect, meanings): (&String, &Vec<Meaning>)| {
        let readers: Vec<_> = meanings
            .iter()
            .map(|meaning| format!("{:?}", meaning.readers))
            .collect();
        format!("{aspect} by {}", readers.join(" and otherwise by "))
    };
    readings
        .meanings
        .iter()
        .map(meaning)
        .collect::<Vec<_>>()
        .join("; ")
}

#[test]
fn files_are_read_as_independent_readers_read_them_or_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let table = table();
    let cases = cases();
    let mut wrong = Vec::new();
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for case in &cases {
        let what = match case.stance {
            Stance::Read => "read as most read it",
            Stance::ReadAs(..) => "read as one reads it, where others differ",
            Stance::Refused(..) => "refused",
        };
        *counts.entry((case.kind(), what)).or_default() += 1;
        if let Err(how) = judged(case, folder.path(), &table) {
            wrong.push(format!("{}: {how}", case.name));
        }
    }
    counts
        .iter()
        .for_each(|((kind, what), count)| println!("{kind:6} {count:3} {what}"));
    assert!(
        wrong.is_empty(),
        "{} of {} files:\n{}",
        wrong.len(),
        cases.len(),
        wrong.join("\n")
    );
}

#[test]
fn the_corpus_is_large_and_no_file_comes_twice() {
    let names: std::collections::BTreeSet<String> = cases()
        .into_iter()
        .map(|case| case.name)
        .collect();
    assert_eq!(names.len(), cases().len());
    assert!(names.len() >= 300, "{} files", names.len());
    assert_eq!(
        table().files.len(),
        names.len(),
        "expected.json holds other files"
    );
}

/// Writes the corpus for `expect.py`:
/// `TAUT_ODD_FILES=FOLDER cargo test --test odd_files -- --ignored`.
#[test]
#[ignore = "writes a folder"]
fn write_the_corpus() {
    let folder =
        std::env::var_os("TAUT_ODD_FILES").expect("TAUT_ODD_FILES names the folder to write");
    written(Path::new(&folder));
    let list: Vec<(String, String)> = cases()
        .iter()
        .map(|case| (case.name.clone(), case.digest()))
        .collect();
    fs::write(
        Path::new(&folder).join("list.json"),
        serde_json::to_string(&list).unwrap(),
    )
    .unwrap();
}

/// Writes what is read in other robots, for `pypi_robots.py`: `TAUT_ROBOTS` names a list of files,
/// `TAUT_READINGS` the file to write.
#[test]
#[ignore = "reads robots that are not here"]
fn read_other_robots() {
    let named = |name| std::env::var_os(name).unwrap_or_else(|| panic!("{name} names a file"));
    let list = fs::read_to_string(named("TAUT_ROBOTS")).unwrap();
    let read = |file: &str| match measure::packaged_robot(Path::new(file)) {
        Ok(read) => serde_json::json!({ "read": read }),
        Err(line) => serde_json::json!({ "refused": line }),
    };
    let readings: BTreeMap<&str, Value> = list
        .lines()
        .map(|file| (file, read(file)))
        .collect();
    fs::write(
        named("TAUT_READINGS"),
        serde_json::to_string(&readings).unwrap(),
    )
    .unwrap();
}
