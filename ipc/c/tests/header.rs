//! The committed header is what the sources make.

use std::fs;
use std::path::Path;

#[test]
fn the_header_is_up_to_date() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    // In this order, whatever that of the folder is.
    for file in [
        "code",
        "options_table",
        "error",
        "daemon",
        "robot",
        "scene",
        "options",
        "trajectory",
        "answer",
        "answers",
    ] {
        builder = builder.with_src(folder.join(format!("src/{file}.rs")));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let committed = folder.join("include/taut.h");
    if std::env::var_os("TAUT_WRITE_HEADER").is_some() {
        fs::write(&committed, &made).unwrap();
    }
    assert!(
        fs::read(&committed).unwrap() == made,
        "{} is not what the sources say; TAUT_WRITE_HEADER=1 cargo test -p taut-c --test header writes it",
        committed.display()
    );
    check_options(&String::from_utf8(made).unwrap());
}

#[test]
fn every_code_of_the_wire_has_its_name_and_number() {
    let header =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("include/taut.h")).unwrap();
    for code in taut_ipc::wire::Code::ALL {
        let line = format!("#define TAUT_{} {}", code.name(), i32::from(*code));
        assert!(
            header.lines().any(|found| found == line),
            "no line {line:?}"
        );
    }
}

fn check_options(header: &str) {
    let end = header.find("} taut_options;").unwrap();
    let start = header[..end].rfind("typedef struct {").unwrap();
    let fields: Vec<&str> = header[start..end]
        .lines()
        .filter(|line| !line.trim().starts_with("//"))
        .filter_map(|line| {
            line.strip_suffix(';')?
                .split([' ', '*'])
                .next_back()
        })
        .map(|name| name.split('[').next().unwrap())
        .filter(|name| !["size", "reserved"].contains(name))
        .collect();
    let table = taut_ipc::planner::options::TABLE;
    let expected: Vec<String> = table.iter().map(|row| row.c()).collect();
    assert_eq!(fields.join(" "), expected.join(" "));
}
