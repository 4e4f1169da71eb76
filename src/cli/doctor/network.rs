//! Gateways of other machines, as taut-zenoh sees them.

use std::process::Command;

use taut_ipc::own_daemon::find_program;

use super::check::{Check, Verdict};

/// What stands before a line of `taut-zenoh doctor`.
const VERDICTS: [(&str, Verdict); 3] = [
    ("OK", Verdict::Ok),
    ("WARN", Verdict::Warn),
    ("FAIL", Verdict::Fail),
];

/// A check for each gateway that these endpoints lead to.
pub(super) fn look(endpoints: &[String]) -> Vec<Check> {
    let Some(program) = find_program("taut-zenoh") else {
        let seen = "taut-zenoh is not installed; `cargo install --path ipc/zenoh`";
        return vec![check(Verdict::Fail, seen)];
    };
    let mut command = Command::new(program);
    command.arg("doctor");
    for endpoint in endpoints {
        command.args(["--connect", endpoint]);
    }
    match command.output() {
        Ok(output) if output.stdout.is_empty() => {
            vec![check(Verdict::Fail, last_line(&output.stderr))]
        }
        Ok(output) => checks(&output.stdout),
        Err(error) => vec![check(Verdict::Fail, format!("taut-zenoh: {error}"))],
    }
}

fn checks(output: &[u8]) -> Vec<Check> {
    let text = String::from_utf8_lossy(output);
    text.lines().map(of_line).collect()
}

fn of_line(line: &str) -> Check {
    let (word, seen) = line
        .split_once(char::is_whitespace)
        .unwrap_or((line, ""));
    let known = VERDICTS.iter().find(|(name, _)| *name == word);
    match known {
        Some((_, verdict)) => check(*verdict, seen.trim_start()),
        None => check(Verdict::Fail, line),
    }
}

fn last_line(output: &[u8]) -> String {
    let text = String::from_utf8_lossy(output);
    let line = text.lines().last();
    line.unwrap_or("taut-zenoh said nothing")
        .to_owned()
}

fn check(verdict: Verdict, seen: impl Into<String>) -> Check {
    Check {
        what: "network",
        verdict,
        seen: seen.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_checks() {
        let found = checks(b"OK    cell: taut 0.1.0\nFAIL  no gateway\nodd\n");
        let verdicts: Vec<_> = found
            .iter()
            .map(|check| check.verdict)
            .collect();
        assert_eq!(verdicts, [Verdict::Ok, Verdict::Fail, Verdict::Fail]);
        assert_eq!(found[0].seen, "cell: taut 0.1.0");
    }
}
