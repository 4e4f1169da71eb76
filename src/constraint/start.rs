//! Directions that are to stay as a path starts.

use super::ConstraintError;
use super::place::Place;
use super::words::{ConstraintsFile, Moment, OrientationFile, Reference, TiltFile};
use crate::math::{Quat, Vec3};
use crate::robot::{Kinematics, RobotModel};
use crate::scene::Scene;
use crate::scene::words::Point;

impl ConstraintsFile {
    /// The same with directions in the place of "start": those that links have at the path's first
    /// waypoint, with the held joints where they are.
    ///
    /// # Errors
    /// Such a constraint names a frame that is none.
    pub fn started(
        mut self,
        robot: &RobotModel,
        scene: &Scene,
        first: &[f64],
        held: &[f64],
    ) -> Result<Self, ConstraintError> {
        if !self
            .orientation_constraints
            .iter()
            .any(of_start)
        {
            return Ok(self);
        }
        let mut kinematics = Kinematics::default();
        kinematics.update(robot, first, held);
        let start = Start {
            robot,
            scene,
            kinematics: &kinematics,
        };
        let name = &self.name;
        for orientation in &mut self.orientation_constraints {
            if let OrientationFile::Tilt(tilt) = orientation
                && let Reference::Of(Moment::Start) = tilt.reference
            {
                tilt.reference = Reference::Along(Point(start.direction(name, tilt)?.to_array()));
            }
        }
        Ok(self)
    }
}

fn of_start(orientation: &OrientationFile) -> bool {
    match orientation {
        OrientationFile::Tilt(tilt) => tilt.reference == Reference::Of(Moment::Start),
        OrientationFile::Euler(_) => false,
    }
}

struct Start<'a> {
    robot: &'a RobotModel,
    scene: &'a Scene,
    kinematics: &'a Kinematics,
}

impl Start<'_> {
    /// A constraint's axis as its frame sees it.
    fn direction(&self, name: &str, tilt: &TiltFile) -> Result<Vec3, ConstraintError> {
        let axis = Vec3::from_array(tilt.axis.0);
        let turned = self.turned(name, &tilt.link_name)? * axis;
        Ok(self
            .turned(name, &tilt.header.frame_id)?
            .inverse()
            * turned)
    }

    /// How a frame is turned in the world.
    fn turned(&self, constraint: &str, frame: &str) -> Result<Quat, ConstraintError> {
        let place = Place::named(self.robot, self.scene, constraint, frame)?;
        let own = place.pose.rotation;
        Ok(match place.link {
            None => own,
            Some(link) => self.kinematics.poses()[link].rotation * own,
        })
    }
}
