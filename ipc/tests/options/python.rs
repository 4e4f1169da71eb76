//! The keywords of `ipc/python/python/taut/_planner.py`.

use super::{with_region, wrapped};
use taut_ipc::planner::options::{Asked, Default, Kind, Row, TABLE};

/// A method that asks for options.
pub struct Call {
    pub name: &'static str,
    asked: Asked,
}

pub const CALLS: [Call; 3] = [
    Call {
        name: "shorten",
        asked: Asked::Shorten,
    },
    Call {
        name: "check",
        asked: Asked::Check,
    },
    Call {
        name: "watch",
        asked: Asked::Watch,
    },
];

const END: &str = "# (end of the table)";

impl Call {
    pub fn rows(&self) -> impl Iterator<Item = &'static Row> {
        TABLE
            .iter()
            .filter(|row| row.asked >= self.asked && row.python().is_ok())
    }

    fn made(&self, of: impl Fn(&Row, &str) -> String) -> String {
        self.rows()
            .filter_map(|row| Some(of(row, &row.python().ok()?)))
            .collect()
    }
}

pub fn module(text: &str) -> String {
    let mut text = text.to_owned();
    for call in &CALLS {
        let name = call.name;
        let begin = format!("# Keywords of {name}, from the table of options:");
        text = with_region(&text, &begin, END, &call.made(keyword));
        let begin = format!("# Values of {name}, from the table of options:");
        text = with_region(&text, &begin, END, &call.made(value));
    }
    let bullets = CALLS[0].made(bullet);
    with_region(
        &text,
        "        Options, each with its default:\n",
        "Raises",
        &(bullets + "\n"),
    )
}

fn keyword(row: &Row, name: &str) -> String {
    let (of, default) = match row.kind {
        Kind::Flag if row.is_on() => ("bool", "True"),
        Kind::Flag => ("bool", "False"),
        Kind::Count(_) => ("int", "0"),
        Kind::Metres | Kind::Seconds => ("Optional[float]", "None"),
        Kind::Mode => ("str", row.default_text()),
        Kind::Name => ("Optional[str]", "None"),
        Kind::Text => return format!("        {name}: Optional[{}] = None,\n", class(name)),
        Kind::Names => ("Optional[Sequence[str]]", "None"),
        Kind::Named => ("Optional[Mapping[str, float]]", "None"),
        Kind::Numbers => ("Optional[Sequence[float]]", "None"),
        Kind::Indices => ("Sequence[int]", "()"),
    };
    match row.kind {
        Kind::Mode => format!("        {name}: {of} = \"{default}\",\n"),
        _ => format!("        {name}: {of} = {default},\n"),
    }
}

/// The class of a text that is made of more than a text.
fn class(name: &str) -> String {
    format!("{}{}", name[..1].to_uppercase(), &name[1..])
}

fn value(row: &Row, name: &str) -> String {
    let field = row.field;
    let value = match row.kind {
        Kind::Names => format!("_names({name})"),
        Kind::Text => format!("{name}_text({name})"),
        Kind::Named => format!("_pairs({name})"),
        Kind::Numbers => format!("_numbers({name})"),
        Kind::Indices => format!("[_index(number) for number in {name}]"),
        _ => name.to_owned(),
    };
    format!("            \"{field}\": {value},\n")
}

fn bullet(row: &Row, name: &str) -> String {
    let unit = match (row.kind, row.unit) {
        (Kind::Flag, _) | (_, "") => String::new(),
        (_, unit) => format!(", in {unit}"),
    };
    let valid = match row.kind {
        Kind::Mode => format!(": {}", row.valid()),
        _ => String::new(),
    };
    let default = match (row.kind, row.default) {
        (Kind::Flag, _) if row.is_on() => "True",
        (Kind::Flag, _) => "False",
        (_, Default::Is(text) | Default::Unset(text)) => text,
    };
    let text = format!("`{name}`: {}{unit}{valid} ({default}).", row.doc());
    wrapped(&text, "        * ", "          ", 120)
}
