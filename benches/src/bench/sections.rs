//! What a set amounts to, for people.

use std::fmt::Write;

use super::grid::Grid;
use super::meshes::Share;
use super::mode_summary::{IdleSummary, ModeSummary, Versus};
use super::moment::{AGAINST_ANY, AGAINST_BEST, Moment};
use super::peer_summary::PeerSummary;
use super::report::Report;
use super::summary::Summary;
use crate::statistics::Tally;
use crate::units::time;

/// One set of a report.
pub(super) struct Sections<'a> {
    /// What the figures mean.
    pub report: &'a Report,
    /// The figures.
    pub summary: &'a Summary,
}

impl Sections<'_> {
    /// Writes all sections that there is something to say in.
    pub(super) fn write(&self, text: &mut String) {
        let Summary {
            set,
            problems,
            lower_bound,
            modes,
            ..
        } = self.summary;
        let bound = lower_bound.map_or(String::new(), |bound| format!(", lower bound {bound:.3}"));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n━━ {set}: {problems} problems{bound}");
        if modes.is_empty() {
            return;
        }
        self.lengths(text);
        if self.report.modes.len() > 1 {
            self.above(text);
        }
        if self.report.from.is_some() {
            self.shortened(text);
        }
        self.best(text);
        self.peers(text);
        self.meshes(text);
        self.idle(text);
    }

    /// Names of the budgets and of the end, each with another name behind it.
    fn budgets(&self, second: &'static str) -> impl Iterator<Item = String> {
        let budgets = self
            .report
            .budgets_s
            .iter()
            .copied()
            .map(budget_name);
        budgets
            .chain(["end".to_owned()])
            .flat_map(move |budget| [budget, second.to_owned()])
    }

    fn lengths(&self, text: &mut String) {
        let mut grid = Grid::new("<>");
        let head = ["remaining length: median, mean", "proved", "first", "cpu"].map(str::to_owned);
        grid.line(head.into_iter().chain(self.budgets("mean")));
        for (mode, figures) in self.modes() {
            let first = figures
                .first_improvement_s
                .map_or("-".to_owned(), time);
            let cells = [mode.to_owned(), proved(figures), first, time(figures.cpu_s)];
            grid.line(cells.into_iter().chain(lengths(figures)));
        }
        grid.write("  ", text);
    }

    fn above(&self, text: &mut String) {
        let mut grid = Grid::new("<>");
        let head = "above the best other mode: of medians, of paths %".to_owned();
        grid.line([head].into_iter().chain(self.budgets("paths")));
        for (mode, figures) in self.modes() {
            let above = figures.above_other_modes.iter();
            let cells = above.flat_map(|above| [above.medians_percent, above.paths_percent]);
            grid.line(
                [mode.to_owned()]
                    .into_iter()
                    .chain(cells.map(percent)),
            );
        }
        section(&grid, text);
    }

    fn shortened(&self, text: &mut String) {
        let mut grid = Grid::new("<>");
        grid.line(["shortened by, of those proved", "proved", "median", "mean"]);
        for (mode, figures) in self.modes() {
            let saved = |remains: f64| format!("{:.1} %", 100.0 * (1.0 - remains));
            let Some(ratio) = figures.ratio_proved else {
                continue;
            };
            let cells = [ratio.median, ratio.mean].map(saved);
            grid.line(
                [mode.to_owned(), proved(figures)]
                    .into_iter()
                    .chain(cells),
            );
        }
        section(&grid, text);
    }

    fn best(&self, text: &mut String) {
        if self.summary.best_honest_peer.is_none() {
            return;
        }
        let mut grid = Grid::new("<<>><>");
        let head = "ours ÷ best honest peer of each path";
        grid.line([head, "", "median", "worst", "", "won", "tied", "lost"]);
        for (mode, figures) in self.modes() {
            let mut name = mode;
            for moment in AGAINST_BEST {
                let Some(versus) = figures.over_best_honest_peer.get(moment.name()) else {
                    continue;
                };
                let names = [name.to_owned(), moment.text().to_owned()];
                grid.line(names.into_iter().chain(over_best(versus)));
                name = "";
            }
        }
        section(&grid, text);
    }

    fn peers(&self, text: &mut String) {
        let peers = &self.summary.peers;
        let best = &self.summary.best_honest_peer;
        if peers.is_empty() && best.is_none() {
            return;
        }
        let mut grid = Grid::new("<>");
        self.head_of_peers(&mut grid);
        for (name, peer) in peers {
            grid.line(self.peer(name, peer));
        }
        if let Some(best) = best {
            grid.line(self.peer("best honest peer of each path", best));
        }
        section(&grid, text);
    }

    /// A line of modes above a line of moments.
    fn head_of_peers(&self, grid: &mut Grid) {
        let owned = |cells: [&str; 5]| cells.map(str::to_owned).into_iter();
        let modes = self
            .modes()
            .flat_map(|(mode, _)| [mode.to_owned(), String::new()]);
        let moments = self
            .modes()
            .flat_map(|_| AGAINST_ANY.map(|moment| moment.text().to_owned()));
        let head = owned(["ours against peers: won/tied/lost", "", "", "", ""]);
        grid.line(head.chain(modes));
        grid.line(owned(["peer", "honest", "median", "mean", "cpu"]).chain(moments));
    }

    fn peer(&self, name: &str, peer: &PeerSummary) -> Vec<String> {
        let mut cells = vec![
            name.to_owned(),
            format!("{}/{}", peer.valid, peer.answers),
            format!("{:.3}", peer.ratio),
            format!("{:.3}", peer.ratio_mean),
            time(peer.cpu_s),
        ];
        for (mode, _) in self.modes() {
            cells.extend(AGAINST_ANY.map(|moment| against(peer, mode, moment)));
        }
        cells
    }

    fn meshes(&self, text: &mut String) {
        let Some(meshes) = &self.summary.mesh_check else {
            return;
        };
        let mut grid = Grid::new("<>");
        grid.line(["colliding with the exact meshes", "paths", "of", "%"]);
        for (name, share) in &meshes.recorded {
            grid.line(colliding(format!("recorded: {name}"), share));
        }
        for (mode, share) in &meshes.ours {
            grid.line(colliding(format!("ours, proved: {mode}"), share));
        }
        section(&grid, text);
    }

    fn idle(&self, text: &mut String) {
        let mut grid = Grid::new("<>>>><");
        let head = "travel of coordinates that need not move [rad, m]";
        grid.line([head, "paths", "before", "after", "worst", ""]);
        let idle = |(mode, figures): (&'static str, &'_ ModeSummary)| {
            Some(travel(mode, figures.idle.as_ref()?))
        };
        let lines: Vec<[String; 6]> = self.modes().filter_map(idle).collect();
        if lines.is_empty() {
            return;
        }
        for line in lines {
            grid.line(line);
        }
        section(&grid, text);
    }

    /// Modes with figures, in the order asked for.
    fn modes(&self) -> impl Iterator<Item = (&'static str, &ModeSummary)> {
        let summaries = &self.summary.modes;
        self.report
            .modes
            .iter()
            .filter_map(|mode| Some((*mode, summaries.get(mode)?)))
    }
}

/// How many of how many.
fn proved(figures: &ModeSummary) -> String {
    format!("{}/{}", figures.valid, figures.answers)
}

/// Median and mean at each budget and at the end.
fn lengths(figures: &ModeSummary) -> impl Iterator<Item = String> {
    let at = figures
        .ratio_at
        .iter()
        .flat_map(|at| [at.median, at.mean]);
    let at = at.chain([figures.ratio, figures.ratio_mean]);
    at.map(|length| format!("{length:.3}"))
}

fn percent(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:+.1}"))
}

/// Median, worst and where, and who won how often.
fn over_best(versus: &Versus) -> [String; 6] {
    let Tally { wins, ties, losses } = versus.tally;
    [
        format!("{:.3}", versus.median),
        format!("{:.3}", versus.worst.value),
        versus.worst.problem.clone(),
        wins.to_string(),
        ties.to_string(),
        losses.to_string(),
    ]
}

fn against(peer: &PeerSummary, mode: &str, moment: Moment) -> String {
    let tally = peer
        .ours
        .get(mode)
        .and_then(|ours| ours.get(moment.name()));
    tally.map_or(String::new(), |Tally { wins, ties, losses }| {
        format!("{wins}/{ties}/{losses}")
    })
}

fn colliding(name: String, share: &Share) -> [String; 4] {
    [
        name,
        share.collide.to_string(),
        share.of.to_string(),
        format!("{:.1}", share.percent()),
    ]
}

fn travel(mode: &str, idle: &IdleSummary) -> [String; 6] {
    let travel = |travel: f64| format!("{travel:.3}");
    [
        mode.to_owned(),
        idle.paths.to_string(),
        travel(idle.before),
        travel(idle.after),
        travel(idle.worst.value),
        idle.worst.problem.clone(),
    ]
}

fn section(grid: &Grid, text: &mut String) {
    text.push('\n');
    grid.write("  ", text);
}

/// `0.15 ms`, without digits that say nothing.
fn budget_name(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{} ms", round(seconds * 1e3))
    } else {
        format!("{} s", round(seconds))
    }
}

fn round(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
