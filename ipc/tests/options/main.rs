//! Every language has the options of the table, and no others: what is made of the table is
//! committed, and this makes it again (`UPDATE_OPTIONS=1 cargo test -p taut-ipc --test options`).

mod c;
mod cpp;
mod docs;
mod python;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use taut_ipc::planner::Request;
use taut_ipc::planner::options::{Default, Kind, Row, TABLE, Value};
use taut_ipc::wire::Mode;

const COMMAND: &str = "UPDATE_OPTIONS=1 cargo test -p taut-ipc --test options";

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn read(name: &str) -> String {
    fs::read_to_string(file(name)).unwrap_or_default()
}

/// Compares a committed file with what the table makes, or writes it.
fn hold(name: &str, made: &str) {
    if std::env::var_os("UPDATE_OPTIONS").is_some() {
        fs::create_dir_all(file(name).parent().unwrap()).unwrap();
        fs::write(file(name), made).unwrap();
    }
    assert!(
        read(name) == made,
        "ipc/{name} is not what the table of options says; {COMMAND} writes it"
    );
}

/// The text with what stands between the lines `begin` and `end` replaced.
fn with_region(text: &str, begin: &str, end: &str, made: &str) -> String {
    let start = text
        .find(begin)
        .unwrap_or_else(|| panic!("no line {begin:?}"));
    let start = start + text[start..].find('\n').unwrap() + 1;
    let rest = text[start..]
        .find(end)
        .unwrap_or_else(|| panic!("no {end:?} after {begin:?}"));
    let line = text[..start + rest].rfind('\n').unwrap() + 1;
    format!("{}{made}{}", &text[..start], &text[line..])
}

/// Words in lines of at most `width` characters, each after `before`, the first after `first`.
fn wrapped(words: &str, first: &str, before: &str, width: usize) -> String {
    let mut lines = String::new();
    let mut line = first.to_owned();
    let mut is_empty = true;
    for word in words.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > width {
            lines += line.trim_end();
            lines.push('\n');
            line = before.to_owned();
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line += word;
        is_empty = false;
    }
    lines + &line + "\n"
}

#[test]
fn the_documentation_lists_every_option() {
    hold("../docs/options.md", &docs::page());
}

#[test]
fn c_has_every_option() {
    hold("c/src/options_table.rs", &c::source());
}

#[test]
fn cpp_has_every_option() {
    let name = "c/include/taut.hpp";
    hold(name, &cpp::header(&read(name)));
    let header = read(name);
    let setters: BTreeSet<&str> = header
        .lines()
        .filter_map(|line| {
            line.trim()
                .strip_prefix("options &")?
                .split('(')
                .next()
        })
        .collect();
    let names: Vec<String> = TABLE.iter().map(Row::cpp).collect();
    assert_eq!(setters, names.iter().map(String::as_str).collect());
}

#[test]
fn python_has_every_option() {
    let name = "python/python/taut/_planner.py";
    hold(name, &python::module(&read(name)));
    let module = read(name);
    for call in python::CALLS {
        let text = &module[module
            .find(&format!("    def {}(", call.name))
            .unwrap()..];
        let signature = &text[text.find("*,").unwrap() + 2..text.find(") ->").unwrap()];
        let keywords: BTreeSet<&str> = signature
            .lines()
            .filter_map(|line| line.trim().split_once(": "))
            .filter(|(name, _)| !name.starts_with('#'))
            .map(|(name, _)| name)
            .collect();
        let names: Vec<String> = call
            .rows()
            .filter_map(|row| row.python().ok())
            .collect();
        let expected: BTreeSet<&str> = names.iter().map(String::as_str).collect();
        assert_eq!(keywords, expected, "Planner.{}", call.name);
    }
}

#[test]
fn every_option_can_be_entered_by_its_name() {
    let plain = Request::new("r", None);
    for row in TABLE {
        let mut request = plain.clone();
        row.set(&mut request, other_than_default(row))
            .unwrap();
        assert_ne!(request, plain, "{}", row.field);
        let wrong = match row.kind {
            Kind::Flag => Value::Count(1),
            _ => Value::Flag(true),
        };
        let refused = row
            .set(&mut request, wrong)
            .unwrap_err()
            .to_string();
        assert!(refused.starts_with(row.field), "{refused}");
    }
}

#[test]
fn numbers_beyond_a_field_are_refused_with_the_valid_ones() {
    let priority = taut_ipc::planner::options::row("priority");
    let mut request = Request::new("r", None);
    let refused = priority
        .set(&mut request, Value::Count(1 << 32))
        .unwrap_err();
    assert!(
        refused
            .to_string()
            .ends_with("valid: 0 to 4294967295"),
        "{refused}"
    );
}

fn other_than_default(row: &Row) -> Value {
    match row.kind {
        Kind::Flag => Value::Flag(row.default == Default::Is("off")),
        Kind::Count(_) => Value::Count(7),
        Kind::Metres => Value::Metres(0.5),
        Kind::Seconds => Value::Seconds(std::time::Duration::from_secs(1)),
        Kind::Mode => Value::Mode(Mode::Check),
        Kind::Name => Value::Name("n".to_owned()),
        Kind::Text => Value::Text("upright hand:x=0.1".to_owned()),
        Kind::Names => Value::Names(vec!["n".to_owned()]),
        Kind::Named => Value::Named(vec![("n".to_owned(), 1.0)]),
        Kind::Numbers => Value::Numbers(vec![1.0]),
        Kind::Indices => Value::Indices(vec![1]),
    }
}
