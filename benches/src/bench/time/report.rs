//! All that was measured, and what it amounts to.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::row::{Figures, Row};
use crate::output;
use crate::statistics::{Average, Worst, median};
use crate::units::time;

/// A trajectory within this part of its bound counts as being there.
const AT_BOUND: f64 = 1.01;

/// What others were seen to do, as it was recorded once.
const RECORDED: &str = include_str!("recorded.json");

/// Rows, what they amount to, and what others were seen to do.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    /// One for each problem.
    pub rows: Vec<Row>,
    /// `None` where nothing was measured.
    pub summary: Option<Summary>,
    /// Others, as recorded.
    pub recorded: Recorded,
}

/// What all trajectories amount to.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    /// Trajectories that are proved as they are written.
    pub proved: usize,
    /// Duration over bound.
    pub ratio: Average,
    /// The greatest.
    pub worst: Worst,
    /// Trajectories within 1 % of the bound.
    pub at_bound: usize,
    /// The same ratio with a stop at each waypoint.
    pub stops_ratio: Average,
    /// CPU until the first proved trajectory, by the robot's model (s).
    pub first_cpu_s: Vec<(&'static str, f64)>,
    /// CPU until the end (s).
    pub cpu_s: f64,
    /// Proof of a trajectory over the proof of its path.
    pub proof_ratio: f64,
    /// The greatest.
    pub worst_proof_ratio: Worst,
    /// The largest part of a velocity and of an acceleration limit on any executed curve.
    pub parts: [f64; 2],
    /// Trajectories whose certificates the reference checker verifies.
    pub verified: usize,
    /// Trajectories whose ends are the path's, to the last bit, at rest.
    pub rest_at_ends: usize,
    /// Trajectories with lowered floors.
    pub with_lowered_floors: usize,
}

/// What others were seen to do.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Recorded {
    /// When, on what, and how it was judged.
    pub source: String,
    /// One for each way.
    pub peers: Vec<Peer>,
}

/// One way of timing the same shortened paths.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Peer {
    /// Tool, version, what was asked of it.
    pub method: String,
    /// Trajectories that came of the problems.
    pub ran: usize,
    /// Duration over bound: median, mean and greatest.
    pub ratio: [f64; 3],
    /// Within 1 % of the bound.
    pub at_bound: Option<usize>,
    /// Trajectories that collide.
    pub collide: usize,
    /// Trajectories that exceed a limit by more than 2 %.
    pub beyond_limits: Option<usize>,
}

impl Report {
    pub(super) fn new(rows: Vec<Row>) -> Self {
        let recorded = serde_json::from_str(RECORDED);
        Self {
            summary: Summary::of(&rows),
            recorded: recorded.expect("the file beside this one is of this form"),
            rows,
        }
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.rows.iter().any(|row| row.error.is_some())
    }

    pub(crate) fn json(&self) -> String {
        output::json(self)
    }

    /// For people.
    pub(crate) fn table(&self) -> String {
        let mut text = format!(
            "{:<36} {:<7} {:>8} {:>7} {:>6} {:>6}  {:<9} {:>8} {:>8} {:>8} {:>6}  {:<9} {:<9}  keeps\n",
            "problem",
            "robot",
            "time s",
            "bound s",
            "T/LB",
            "stops",
            "by",
            "first",
            "end",
            "proof",
            "/path",
            "velocity",
            "acceleration"
        );
        for row in &self.rows {
            let _ = writeln!(text, "{}", row.line());
        }
        if let Some(summary) = &self.summary {
            let _ = writeln!(text, "\n{}", summary.text());
        }
        let _ = writeln!(text, "\n{}", self.recorded.text());
        text
    }
}

impl Summary {
    fn of(rows: &[Row]) -> Option<Self> {
        let measured = || {
            rows.iter()
                .filter_map(|row| Some((row, row.figures.as_ref()?)))
        };
        let of = |what: fn(&Figures) -> f64| measured().map(move |(_, figures)| what(figures));
        let count = |what: fn(&Figures) -> bool| {
            measured()
                .filter(|(_, figures)| what(figures))
                .count()
        };
        let worst = |what: fn(&Figures) -> f64| {
            Worst::of(measured().map(|(row, figures)| (what(figures), row.label())))
        };
        let most = |what: fn(&Figures) -> f64| of(what).fold(0.0, f64::max);
        let first = |geometry: &'static str| {
            let of_these = measured().filter(|(_, figures)| figures.geometry == geometry);
            let first = median(of_these.map(|(_, figures)| figures.first_cpu_s))?;
            Some((geometry, first))
        };
        Some(Self {
            proved: measured().count(),
            ratio: Average::of(of(|figures| figures.ratio))?,
            worst: worst(|figures| figures.ratio)?,
            at_bound: count(|figures| figures.ratio <= AT_BOUND),
            stops_ratio: Average::of(of(|figures| figures.stops_ratio))?,
            first_cpu_s: ["spheres", "given"]
                .into_iter()
                .filter_map(first)
                .collect(),
            cpu_s: median(of(|figures| figures.cpu_s))?,
            proof_ratio: median(of(Figures::proof_ratio))?,
            worst_proof_ratio: worst(Figures::proof_ratio)?,
            parts: [
                most(|figures| figures.velocity_part),
                most(|figures| figures.acceleration_part),
            ],
            verified: count(|figures| figures.verified),
            rest_at_ends: count(|figures| figures.rests_at_ends),
            with_lowered_floors: count(|figures| !figures.floors_lowered.is_empty()),
        })
    }

    fn text(&self) -> String {
        let first = self.first_cpu_s.iter();
        let first: Vec<String> = first
            .map(|(geometry, first)| format!("{} ({geometry})", time(*first)))
            .collect();
        format!(
            "{} proved, T/LB median {:.4}, mean {:.4}, at most {:.3} ({}); {} within 1 %; with stops median {:.3}, mean {:.3}\n\
             first answer {}, end {} of CPU in the median; proof {:.2} times its path's in the median, at most {:.2} ({})\n\
             executed: at most {:.7} of a velocity limit, {:.7} of an acceleration limit; {} rest at both ends, bit for bit;\n\
             {} certificates verified; {} with lowered floors",
            self.proved,
            self.ratio.median,
            self.ratio.mean,
            self.worst.value,
            self.worst.problem,
            self.at_bound,
            self.stops_ratio.median,
            self.stops_ratio.mean,
            first.join(", "),
            time(self.cpu_s),
            self.proof_ratio,
            self.worst_proof_ratio.value,
            self.worst_proof_ratio.problem,
            self.parts[0],
            self.parts[1],
            self.rest_at_ends,
            self.verified,
            self.with_lowered_floors,
        )
    }
}

impl Recorded {
    fn text(&self) -> String {
        let mut text = format!("others, recorded: {}\n", self.source);
        let or_none =
            |count: Option<usize>| count.map_or("-".to_owned(), |count| count.to_string());
        let _ = write!(
            text,
            "{:<58} {:>4} {:>23} {:>8} {:>8} {:>8}",
            "way", "ran", "T/LB median, mean, max", "≤ 1.01", "collide", "> limits"
        );
        for peer in &self.peers {
            let [median, mean, most] = peer.ratio;
            let ratio = format!("{median:.3}, {mean:.2}, {most:.2}");
            let _ = write!(
                text,
                "\n{:<58} {:>4} {ratio:>23} {:>8} {:>8} {:>8}",
                peer.method,
                peer.ran,
                or_none(peer.at_bound),
                peer.collide,
                or_none(peer.beyond_limits),
            );
        }
        text
    }
}
