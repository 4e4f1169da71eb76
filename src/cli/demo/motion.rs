//! Where a robot is along a path: its outline, and the track of its tool.

use taut::math::Vec3;
use taut::robot::{Kinematics, RobotModel};

use super::view::View;
use crate::cli::svg::Point;

/// Places drawn of each segment of a path; between waypoints a tool moves on curves.
pub(super) const STEPS: usize = 24;

/// A robot that can be put anywhere.
pub(super) struct Mover<'a> {
    robot: &'a RobotModel,
    held: Vec<f64>,
    kinematics: Kinematics,
    /// Links at the ends of the tree.
    tips: Vec<usize>,
}

/// The track of the tool along a path.
pub(super) struct Track {
    /// Places close to each other.
    pub(super) places: Vec<Vec3>,
    /// Places at the waypoints.
    pub(super) waypoints: Vec<Vec3>,
}

impl<'a> Mover<'a> {
    /// A robot, nowhere yet.
    pub(super) fn new(robot: &'a RobotModel) -> Self {
        Self {
            robot,
            held: robot
                .held()
                .iter()
                .map(|held| held.default)
                .collect(),
            kinematics: Kinematics::default(),
            tips: tips(robot),
        }
    }

    /// Puts it at a configuration.
    pub(super) fn place(&mut self, row: &[f64]) {
        self.kinematics
            .update(self.robot, row, &self.held);
    }

    /// Outlines of its shapes, seen in a direction.
    pub(super) fn outlines(&self, view: View) -> Vec<Vec<Point>> {
        let links = self
            .robot
            .links()
            .iter()
            .zip(self.kinematics.poses());
        links
            .flat_map(|(link, at)| {
                link.shapes
                    .iter()
                    .map(move |shape| view.outline(at, shape))
            })
            .collect()
    }

    /// Number of its solid shapes: the fewer, the more often it can be drawn.
    pub(super) fn shapes(&self) -> usize {
        self.robot
            .links()
            .iter()
            .map(|link| link.shapes.len())
            .sum()
    }

    /// The middle of what the last links carry: between the fingers of a gripper.
    fn tool(&self) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut count = 0.0;
        for place in self
            .tips
            .iter()
            .flat_map(|tip| self.carried(*tip))
        {
            sum += place;
            count += 1.0;
        }
        match self.tips.last() {
            Some(&tip) if count == 0.0 => self.kinematics.poses()[tip].translation,
            _ => sum / count,
        }
    }

    /// Where the shapes of a link are.
    fn carried(&self, link: usize) -> impl Iterator<Item = Vec3> {
        let pose = self.kinematics.poses()[link];
        let shapes = self.robot.links()[link].shapes.iter();
        shapes.map(move |shape| (pose * shape.pose).translation)
    }

    /// The tool's track along a path of rows laid end to end.
    pub(super) fn track(&mut self, rows: &[f64]) -> Track {
        let mut track = Track {
            places: Vec::new(),
            waypoints: Vec::new(),
        };
        self.along(rows, STEPS, &mut |mover, step| {
            let tool = mover.tool();
            track.places.push(tool);
            if step == 0 {
                track.waypoints.push(tool);
            }
        });
        track
    }

    /// Puts it at `steps` places of each segment, the first at its start, and at the end of the
    /// path.
    pub(super) fn along(
        &mut self,
        rows: &[f64],
        steps: usize,
        visit: &mut dyn FnMut(&Self, usize),
    ) {
        let rows: Vec<&[f64]> = rows
            .chunks_exact(self.robot.space().nq())
            .collect();
        for pair in rows.windows(2) {
            self.along_segment(pair[0], pair[1], steps, visit);
        }
        if let Some(last) = rows.last() {
            self.place(last);
            visit(self, 0);
        }
    }

    /// Puts it at `steps` places of one segment, the first at its start.
    fn along_segment(
        &mut self,
        from: &[f64],
        to: &[f64],
        steps: usize,
        visit: &mut dyn FnMut(&Self, usize),
    ) {
        for step in 0..steps {
            let ratio = step as f64 / steps as f64;
            self.place(&self.robot.space().between(from, to, ratio));
            visit(self, step);
        }
    }
}

/// The links that no joint hangs from.
fn tips(robot: &RobotModel) -> Vec<usize> {
    let parents: Vec<Option<usize>> = robot
        .joints()
        .iter()
        .map(|joint| joint.parent)
        .collect();
    let links = 0..robot.links().len();
    links
        .filter(|link| !parents.contains(&Some(*link)))
        .collect()
}
