//! `docs/options.md`.

use super::COMMAND;
use std::fmt::Write;
use taut_ipc::planner::options::{Asked, Kind, Row, TABLE, Wire};
use taut_ipc::wire::Mode;

pub fn page() -> String {
    let mut page = introduction();
    for row in TABLE {
        let _ = write!(page, "| `{}` ", row.field);
        let _ = write!(page, "| {} ", row.doc());
        let _ = write!(page, "| {} ", row.default_text());
        let _ = write!(page, "| {} ", valid(row));
        let _ = writeln!(page, "| {} | {} |", row.unit, calls(row));
    }
    page += NAMES;
    for row in TABLE {
        let _ = write!(page, "| `{}` ", row.field);
        let _ = write!(page, "| {} ", or_place(row.python()));
        let _ = write!(page, "| {} ", quoted(&row.c()));
        let _ = write!(page, "| `{}` ", row.cpp());
        let _ = writeln!(page, "| {} | {} |", flag(row), wire(row));
    }
    page += MODES;
    for (mode, meaning) in Mode::ALL {
        let name = mode.name();
        let constant = name.to_uppercase().replace('-', "_");
        let _ = writeln!(page, "| `{name}` | `TAUT_MODE_{constant}` | {meaning} |");
    }
    page
}

fn introduction() -> String {
    format!(
        "# Options of a request

Made from `ipc/src/option_table.rs` by `{COMMAND}`; tests hold every language to it.

A request names a robot, a scene and a path; these options say the rest. An option that is not named has its
default.

| option | meaning | default | valid | unit | asked by |
|---|---|---|---|---|---|
"
    )
}

const NAMES: &str = "
## What each language calls them

In Rust they are the fields of `taut_ipc::planner::Request`, by the names of the first column. In C they are fields of
`taut_options` (0 or NULL is the default), in C++ setters of `taut::options`, in Python keywords of `Planner.shorten`,
`Planner.check` and `Planner.watch`, on the command line flags of `taut shorten` and `taut check`. `--weights` says by
a word which weights the metric has: those of the problem (`metric`), metres of `reach`, or `ones`.

| option | Python | C | C++ | command line | wire |
|---|---|---|---|---|---|
";

const MODES: &str = "
## Modes

| mode | C and C++ | meaning |
|---|---|---|
";

fn valid(row: &Row) -> String {
    match row.kind {
        Kind::Flag => "on, off".to_owned(),
        Kind::Named | Kind::Numbers if row.valid().is_empty() => "finite".to_owned(),
        _ => row.valid(),
    }
}

fn calls(row: &Row) -> &'static str {
    match row.asked {
        Asked::Shorten => "shorten",
        Asked::Check => "shorten, check",
        Asked::Watch => "shorten, check, watch",
    }
}

fn or_place(name: Result<String, &str>) -> String {
    match name {
        Ok(name) => format!("`{name}`"),
        Err(place) => format!("`{place}`"),
    }
}

fn quoted(names: &str) -> String {
    let names: Vec<String> = names
        .split(' ')
        .map(|name| format!("`{name}`"))
        .collect();
    names.join(", ")
}

fn flag(row: &Row) -> String {
    match row.flag() {
        Ok(flag) if row.kind == Kind::Flag => format!("`--{flag}`"),
        Ok(flag) => format!("`--{flag} {}`", row.metavar()),
        Err(place) => place.to_owned(),
    }
}

fn wire(row: &Row) -> String {
    match row.wire {
        Wire::Field(field) => format!("field `{field}`"),
        Wire::Bit(bit) => format!("bit {bit} of `flags`"),
        Wire::Section(sections) => {
            format!("section {}", quoted(&sections.replace(',', "")))
        }
    }
}
