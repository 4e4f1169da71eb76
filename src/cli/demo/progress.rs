//! What the planners are doing, while they do it: a line each on a terminal, else plain lines.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use super::row::{Message, Row};
use crate::cli::report;

/// A line for every planner on standard error.
pub(super) struct Progress {
    /// Empty where standard error is no terminal.
    bars: Vec<ProgressBar>,
}

impl Progress {
    /// One line for each row.
    pub(super) fn new(rows: &[Row]) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self { bars: Vec::new() };
        }
        let all = MultiProgress::new();
        Self {
            bars: rows.iter().map(|row| bar(&all, row)).collect(),
        }
    }

    /// Shows what a planner says; `row` is what was known of it before.
    pub(super) fn tell(&mut self, index: usize, row: &Row, message: &Message) {
        let text = in_words(message);
        match self.bars.get(index) {
            Some(bar) => bar.set_message(text),
            // Improvements would be many lines.
            None if matches!(message, Message::Improved { .. }) => {}
            None => eprintln!("{}: {text}", name(row)),
        }
    }

    /// Takes the lines off the terminal; the table says it all.
    pub(super) fn clear(&self) {
        self.bars
            .iter()
            .for_each(ProgressBar::finish_and_clear);
    }
}

fn name(row: &Row) -> String {
    format!("{}  {}", row.planner, row.problem)
}

fn bar(all: &MultiProgress, row: &Row) -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} {prefix:<14} {msg}");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_spinner());
    let bar = all.add(ProgressBar::new_spinner().with_style(style));
    bar.set_prefix(name(row));
    bar.set_message("planning");
    bar.enable_steady_tick(Duration::from_millis(80));
    bar
}

fn in_words(message: &Message) -> String {
    match message {
        Message::Planned {
            time_s, waypoints, ..
        } => format!("planned {waypoints} waypoints in {}", report::time(*time_s)),
        Message::Improved { length } => format!("length {length:.3}"),
        Message::Answered {
            length_before,
            length_after,
            proved,
            code,
            ..
        } => {
            let verdict = if *proved { "proved" } else { code };
            format!("length {length_before:.3} → {length_after:.3}   {verdict}")
        }
        Message::Failed { error } => error.clone(),
    }
}
