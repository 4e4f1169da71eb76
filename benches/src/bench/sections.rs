//! What a set amounts to, for people.

use std::fmt::Write;

use super::grid::Grid;
use super::mode_summary::ModeSummary;
use super::moment::{AGAINST_ANY, AGAINST_BEST};
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

    /// Names of the budgets and of the end.
    fn budgets(&self) -> impl Iterator<Item = String> {
        let budgets = self
            .report
            .budgets_s
            .iter()
            .map(|budget| budget_name(*budget));
        budgets.chain(["end".to_owned()])
    }

    fn lengths(&self, text: &mut String) {
        let mut grid = Grid::new("<>");
        let budgets = self
            .budgets()
            .flat_map(|budget| [budget, "mean".to_owned()]);
        let head = ["remaining length: median, mean", "proved", "first", "cpu"].map(str::to_owned);
        grid.line(head.into_iter().chain(budgets));
        for (mode, figures) in self.modes() {
            let at = figures.ratio_at.iter().map(|at| (at.median, at.mean));
            let at = at.chain([(figures.ratio, figures.ratio_mean)]);
            let first = figures.first_improvement_s.map_or("-".to_owned(), time);
            let proved = format!("{}/{}", figures.valid, figures.answers);
            let cells =
                at.flat_map(|(median, mean)| [format!("{median:.3}"), format!("{mean:.3}")]);
            grid.line(
                [mode.to_owned(), proved, first, time(figures.cpu_s)]
                    .into_iter()
                    .chain(cells),
            );
        }
        grid.write("  ", text);
    }

    fn above(&self, text: &mut String) {
        let mut grid = Grid::new("<>");
        let budgets = self
            .budgets()
            .flat_map(|budget| [budget, "paths".to_owned()]);
        grid.line(
            ["above the best other mode: of medians, of paths %".to_owned()]
                .into_iter()
                .chain(budgets),
        );
        for (mode, figures) in self.modes() {
            let percent =
                |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:+.1}"));
            let above = figures.above_other_modes.iter();
            let cells = above
                .flat_map(|above| [percent(above.medians_percent), percent(above.paths_percent)]);
            grid.line([mode.to_owned()].into_iter().chain(cells));
        }
        section(&grid, text);
    }

    fn shortened(&self, text: &mut String) {
        let mut grid = Grid::new("<>");
        grid.line(["shortened by, of those proved", "proved", "median", "mean"]);
        for (mode, figures) in self.modes() {
            let percent = |remains: f64| format!("{:.1} %", 100.0 * (1.0 - remains));
            let Some(ratio) = figures.ratio_proved else {
                continue;
            };
            let proved = format!("{}/{}", figures.valid, figures.answers);
            grid.line([
                mode.to_owned(),
                proved,
                percent(ratio.median),
                percent(ratio.mean),
            ]);
        }
        section(&grid, text);
    }

    fn best(&self, text: &mut String) {
        let mut grid = Grid::new("<<>><>");
        grid.line([
            "ours ÷ best honest peer of each path",
            "",
            "median",
            "worst",
            "",
            "won",
            "tied",
            "lost",
        ]);
        for (mode, figures) in self.modes() {
            for moment in AGAINST_BEST {
                let Some(versus) = figures.over_best_honest_peer.get(moment.name()) else {
                    continue;
                };
                let worst = &versus.worst;
                let Tally { wins, ties, losses } = versus.tally;
                let name = if moment == AGAINST_BEST[0] { mode } else { "" };
                let figures = [
                    format!("{:.3}", versus.median),
                    format!("{:.3}", worst.value),
                    worst.problem.clone(),
                ];
                let counts = [wins, ties, losses].map(|count| count.to_string());
                grid.line(
                    [name.to_owned(), moment.text().to_owned()]
                        .into_iter()
                        .chain(figures)
                        .chain(counts),
                );
            }
        }
        if self.summary.best_honest_peer.is_some() {
            section(&grid, text);
        }
    }

    fn peers(&self, text: &mut String) {
        let Summary {
            peers,
            best_honest_peer,
            ..
        } = self.summary;
        if peers.is_empty() && best_honest_peer.is_none() {
            return;
        }
        let mut grid = Grid::new("<>");
        let modes = self
            .modes()
            .flat_map(|(mode, _)| [mode.to_owned(), String::new()]);
        let moments = self
            .modes()
            .flat_map(|_| AGAINST_ANY.map(|moment| moment.text().to_owned()));
        grid.line(
            ["ours against peers: won/tied/lost", "", "", "", ""]
                .map(str::to_owned)
                .into_iter()
                .chain(modes),
        );
        grid.line(
            ["peer", "honest", "median", "mean", "cpu"]
                .map(str::to_owned)
                .into_iter()
                .chain(moments),
        );
        let best = best_honest_peer
            .iter()
            .map(|best| ("best honest peer of each path", best));
        for (name, peer) in peers
            .iter()
            .map(|(name, peer)| (name.as_str(), peer))
            .chain(best)
        {
            grid.line(self.peer(name, peer));
        }
        section(&grid, text);
    }

    fn peer(&self, name: &str, peer: &PeerSummary) -> Vec<String> {
        let honest = format!("{}/{}", peer.valid, peer.answers);
        let mut cells = vec![
            name.to_owned(),
            honest,
            format!("{:.3}", peer.ratio),
            format!("{:.3}", peer.ratio_mean),
            time(peer.cpu_s),
        ];
        for (mode, _) in self.modes() {
            cells.extend(AGAINST_ANY.map(|moment| {
                let tally = peer.ours.get(mode).and_then(|ours| ours.get(moment.name()));
                tally.map_or(String::new(), |Tally { wins, ties, losses }| {
                    format!("{wins}/{ties}/{losses}")
                })
            }));
        }
        cells
    }

    fn meshes(&self, text: &mut String) {
        let Some(meshes) = &self.summary.mesh_check else {
            return;
        };
        let mut grid = Grid::new("<>");
        grid.line(["colliding with the exact meshes", "paths", "of", "%"]);
        let recorded = meshes
            .recorded
            .iter()
            .map(|(name, share)| (format!("recorded: {name}"), share));
        let ours = meshes
            .ours
            .iter()
            .map(|(mode, share)| (format!("ours, proved: {mode}"), share));
        for (name, share) in recorded.chain(ours) {
            let percent = format!(
                "{:.1}",
                100.0 * share.collide as f64 / share.of.max(1) as f64
            );
            grid.line([
                name,
                share.collide.to_string(),
                share.of.to_string(),
                percent,
            ]);
        }
        section(&grid, text);
    }

    fn idle(&self, text: &mut String) {
        let mut grid = Grid::new("<>>>><");
        grid.line([
            "travel of coordinates that need not move [rad, m]",
            "paths",
            "before",
            "after",
            "worst",
            "",
        ]);
        let mut any = false;
        for (mode, figures) in self.modes() {
            let Some(idle) = &figures.idle else { continue };
            any = true;
            let figures =
                [idle.before, idle.after, idle.worst.value].map(|travel| format!("{travel:.3}"));
            let counted = [mode.to_owned(), idle.paths.to_string()]
                .into_iter()
                .chain(figures);
            grid.line(counted.chain([idle.worst.problem.clone()]));
        }
        if any {
            section(&grid, text);
        }
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
