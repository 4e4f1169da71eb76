//! The setters of `ipc/c/include/taut.hpp`.

use super::{with_region, wrapped};
use taut_ipc::planner::options::{Kind, Row, TABLE};

const END: &str = "// (end of the table)";

pub fn header(text: &str) -> String {
    let text = region(text, "// Setters, from the table of options:", setter);
    let text = region(&text, "// Arrays, from the table of options:", given);
    region(
        &text,
        "// Their memory, from the table of options:",
        members,
    )
}

fn region(text: &str, begin: &str, of: impl Fn(&Row) -> String) -> String {
    let made: String = TABLE.iter().map(of).collect();
    with_region(text, begin, END, &made)
}

fn setter(row: &Row) -> String {
    let name = row.cpp();
    let c = row.c();
    let first = c.split(' ').next().unwrap_or_default();
    let (parameters, body) = match row.kind {
        Kind::Flag if row.is_on() => ("bool set", format!("plain.{c} = !set")),
        Kind::Flag => ("bool set", format!("plain.{c} = set")),
        Kind::Count(32) => ("std::uint32_t number", format!("plain.{first} = number")),
        Kind::Count(_) => ("std::uint64_t number", format!("plain.{first} = number")),
        Kind::Mode => ("std::uint32_t mode", format!("plain.{first} = mode")),
        Kind::Metres => ("double metres", format!("plain.{first} = metres")),
        Kind::Seconds => ("double seconds", format!("plain.{first} = seconds")),
        Kind::Name => ("std::string name", format!("{name}_ = std::move(name)")),
        Kind::Text => ("std::string text", format!("{name}_ = std::move(text)")),
        Kind::Names => (
            "std::vector<std::string> names",
            format!("{name}_ = std::move(names)"),
        ),
        Kind::Numbers => (
            "std::vector<double> numbers",
            format!("{name}_ = std::move(numbers)"),
        ),
        Kind::Indices => (
            "std::vector<std::size_t> indices",
            format!("{name}_ = std::move(indices)"),
        ),
        Kind::Named => (
            "std::string name, double value",
            format!("{name}_names_.push_back(std::move(name)), {name}_values_.push_back(value)"),
        ),
    };
    let doc = match row.kind {
        Kind::Mode => format!("{}: TAUT_MODE_*", row.doc()),
        _ => row.doc().to_owned(),
    };
    let head = wrapped(&doc, "    // ", "    // ", 118);
    let line = format!("    options &{name}({parameters}) {{ return {body}, *this; }}\n");
    match line.len() {
        ..=120 => head + &line,
        _ => format!(
            "{head}    options &{name}({parameters}) {{\n        {};\n        return *this;\n    }}\n",
            body.replace(", ", ";\n        ")
        ),
    }
}

/// What of the arrays `taut_options` gets.
fn given(row: &Row) -> String {
    let name = row.cpp();
    let c = row.c();
    let fields: Vec<&str> = c.split(' ').collect();
    let line = |field: &str, value: String| format!("        given.{field} = {value};\n");
    match row.kind {
        Kind::Name | Kind::Text => line(fields[0], format!("{name}_ ? {name}_->c_str() : nullptr")),
        Kind::Names => {
            format!("        const auto {name} = detail::pointers({name}_);\n")
                + &line(fields[0], format!("{name}.data()"))
                + &line(fields[1], format!("{name}.size()"))
        }
        Kind::Named => {
            format!("        const auto {name} = detail::pointers({name}_names_);\n")
                + &line(fields[0], format!("{name}.data()"))
                + &line(fields[1], format!("{name}_values_.data()"))
                + &line(fields[2], format!("{name}.size()"))
        }
        Kind::Numbers | Kind::Indices => {
            line(fields[0], format!("{name}_.data()")) + &line(fields[1], format!("{name}_.size()"))
        }
        _ => String::new(),
    }
}

fn members(row: &Row) -> String {
    let name = row.cpp();
    match row.kind {
        Kind::Name | Kind::Text => format!("    std::optional<std::string> {name}_;\n"),
        Kind::Names => format!("    std::vector<std::string> {name}_;\n"),
        Kind::Named => {
            format!(
                "    std::vector<std::string> {name}_names_;\n    std::vector<double> {name}_values_;\n"
            )
        }
        Kind::Numbers => format!("    std::vector<double> {name}_;\n"),
        Kind::Indices => format!("    std::vector<std::size_t> {name}_;\n"),
        _ => String::new(),
    }
}
