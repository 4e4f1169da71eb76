//! C and C++ programs against a real daemon, by plain compiler commands.

mod common;

use common::*;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use taut_ipc::planner::{Planner, Request};

/// The folder of libtaut.so and libtaut.a, which cargo builds for no test by itself.
fn library() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let folder = Path::new(env!("CARGO_BIN_EXE_taut"))
            .parent()
            .unwrap();
        let profile = match folder.file_name().unwrap().to_str().unwrap() {
            "debug" => "dev",
            other => other,
        };
        // As `cargo test --workspace` builds, so that dependencies have the features that they have
        // there.
        let built = Command::new(env!("CARGO"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args([
                "build",
                "--workspace",
                "--lib",
                "--test",
                "c_interface",
                "--locked",
                "--quiet",
                "--profile",
                profile,
            ])
            .status()
            .unwrap();
        assert!(built.success(), "libtaut does not build");
        folder.to_owned()
    })
}

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// How a program finds the library.
#[derive(Clone, Copy)]
enum Link {
    Shared,
    Static,
}

/// Compiles one file with every warning an error.
fn compile(place: &Place, file: &str, link: Link, flags: &[&str]) -> PathBuf {
    let (compiler, standard) = if file.ends_with(".c") {
        ("gcc", "c11")
    } else {
        ("g++", "c++17")
    };
    let program = place
        .folder
        .path()
        .join(format!("program-{}", file.replace('/', "-")));
    let mut command = Command::new(compiler);
    command
        .arg(format!("-std={standard}"))
        .args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-g"])
        .args(flags);
    command
        .arg("-I")
        .arg(source("ipc/c/include"))
        .arg("-I")
        .arg(source("ipc/c/tests/programs"));
    command
        .arg(source(file))
        .arg("-o")
        .arg(&program);
    match link {
        Link::Shared => command
            .arg("-L")
            .arg(library())
            .arg("-ltaut")
            .arg(format!("-Wl,-rpath,{}", library().display())),
        Link::Static => command
            .arg(library().join("libtaut.a"))
            .args(["-lm", "-lpthread", "-ldl"]),
    };
    let run = Run::of(command.output().unwrap());
    assert_eq!(run.exit, 0, "{compiler} {file}: {}", run.err);
    program
}

/// The problem's path as the programs read it.
fn path_file(place: &Place) -> String {
    let path = problem("arm_window")["path"]
        .as_array()
        .unwrap()
        .clone();
    let numbers: Vec<String> = path
        .iter()
        .flat_map(|row| row.as_array().unwrap())
        .map(ToString::to_string)
        .collect();
    place.file(
        "path",
        &format!(
            "{} {} {}",
            path.len(),
            numbers.len() / path.len(),
            numbers.join(" ")
        ),
    )
}

/// Runs a program in the place's instance.
fn start(place: &Place, program: &Path, argument: &str) -> Command {
    let mut command = Command::new(program);
    command
        .arg(argument)
        .env("TAUT_INSTANCE", place.name());
    command
}

fn runs(file: &str, link: Link, flags: &[&str], says: &str) {
    let place = Place::new();
    let _daemon = place.serve("");
    let program = compile(&place, file, link, flags);
    let run = Run::of(
        start(&place, &program, &path_file(&place))
            .output()
            .unwrap(),
    );
    assert_eq!(
        (run.exit, run.err.as_str()),
        (0, ""),
        "{file} {flags:?}: {}",
        run.out
    );
    assert!(run.out.contains(says), "{}", run.out);
}

const SANITIZED: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover"];
const PROGRAMS: [(&str, &str); 3] = [
    ("ipc/c/tests/programs/right_use.c", "right use is right"),
    ("ipc/c/tests/programs/wrong_use.c", "wrong use is told"),
    ("ipc/c/tests/programs/wrapper.cpp", "the wrapper wraps"),
];

#[test]
fn programs_run_with_the_shared_library() {
    PROGRAMS
        .iter()
        .for_each(|(file, says)| runs(file, Link::Shared, &[], says));
}

#[test]
fn programs_run_with_the_static_library() {
    PROGRAMS
        .iter()
        .for_each(|(file, says)| runs(file, Link::Static, &[], says));
}

#[test]
fn programs_run_under_the_address_sanitizer() {
    for (file, says) in PROGRAMS {
        runs(file, Link::Shared, &SANITIZED, says);
        runs(file, Link::Static, &SANITIZED, says);
    }
}

/// The bits of a trajectory as `timed.c` shows them.
fn timed_here(place: &Place) -> String {
    let planner = Planner::connect(&place.instance).unwrap();
    let rows: Vec<Vec<f64>> =
        serde_json::from_value(problem("arm_window")["path"].clone()).unwrap();
    let request = Request {
        work_budget: 20_000,
        timing: "acceleration=2/s speed=0.5 work=20000".to_owned(),
        ..Request::new("arm_window", Some("arm_window"))
    };
    let answers = planner.ask(&request, &rows.concat()).unwrap();
    let found = answers
        .result(PATIENCE)
        .unwrap()
        .timed()
        .unwrap();
    let times = found
        .times_ns
        .iter()
        .map(|ns| ns.cast_unsigned());
    let numbers = found.positions.iter().chain(&found.velocities);
    let bits = times.chain(numbers.map(|number| number.to_bits()));
    bits.map(|bits| format!("{bits:016x}\n"))
        .collect()
}

#[test]
fn a_trajectory_in_c_is_that_of_rust_to_the_last_bit() {
    let place = Place::new();
    let _daemon = place.serve("");
    let program = compile(&place, "ipc/c/tests/programs/timed.c", Link::Static, &[]);
    let path = path_file(&place);
    let run = Run::of(start(&place, &program, &path).output().unwrap());
    assert_eq!((run.exit, run.err.as_str()), (0, ""));
    assert_eq!(run.out, timed_here(&place));
}

#[test]
fn c_programs_are_cpp_programs_too() {
    let place = Place::new();
    for file in ["right_use.c", "wrong_use.c"] {
        let flags = [
            "-std=c++17",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            "-fsyntax-only",
            "-x",
            "c++",
        ];
        let mut command = Command::new("g++");
        command
            .args(flags)
            .arg("-I")
            .arg(source("ipc/c/include"))
            .arg(source("ipc/c/tests/programs").join(file));
        let run = Run::of(
            command
                .current_dir(place.folder.path())
                .output()
                .unwrap(),
        );
        assert_eq!(run.exit, 0, "{}", run.err);
    }
}

#[test]
fn the_examples_shorten_a_path() {
    for file in ["examples/c/shorten.c", "examples/cpp/shorten.cpp"] {
        let place = Place::new();
        let _daemon = place.serve("");
        let program = compile(&place, file, Link::Shared, &[]);
        let run = Run::of(
            start(&place, &program, &config(""))
                .output()
                .unwrap(),
        );
        assert_eq!(run.exit, 0, "{}", run.err);
        assert!(
            run.out.contains(", proved") && run.out.contains("kept"),
            "{}",
            run.out
        );
    }
}

#[test]
fn a_daemon_that_dies_ends_every_wait() {
    let place = Place::new();
    let daemon = place.serve("");
    let program = compile(
        &place,
        "ipc/c/tests/programs/daemon_dies.c",
        Link::Shared,
        &["-pthread"],
    );
    let mut waiting = start(&place, &program, &path_file(&place))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(waiting.stdout.take().unwrap()).lines();
    assert_eq!(lines.next().unwrap().unwrap(), "waiting");
    daemon.kill();
    let said = lines.next().unwrap().unwrap();
    assert!(waiting.wait().unwrap().success());
    // One thread hears of the death; the other of that or of the end of the stream.
    assert!(
        said.split(' ')
            .any(|code| code == "DAEMON_LOST"),
        "{said}"
    );
    assert!(
        said.split(' ')
            .all(|code| matches!(code, "DAEMON_LOST" | "END")),
        "{said}"
    );
}

/// The guide's simplifier, in a program that calls it with a shipped problem's path.
#[test]
fn the_guides_simplifier_shortens() {
    let guide = std::fs::read_to_string(source("examples/planners/README.md")).unwrap();
    let code = guide
        .split("```cpp\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .unwrap();
    // A loaded machine may not prove a path in the guide's time.
    let code = code.replace("deadline(0.05)", "deadline(60)");
    let main = r#"
#include "common.h"
int main(int, char **arguments) {
    const test_path read = read_path(arguments[1]);
    std::vector<std::vector<double>> rows;
    for (std::size_t row = 0; row < read.waypoints; ++row)
        rows.emplace_back(read.numbers + row * read.columns, read.numbers + (row + 1) * read.columns);
    const auto shorter = simplify(rows);
    CHECK(shorter.size() > 1 && shorter.front() == rows.front() && shorter.back() == rows.back() && shorter != rows);
    puts("shorter");
}"#;
    let place = Place::new();
    let _daemon = place.serve("");
    let file = place.file("simplify.cpp", &format!("{code}{main}"));
    let program = compile(&place, &file, Link::Shared, &[]);
    let mut command = start(&place, &program, &path_file(&place));
    let run = Run::of(
        command
            .current_dir(source(""))
            .output()
            .unwrap(),
    );
    assert_eq!(
        (run.exit, run.out.as_str()),
        (0, "shorter\n"),
        "{}",
        run.err
    );
}

/// The four lines that README.md and the guide of C and C++ begin with, in a function.
#[test]
fn the_lines_of_the_readmes_compile() {
    let place = Place::new();
    for page in ["README.md", "ipc/c/README.md"] {
        let text = std::fs::read_to_string(source(page)).unwrap();
        let (_, rest) = text.split_once("```cpp\n").expect(page);
        let (lines, _) = rest.split_once("```").unwrap();
        let whole = format!(
            "#include \"taut.hpp\"\n\
             template <class Rows> void use(double, const Rows &) {{}}\n\
             void pull(const taut::path &path) {{\n{lines}}}\n"
        );
        let file = place.file("lines.cpp", &whole);
        let mut command = Command::new("g++");
        command
            .args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"])
            .arg("-I")
            .arg(source("ipc/c/include"))
            .arg(&file);
        let run = Run::of(command.output().unwrap());
        assert_eq!(run.exit, 0, "{page}: {}", run.err);
    }
}

#[test]
fn the_commands_of_the_readme_build_the_examples() {
    let readme = std::fs::read_to_string(source("ipc/c/README.md")).unwrap();
    let place = Place::new();
    let _daemon = place.serve("");
    let mut built = 0;
    for line in readme
        .lines()
        .filter(|line| line.starts_with("gcc ") || line.starts_with("g++ "))
    {
        let line = line
            .replace("target/release", library().to_str().unwrap())
            .replace("$PWD//", "/");
        let line = line.replace(
            "-o shorten",
            &format!("-o {}", place.folder.path().join("shorten").display()),
        );
        let run = Run::of(
            Command::new("sh")
                .args(["-c", &line])
                .current_dir(source(""))
                .output()
                .unwrap(),
        );
        assert_eq!(run.exit, 0, "{line}: {}", run.err);
        let run = Run::of(
            start(&place, &place.folder.path().join("shorten"), &config(""))
                .output()
                .unwrap(),
        );
        assert_eq!(run.exit, 0, "{line}: {}", run.err);
        built += 1;
    }
    assert!(built >= 4, "{built} commands in ipc/c/README.md");
}
