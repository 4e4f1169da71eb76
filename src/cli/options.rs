//! The table of options as flags.

use clap::builder::{PossibleValuesParser, RangedU64ValueParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Command, FromArgMatches};
use taut_ipc::limits::MAX_WAYPOINTS;
use taut_ipc::planner::options::{Asked, Default, Kind, Range, Row, TABLE, Value};
use taut_ipc::planner::{PlannerError, Request};
use taut_ipc::wire::Mode;

use super::quantity;

/// The options of a request that were given; with `CHECK`, of those that a check has.
#[derive(Clone)]
pub(super) struct Options<const CHECK: bool>(Vec<(&'static Row, Value)>);

/// What the flags of a check are called on the command line of this program, but for these.
pub(super) fn flags_of_a_check(but: &[&str]) -> Vec<&'static str> {
    let rows = rows(true).map(|row| row.field);
    rows.filter(|field| !but.contains(field))
        .collect()
}

fn rows(check: bool) -> impl Iterator<Item = &'static Row> {
    let asked = if check { Asked::Check } else { Asked::Shorten };
    TABLE
        .iter()
        .filter(move |row| row.asked >= asked && row.flag().is_ok())
}

impl<const CHECK: bool> Options<CHECK> {
    /// Enters them into a request.
    ///
    /// # Errors
    /// A value that the table does not have.
    pub(super) fn enter(&self, request: &mut Request) -> Result<(), PlannerError> {
        self.0
            .iter()
            .try_for_each(|(row, value)| row.set(request, value.clone()))
    }
}

impl<const CHECK: bool> FromArgMatches for Options<CHECK> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |row: &'static Row| Some((row, value(row, matches)?));
        Ok(Self(rows(CHECK).filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<const CHECK: bool> clap::Args for Options<CHECK> {
    fn augment_args(command: Command) -> Command {
        // Real numbers have no turns to keep.
        let goal = ArgGroup::new("goal").args(["unwrapped", "keep_goal"]);
        command
            .args(rows(CHECK).map(argument))
            .group(goal)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

fn argument(row: &'static Row) -> Arg {
    let flag = row.flag().unwrap_or_default();
    let argument = Arg::new(row.field).long(flag).help(help(row));
    match row.kind {
        Kind::Flag => argument.action(ArgAction::SetTrue),
        Kind::Named => with_value(argument, row).action(ArgAction::Append),
        _ => with_value(argument, row).action(ArgAction::Set),
    }
}

fn with_value(argument: Arg, row: &'static Row) -> Arg {
    let argument = argument
        .value_name(row.metavar())
        .value_parser(parser(row));
    match row.default {
        Default::Is(value) => argument.default_value(value),
        Default::Unset(_) => argument,
    }
}

fn help(row: &Row) -> String {
    let doc = row.given_doc();
    match row.kind {
        Kind::Metres => format!("{doc}: 0.1mm, 1cm, or metres"),
        Kind::Seconds => format!("{doc}: 20ms, 1.5s"),
        Kind::Named => format!("{doc}{}; repeatable", unit(row)),
        Kind::Indices => format!("{doc}: 0,3,7-9"),
        _ => doc,
    }
}

fn unit(row: &Row) -> String {
    match row.unit {
        "" => String::new(),
        unit => format!(" ({unit})"),
    }
}

fn parser(row: &'static Row) -> ValueParser {
    match row.kind {
        Kind::Count(bits) => count(row, bits),
        Kind::Metres => ValueParser::new(quantity::metres),
        Kind::Seconds => ValueParser::new(quantity::duration),
        Kind::Mode => modes(),
        Kind::Named if row.range == Range::Positive => ValueParser::new(quantity::weight),
        Kind::Named => ValueParser::new(quantity::value),
        Kind::Indices => ValueParser::new(quantity::numbers),
        Kind::Flag | Kind::Name | Kind::Names | Kind::Numbers | Kind::Text => ValueParser::string(),
    }
}

/// Numbers of so many bits.
fn count(row: &Row, bits: u32) -> ValueParser {
    let least = match row.default {
        Default::Is(_) => 0,
        // 0 says on the wire that it is not given.
        Default::Unset(_) => 1,
    };
    RangedU64ValueParser::<u64>::new()
        .range(least..=u64::MAX >> (64 - bits))
        .into()
}

fn modes() -> ValueParser {
    let names = Mode::ALL.iter().map(|(mode, _)| mode.name());
    let parser = PossibleValuesParser::new(names);
    ValueParser::new(parser.map(|name: String| Mode::named(&name).unwrap_or(Mode::Hybrid)))
}

/// What was given for an option, or is its default.
fn value(row: &Row, matches: &ArgMatches) -> Option<Value> {
    let name = row.field;
    match row.kind {
        Kind::Flag => matches
            .get_flag(name)
            .then_some(Value::Flag(!row.is_on())),
        Kind::Count(_) => one(matches, name).map(Value::Count),
        Kind::Metres => one(matches, name).map(Value::Metres),
        Kind::Seconds => one(matches, name).map(Value::Seconds),
        Kind::Mode => one(matches, name).map(Value::Mode),
        Kind::Name => one(matches, name).map(Value::Name),
        Kind::Named => matches
            .get_many(name)
            .map(|named| Value::Named(named.cloned().collect())),
        Kind::Indices => one(matches, name).map(|given| Value::Indices(indices(given))),
        // No flag has several words or numbers; texts have flags of their own.
        Kind::Names | Kind::Numbers | Kind::Text => None,
    }
}

fn one<T: Clone + Send + Sync + 'static>(matches: &ArgMatches, name: &str) -> Option<T> {
    matches.get_one::<T>(name).cloned()
}

/// The numbers of the ranges. Of one beyond every path, as many as show that it is.
fn indices(given: quantity::Numbers) -> Vec<usize> {
    let numbers = |range: std::ops::RangeInclusive<usize>| range.take(MAX_WAYPOINTS + 1);
    given.into_iter().flat_map(numbers).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use crate::cli::Cli;

    /// Flags of `shorten` and `check` that are no options of a request, but about files, places and
    /// output, or choose among the commands of `check`.
    const OTHER: [&str; 30] = [
        "acceleration",
        "against",
        "certificate",
        "controller",
        "count",
        "format",
        "geometry",
        "help",
        "instance",
        "keep",
        "keep-upright",
        "limits",
        "local",
        "out",
        "package",
        "path-constraints",
        "problem",
        "robot",
        "scene",
        "select",
        "speed",
        "srdf",
        "start-velocity",
        "time",
        "time-clearance",
        "timed",
        "version",
        "watch",
        "weights",
        "write-certificate",
    ];

    fn flags(command: &str) -> BTreeSet<String> {
        let cli = Cli::command();
        let command = cli.find_subcommand(command).unwrap();
        command
            .get_arguments()
            .filter_map(|argument| argument.get_long().map(str::to_owned))
            .filter(|flag| !OTHER.contains(&flag.as_str()))
            .collect()
    }

    #[test]
    fn the_command_line_has_every_option_of_the_table_and_no_other() {
        for (command, check) in [("shorten", false), ("check", true)] {
            let table: BTreeSet<String> = TABLE
                .iter()
                .filter(|row| !check || row.asked >= Asked::Check)
                .filter_map(|row| row.flag().ok())
                .collect();
            assert_eq!(flags(command), table, "taut {command}");
        }
    }

    #[test]
    fn what_is_given_is_what_is_asked() {
        let words = "taut shorten p.json --priority 3 --scene-version 2 --no-contacts --corridor \
                     --clearance 2mm --fix 0,2-3 --hold lift=0.5 --joint-weight a=2 --group arm \
                     --deadline 20ms --budget 7 --seed 9 --mode contact";
        let matches = Cli::command().get_matches_from(words.split(' '));
        let (_, matches) = matches.subcommand().unwrap();
        let mut request = Request::new("r", None);
        let options = Options::<false>::from_arg_matches(matches).unwrap();
        options.enter(&mut request).unwrap();
        let expected = Request {
            priority: 3,
            scene_version: 2,
            contacts: false,
            corridor: true,
            clearance_m: Some(2e-3),
            fixed_waypoints: vec![0, 2, 3],
            held: vec![("lift".to_owned(), 0.5)],
            joint_weights: vec![("a".to_owned(), 2.0)],
            group: Some("arm".to_owned()),
            deadline: Some(std::time::Duration::from_millis(20)),
            work_budget: 7,
            seed: 9,
            mode: Mode::Contact,
            ..Request::new("r", None)
        };
        assert_eq!(request, expected);
    }

    #[test]
    fn the_table_says_the_work_that_a_request_gets() {
        let said = taut_ipc::planner::options::row("work_budget").default_text();
        let work = taut::optimize::request::DEFAULT_WORK_BUDGET.to_string();
        assert_eq!(said.replace(',', ""), work);
    }
}
