//! The table of options, made into a [`Request`] and into rows that other languages read.

use super::PlannerError;
use crate::time::deadline_after;
use crate::wire::{Code, Mode, RequestFlags, RequestHeader};
use std::time::Duration;

/// One option, as every language has it.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its field of [`Request`].
    pub field: &'static str,
    /// What kind of value it takes.
    pub kind: Kind,
    doc: &'static str,
    /// What a request gets that does not name it.
    pub default: Default,
    /// Which numbers are valid.
    pub range: Range,
    /// Unit of its numbers, or empty.
    pub unit: &'static str,
    /// Which calls ask for it.
    pub asked: Asked,
    /// Where it lies on the wire.
    pub wire: Wire,
    python: Name,
    c: Name,
    cpp: Name,
    flag: Name,
    metavar: &'static str,
    take: fn(&mut Request, Value) -> Option<()>,
}

/// Kinds of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Yes or no.
    Flag,
    /// A whole number of at most this many bits.
    Count(u32),
    /// A length in metres.
    Metres,
    /// A time.
    Seconds,
    /// A [`Mode`], by its name.
    Mode,
    /// A name.
    Name,
    /// A text: constraints, or what times are asked for.
    Text,
    /// Names.
    Names,
    /// Numbers, each with its name.
    Named,
    /// Numbers.
    Numbers,
    /// Whole numbers from 0.
    Indices,
}

/// A value of one of the [kinds](Kind).
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Of [`Kind::Flag`].
    Flag(bool),
    /// Of [`Kind::Count`].
    Count(u64),
    /// Of [`Kind::Metres`].
    Metres(f64),
    /// Of [`Kind::Seconds`].
    Seconds(Duration),
    /// Of [`Kind::Mode`].
    Mode(Mode),
    /// Of [`Kind::Name`].
    Name(String),
    /// Of [`Kind::Text`].
    Text(String),
    /// Of [`Kind::Names`].
    Names(Vec<String>),
    /// Of [`Kind::Named`].
    Named(Vec<(String, f64)>),
    /// Of [`Kind::Numbers`].
    Numbers(Vec<f64>),
    /// Of [`Kind::Indices`].
    Indices(Vec<usize>),
}

/// What a request gets that does not name an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Default {
    /// This value, which can be given too.
    Is(&'static str),
    /// No value (0 where it is a number), which means this.
    Unset(&'static str),
}

/// Which numbers are valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// All that the kind has.
    Any,
    /// Those above 0.
    Positive,
}

impl Range {
    fn has(self, number: f64) -> bool {
        match self {
            Self::Any => true,
            Self::Positive => number.is_finite() && number > 0.0,
        }
    }
}

/// Which calls ask for an option; each asks for those of the ones behind it too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Asked {
    /// Shortening only.
    Shorten,
    /// And a check.
    Check,
    /// And a watch.
    Watch,
}

/// Where an option lies on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wire {
    /// In this field of the header.
    Field(&'static str),
    /// In this bit of the header's flags.
    Bit(u32),
    /// In these sections.
    Section(&'static str),
}

/// What a language calls an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Name {
    /// As the field, by the language's custom.
    Usual,
    /// This.
    Is(&'static str),
    /// It is not called an option there; what asks for it.
    Elsewhere(&'static str),
}

impl Name {
    fn or(self, usual: impl Fn() -> String) -> Result<String, &'static str> {
        match self {
            Self::Usual => Ok(usual()),
            Self::Is(name) => Ok(name.to_owned()),
            Self::Elsewhere(place) => Err(place),
        }
    }
}

impl Row {
    /// What it means, without a full stop.
    pub fn doc(&self) -> &'static str {
        self.doc.trim()
    }

    /// The same of what is given where it is not as usual: of a flag that is set unless it is
    /// denied, of its contrary.
    pub fn given_doc(&self) -> String {
        let doc = self.doc();
        match self.is_on() {
            true => format!("Do not {}{}", doc[..1].to_lowercase(), &doc[1..]),
            false => doc.to_owned(),
        }
    }

    /// Its keyword in Python; else what asks for it there.
    ///
    /// # Errors
    /// It is no keyword.
    pub fn python(&self) -> Result<String, &'static str> {
        self.python.or(|| self.field.to_owned())
    }

    /// Its fields in C, one space between.
    pub fn c(&self) -> String {
        self.c
            .or(|| self.negated("without_"))
            .unwrap_or_default()
    }

    /// Its setter in C++.
    pub fn cpp(&self) -> String {
        self.cpp
            .or(|| self.field.to_owned())
            .unwrap_or_default()
    }

    /// Its flag on the command line, without `--`; else what asks for it there.
    ///
    /// # Errors
    /// It is no flag.
    pub fn flag(&self) -> Result<String, &'static str> {
        self.flag
            .or(|| self.negated("no_").replace('_', "-"))
    }

    /// What the command line calls its value; empty for a flag.
    pub fn metavar(&self) -> String {
        match self.kind {
            Kind::Flag => String::new(),
            Kind::Named if self.metavar.is_empty() => "NAME=VALUE".to_owned(),
            _ if self.metavar.is_empty() => self.flag().unwrap_or_default().to_uppercase(),
            _ => self.metavar.to_owned(),
        }
    }

    /// Whether it is a flag that is set unless it is denied.
    pub fn is_on(&self) -> bool {
        self.kind == Kind::Flag && self.default == Default::Is("on")
    }

    /// The default, in words.
    pub fn default_text(&self) -> &'static str {
        match self.default {
            Default::Is(text) | Default::Unset(text) => text,
        }
    }

    /// The valid values, in words.
    pub fn valid(&self) -> String {
        match (self.kind, self.range) {
            (_, Range::Positive) => "more than 0".to_owned(),
            (Kind::Count(32), _) => format!("0 to {}", u32::MAX),
            (Kind::Mode, _) => Mode::ALL
                .iter()
                .map(|(mode, _)| mode.name())
                .collect::<Vec<_>>()
                .join(", "),
            (Kind::Count(_) | Kind::Seconds, _) => "0 or more".to_owned(),
            _ => String::new(),
        }
    }

    /// Enters a value into a request.
    ///
    /// # Errors
    /// A value of another kind, or too large a number.
    pub fn set(&self, request: &mut Request, value: Value) -> Result<(), PlannerError> {
        let told = format!("{} is {value:?}; valid: {}", self.field, self.valid());
        (self.take)(request, value).ok_or_else(|| refused(told))
    }

    fn negated(&self, no: &str) -> String {
        format!("{}{}", if self.is_on() { no } else { "" }, self.field)
    }

    fn check(&self, number: Option<f64>) -> Result<(), PlannerError> {
        match number {
            Some(number) if !self.range.has(number) => Err(refused(format!(
                "a {} of {number} {}; valid: {}",
                self.cpp(),
                self.unit,
                self.valid()
            ))),
            _ => Ok(()),
        }
    }
}

fn refused(message: String) -> PlannerError {
    PlannerError::invalid(Code::MalformedRequest, message)
}

/// A row as far as it is as usual.
const USUAL: Row = Row {
    field: "",
    kind: Kind::Flag,
    doc: "",
    default: Default::Unset(""),
    range: Range::Any,
    unit: "",
    asked: Asked::Shorten,
    wire: Wire::Section(""),
    python: Name::Usual,
    c: Name::Usual,
    cpp: Name::Usual,
    flag: Name::Usual,
    metavar: "",
    take: |_, _| None,
};

/// A type of an option's field.
trait Taken: Sized {
    const KIND: Kind;

    fn take(value: Value) -> Option<Self>;
}

macro_rules! taken {
    ($( $type:ty = $kind:expr, $pattern:pat => $taken:expr; )*) => {
        $(
            impl Taken for $type {
                const KIND: Kind = $kind;

                fn take(value: Value) -> Option<Self> {
                    match value {
                        $pattern => $taken,
                        _ => None,
                    }
                }
            }
        )*
    };
}

taken! {
    bool = Kind::Flag, Value::Flag(is_set) => Some(is_set);
    u32 = Kind::Count(32), Value::Count(count) => count.try_into().ok();
    u64 = Kind::Count(64), Value::Count(count) => Some(count);
    Option<f64> = Kind::Metres, Value::Metres(metres) => Some(Some(metres));
    Option<Duration> = Kind::Seconds, Value::Seconds(time) => Some(Some(time));
    Mode = Kind::Mode, Value::Mode(mode) => Some(mode);
    Option<String> = Kind::Name, Value::Name(name) => Some(Some(name));
    String = Kind::Text, Value::Text(text) => Some(text);
    Vec<String> = Kind::Names, Value::Names(names) => Some(names);
    Vec<(String, f64)> = Kind::Named, Value::Named(named) => Some(named);
    Vec<f64> = Kind::Numbers, Value::Numbers(numbers) => Some(numbers);
    Vec<usize> = Kind::Indices, Value::Indices(indices) => Some(indices);
}

/// A type of an option that lies in a field of the header.
trait InHeader {
    type Field;

    /// What the header holds, 0 where there is no value.
    fn in_header(&self) -> Self::Field;

    /// The number whose range is checked.
    fn number(&self) -> Option<f64> {
        None
    }
}

impl InHeader for u32 {
    type Field = u32;

    fn in_header(&self) -> u32 {
        *self
    }
}

impl InHeader for u64 {
    type Field = u64;

    fn in_header(&self) -> u64 {
        *self
    }
}

impl InHeader for Mode {
    type Field = u32;

    fn in_header(&self) -> u32 {
        (*self).into()
    }
}

impl InHeader for Option<Duration> {
    type Field = u64;

    fn in_header(&self) -> u64 {
        self.map_or(0, |time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX))
    }

    fn number(&self) -> Option<f64> {
        self.map(|time| time.as_secs_f64())
    }
}

impl InHeader for Option<f64> {
    type Field = f64;

    fn in_header(&self) -> f64 {
        self.unwrap_or(0.0)
    }

    fn number(&self) -> Option<f64> {
        *self
    }
}

macro_rules! request {
    (
        scalars { $(
            $(#[doc = $scalar_doc:literal])+
            $scalar:ident: $scalar_type:ty = $scalar_default:expr, $field:ident { $($scalar_row:tt)* };
        )* }
        flags { $(
            $(#[doc = $flag_doc:literal])+
            $flag:ident = $flag_default:literal, $bit:literal $bit_name:ident { $($flag_row:tt)* };
        )* }
        sections { $(
            $(#[doc = $list_doc:literal])+
            $list:ident: $list_type:ty, $section:literal { $($list_row:tt)* };
        )* }
    ) => {
        /// What is asked about a path. [`Request::new`] has what a request means that says nothing
        /// more; `docs/options.md` lists the options with their defaults and units.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Request {
            /// Label of the robot.
            pub robot: String,
            /// Hash of the robot that is meant; 0 = the one that the label names.
            pub robot_hash: u64,
            /// Label of the scene; `None` = nothing around the robot.
            pub scene: Option<String>,
            /// Hash of the scene that is meant; 0 = the one that the label names.
            pub scene_hash: u64,
            $( $(#[doc = $scalar_doc])+ #[doc = "."] pub $scalar: $scalar_type, )*
            $( $(#[doc = $flag_doc])+ #[doc = "."] pub $flag: bool, )*
            $( $(#[doc = $list_doc])+ #[doc = "."] pub $list: $list_type, )*
        }

        impl Request {
            /// A request to shorten a path of this robot in this scene.
            pub fn new(robot: &str, scene: Option<&str>) -> Self {
                Self {
                    robot: robot.to_owned(),
                    robot_hash: 0,
                    scene: scene.map(str::to_owned),
                    scene_hash: 0,
                    $( $scalar: $scalar_default, )*
                    $( $flag: $flag_default, )*
                    $( $list: std::default::Default::default(), )*
                }
            }

            /// Enters the options that lie in the header.
            ///
            /// # Errors
            /// A number out of its range.
            pub(super) fn enter(&self, header: &mut RequestHeader) -> Result<(), PlannerError> {
                $(
                    row(stringify!($scalar)).check(self.$scalar.number())?;
                    header.$field = self.$scalar.in_header();
                )*
                // How long an option says, when the wire: what waits must not lengthen it.
                header.deadline_ns = self.deadline.map_or(0, deadline_after);
                $(
                    if self.$flag != $flag_default {
                        header.flags |= RequestFlags::$bit_name;
                    }
                )*
                Ok(())
            }
        }

        /// Every option.
        pub const TABLE: &[Row] = &[
            $( Row {
                field: stringify!($scalar),
                kind: <$scalar_type as Taken>::KIND,
                doc: concat!($($scalar_doc),+),
                wire: Wire::Field(stringify!($field)),
                take: |request, value| {
                    request.$scalar = Taken::take(value)?;
                    Some(())
                },
                $($scalar_row)*
                ..USUAL
            }, )*
            $( Row {
                field: stringify!($flag),
                doc: concat!($($flag_doc),+),
                default: Default::Is(if $flag_default { "on" } else { "off" }),
                wire: Wire::Bit($bit),
                take: |request, value| {
                    request.$flag = Taken::take(value)?;
                    Some(())
                },
                $($flag_row)*
                ..USUAL
            }, )*
            $( Row {
                field: stringify!($list),
                kind: <$list_type as Taken>::KIND,
                doc: concat!($($list_doc),+),
                wire: Wire::Section($section),
                take: |request, value| {
                    request.$list = Taken::take(value)?;
                    Some(())
                },
                $($list_row)*
                ..USUAL
            }, )*
        ];
    };
}

option_table!(request);

/// The row of a field of [`Request`].
///
/// # Panics
/// On a name that is none.
pub fn row(field: &str) -> &'static Row {
    let found = TABLE.iter().find(|row| row.field == field);
    found.unwrap_or_else(|| panic!("{field} is no option"))
}
