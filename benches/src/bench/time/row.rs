//! What was measured of one problem.

use serde::Serialize;
use taut::validation::LoweredFloor;

use crate::units::{length, time};

/// One problem; times are medians of CPU time (s), durations exact (s).
#[derive(Debug, Serialize)]
pub(crate) struct Row {
    /// Folder of the problem.
    pub set: String,
    /// File name without its ending.
    pub name: String,
    /// Why nothing was measured.
    pub error: Option<String>,
    /// What was measured.
    #[serde(flatten)]
    pub figures: Option<Figures>,
}

/// What was measured of one trajectory.
#[derive(Debug, Serialize)]
pub(crate) struct Figures {
    /// Which of the robot's models was taken.
    pub geometry: &'static str,
    /// Columns of the path.
    pub columns: usize,
    /// Waypoints of the shortened path.
    pub waypoints: usize,
    /// Points of the trajectory.
    pub points: usize,
    /// Its duration.
    pub duration_s: f64,
    /// The least time that the motors need, whatever stands around.
    pub bound_s: f64,
    /// Duration over bound, ...
    pub ratio: f64,
    /// ... and with a stop at each waypoint.
    pub stops_ratio: f64,
    /// What the trajectory comes of.
    pub stage: &'static str,
    /// Until the first trajectory was proved.
    pub first_cpu_s: f64,
    /// Until the end.
    pub cpu_s: f64,
    /// To prove the shortened path at its floors.
    pub path_proof_s: f64,
    /// To prove the trajectory at its floors.
    pub proof_s: f64,
    /// Distance that every pair keeps (m); `None` where nothing is near.
    pub clearance_m: Option<f64>,
    /// Floors that had to be lowered.
    pub floors_lowered: Vec<LoweredFloor>,
    /// The largest part of a velocity limit on the executed curve, ...
    pub velocity_part: f64,
    /// ... and of an acceleration limit.
    pub acceleration_part: f64,
    /// How far its positions are outside of their limits, beyond what the path is (m or rad).
    pub outside: f64,
    /// Both ends are the path's, to the last bit, at rest.
    pub rests_at_ends: bool,
    /// The reference checker verifies its certificate.
    pub verified: bool,
}

impl Row {
    /// Set and name.
    pub(super) fn label(&self) -> String {
        format!("{}/{}", self.set, self.name)
    }

    /// For people.
    pub(super) fn line(&self) -> String {
        let label = self.label();
        match (&self.figures, &self.error) {
            (Some(figures), _) => format!("{label:<36} {}", figures.cells()),
            (None, error) => format!("{label:<36} {}", error.as_deref().unwrap_or_default()),
        }
    }
}

impl Figures {
    /// Proof of the trajectory over proof of its path.
    pub(super) fn proof_ratio(&self) -> f64 {
        self.proof_s / self.path_proof_s
    }

    fn cells(&self) -> String {
        let keeps = self
            .clearance_m
            .map_or("far".to_owned(), length);
        let lowered = self.floors_lowered.iter();
        let lowered: String = lowered
            .map(|lowered| format!("; {} {}", lowered.requirement, length(lowered.floor)))
            .collect();
        format!(
            "{:<7} {:>8.4} {:>7.4} {:>6.3} {:>6.3}  {:<9} {:>8} {:>8} {:>8} {:>6.2}  {:.7} {:.7}  {keeps}{lowered}{}",
            self.geometry,
            self.duration_s,
            self.bound_s,
            self.ratio,
            self.stops_ratio,
            self.stage,
            time(self.first_cpu_s),
            time(self.cpu_s),
            time(self.proof_s),
            self.proof_ratio(),
            self.velocity_part,
            self.acceleration_part,
            self.objections(),
        )
    }

    /// What must not be.
    fn objections(&self) -> String {
        let mut said = String::new();
        for (is_so, text) in [
            (!self.rests_at_ends, "; ENDS ARE NOT THE PATH'S AT REST"),
            (!self.verified, "; CERTIFICATE REFUSED"),
            (self.outside > 1e-9, "; OUTSIDE OF POSITION LIMITS"),
        ] {
            if is_so {
                said.push_str(text);
            }
        }
        said
    }
}
