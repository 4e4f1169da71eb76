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

#[cfg(test)]
mod tests {
    use super::super::tests::{robot, scene};
    use super::*;

    /// The direction that a text's reference comes to, at (turn, slide, wrist).
    fn started(text: &str, first: [f64; 3]) -> [f64; 3] {
        let file = ConstraintsFile::parse(text).unwrap();
        let file = file
            .started(&robot(), &scene(), &first, &[])
            .unwrap();
        let value: serde_json::Value = serde_json::from_str(&file.text()).unwrap();
        let reference = value["orientation_constraints"][0]["reference"].clone();
        serde_json::from_value(reference).unwrap()
    }

    fn assert_near(found: [f64; 3], expected: [f64; 3]) {
        let difference = Vec3::from_array(found) - Vec3::from_array(expected);
        assert!(
            difference.length() < 1e-12,
            "{found:?}, expected {expected:?}"
        );
    }

    #[test]
    fn a_start_is_where_the_axis_points_then_as_the_frame_sees_it() {
        let (sin, cos) = 0.3_f64.sin_cos();
        // The wrist turns about x: z leans towards -y.
        assert_near(
            started("upright hand:z=0.1@start", [0.0, 0.0, 0.3]),
            [0.0, -sin, cos],
        );
        let in_turned = r#"{"orientation_constraints": [{"link_name": "cup", "header": {"frame_id": "turned"},
            "axis": [0, 0, 1], "reference": "start", "tolerance_rad": 0.1}]}"#;
        assert_near(started(in_turned, [1.0, 0.2, 0.3]), [0.0, -sin, cos]);
        let up = "upright hand:z=0.1";
        assert_near(started(up, [1.0, 0.2, 0.3]), [0.0, 0.0, 1.0]);
    }
}
