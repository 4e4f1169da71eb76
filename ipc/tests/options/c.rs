//! `ipc/c/src/options_table.rs`: the struct of C and how it is read.

use super::{COMMAND, wrapped};
use taut_ipc::planner::options::{Default, Kind, Row, TABLE};
use taut_ipc::wire::Mode;

pub fn source() -> String {
    [head(), modes(), structure(), default(), reading()].concat()
}

fn head() -> String {
    format!(
        "//! Modes and options, made from the table of options by
//! `{COMMAND}`; do not edit.

use crate::borrow::{{array, maybe_text, texts}};
use crate::values::{{flag, given, mode, named, seconds}};
use std::ffi::c_char;
use std::ptr::null;
use taut_ipc::planner::{{PlannerError, Request}};

"
    )
}

fn comment(text: &str, indent: &str) -> String {
    let before = format!("{indent}/// ");
    wrapped(text, &before, &before, 100)
}

fn modes() -> String {
    let constant = |(mode, meaning): &(Mode, &str)| {
        let name = mode.name().to_uppercase().replace('-', "_");
        comment(&format!("`taut_options.mode`: {meaning}."), "")
            + &format!("pub const TAUT_MODE_{name}: u32 = {};\n", u32::from(*mode))
    };
    Mode::ALL
        .iter()
        .map(constant)
        .collect::<String>()
        + "\n"
}

fn fields(row: &Row) -> Vec<String> {
    row.c().split(' ').map(str::to_owned).collect()
}

fn flags() -> impl Iterator<Item = &'static Row> {
    TABLE
        .iter()
        .filter(|row| row.kind == Kind::Flag)
}

/// Bytes that keep what follows the flags aligned.
fn reserved() -> usize {
    let count = flags().count();
    count.next_multiple_of(8) - count
}

fn last_flag(row: &Row) -> bool {
    flags()
        .last()
        .is_some_and(|last| last.field == row.field)
}

fn types(kind: Kind) -> &'static [&'static str] {
    match kind {
        Kind::Flag => &["u8"],
        Kind::Count(32) | Kind::Mode => &["u32"],
        Kind::Count(_) => &["u64"],
        Kind::Metres | Kind::Seconds => &["f64"],
        Kind::Name | Kind::Text => &["*const c_char"],
        Kind::Names => &["*const *const c_char", "usize"],
        Kind::Named => &["*const *const c_char", "*const f64", "usize"],
        Kind::Numbers => &["*const f64", "usize"],
        Kind::Indices => &["*const usize", "usize"],
    }
}

/// What the first of a row's fields says; the others are told by it.
fn doc(row: &Row) -> String {
    let doc = row.doc();
    let default = row.default_text();
    match (row.kind, row.default) {
        (Kind::Flag, _) => format!("{}: 0 or 1.", row.given_doc()),
        (Kind::Mode, _) => format!("{doc}, one of TAUT_MODE_*."),
        (Kind::Seconds, _) => format!("{doc}, in seconds; 0 = {default}."),
        (Kind::Metres, _) => format!("{doc}, in metres; 0 = {default}."),
        (Kind::Count(_), Default::Is(_)) => format!("{doc}."),
        (Kind::Count(_), _) => format!("{doc}; 0 = {default}."),
        (Kind::Named, _) => format!("{doc}: names, and a number for each; 0 of them = {default}."),
        _ => format!("{doc}; NULL = {default}."),
    }
}

fn structure() -> String {
    let mut text = String::from(
        "/// Options of a request; `taut_options_default` fills them in. Arrays and strings are read during
/// the call that they are given to, and not kept. `docs/options.md` has them in other languages.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Options {
    /// sizeof(taut_options).
    pub size: usize,
",
    );
    for row in TABLE {
        for (index, (field, of)) in fields(row)
            .iter()
            .zip(types(row.kind))
            .enumerate()
        {
            let said = match (index, *of) {
                (0, _) => doc(row),
                (_, "usize") => "How many.".to_owned(),
                _ => "The number of each.".to_owned(),
            };
            text += &comment(&said, "    ");
            text += &format!("    pub {field}: {of},\n");
        }
        if last_flag(row) && reserved() > 0 {
            text += &comment("0; keeps what follows aligned.", "    ");
            text += &format!("    pub reserved: [u8; {}],\n", reserved());
        }
    }
    text + "}\n\n"
}

fn default() -> String {
    let mut text = String::from(
        "/// What a request means that says nothing more.
pub(crate) const DEFAULT: Options = Options {
    size: size_of::<Options>(),
",
    );
    for row in TABLE {
        for (field, of) in fields(row).iter().zip(types(row.kind)) {
            let value = match *of {
                "f64" => "0.0".to_owned(),
                of if of.starts_with('*') => "null()".to_owned(),
                _ if row.kind == Kind::Mode => mode_of(row),
                _ => "0".to_owned(),
            };
            text += &format!("    {field}: {value},\n");
        }
        if last_flag(row) && reserved() > 0 {
            text += &format!("    reserved: [0; {}],\n", reserved());
        }
    }
    text + "};\n\n"
}

fn mode_of(row: &Row) -> String {
    let name = row
        .default_text()
        .to_uppercase()
        .replace('-', "_");
    format!("TAUT_MODE_{name}")
}

fn reading() -> String {
    let scalars = TABLE
        .iter()
        .filter(|row| types(row.kind).len() == 1);
    let scalars = scalars.filter(|row| !matches!(row.kind, Kind::Flag | Kind::Name | Kind::Text));
    let is_section =
        |row: &&Row| types(row.kind).len() > 1 || matches!(row.kind, Kind::Name | Kind::Text);
    let sections = TABLE.iter().filter(is_section);
    let head = "options: &Options, request: &mut Request) -> Result<(), PlannerError> {\n";
    let end = "    Ok(())\n}\n";
    format!(
        "/// Enters the numbers.
pub(crate) fn enter_numbers({head}{}{end}
/// Enters the flags.
pub(crate) fn enter_flags({head}{}{end}
/// Enters the names and arrays.
///
/// # Safety
/// Pointers lead where the header says.
pub(crate) unsafe fn enter_arrays(
    options: &Options,
    request: &mut Request,
) -> Result<(), PlannerError> {{
{}{end}",
        scalars.map(number).collect::<String>(),
        flags().map(flag).collect::<String>(),
        sections.map(section).collect::<String>(),
    )
}

fn number(row: &Row) -> String {
    let field = row.field;
    let c = row.c();
    let value = match row.kind {
        Kind::Seconds => format!("seconds(\"options.{c}\", options.{c})?"),
        Kind::Metres => format!("given(options.{c})"),
        Kind::Mode => format!("mode(options.{c})?"),
        _ => format!("options.{c}"),
    };
    format!("    request.{field} = {value};\n")
}

fn flag(row: &Row) -> String {
    let field = row.field;
    let c = row.c();
    let not = if row.is_on() { "!" } else { "" };
    format!("    request.{field} = {not}flag(\"{c}\", options.{c})?;\n")
}

fn section(row: &Row) -> String {
    let names = fields(row);
    let call = match row.kind {
        Kind::Named => "named",
        Kind::Names => "texts",
        Kind::Name | Kind::Text => "maybe_text",
        _ => "array",
    };
    let copied = match row.kind {
        Kind::Text => ".unwrap_or_default()",
        _ if call == "array" => ".to_vec()",
        _ => "",
    };
    let arguments: String = names
        .iter()
        .map(|name| format!(", options.{name}"))
        .collect();
    format!(
        "    // SAFETY: the caller promises arrays of what it counts.
    let {field} = unsafe {{ {call}(\"options.{}\"{arguments}) }}?;
    request.{field} = {field}{copied};\n",
        names[0],
        field = row.field,
    )
}
