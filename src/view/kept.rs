//! What a path keeps besides clearance, as the page draws it: where a point or a direction may be, and
//! what is read of each constraint along the path.

use serde::Serialize;
use taut::constraint::{Constraint, ConstraintError, Stand, Vector, Watched, constraints};
use taut::files::ResultFile;
use taut::robot::{ConfigurationSpace, Kinematics, RobotModel};
use taut::scene::Scene;
use taut::validation::NamedRequirement;

use super::region::{edges, solid};
use super::shapes::{Meshes, Solid};

/// Places of a path at which constraints are read, about.
const LOOKS: usize = 600;
/// Constraints that are drawn.
const MOST: usize = 32;

/// What is drawn of constraints.
#[derive(Default, Serialize)]
pub(super) struct Kept {
    /// Places of the path before: segment and ratio.
    before: Vec<Place>,
    /// Places of the path.
    after: Vec<Place>,
    constraints: Vec<Drawn>,
}

/// A segment and the ratio on it.
type Place = (usize, f64);

#[derive(Serialize)]
struct Drawn {
    name: String,
    /// Of `allowed`, `before` and `after`.
    unit: &'static str,
    /// What is watched of a link; `None` of a joint.
    sight: Option<Seen>,
    /// Whether what is read is what is left of the tolerance, and not what is used of it.
    is_left: bool,
    /// What may be read: as it is asked for, and then as it is raised, where it is.
    allowed: Vec<f64>,
    /// What is read at each place of the path before.
    before: Vec<f64>,
    /// The same of the path.
    after: Vec<f64>,
}

#[derive(Serialize)]
struct Seen {
    /// The link that carries it; `None` = the world.
    link: Option<String>,
    /// The link that sees it; `None` = the world.
    seen_from: Option<String>,
    /// The point, in the frame of `link` (m).
    point: Option<[f64; 3]>,
    /// The direction, in the frame of `link`.
    direction: Option<[f64; 3]>,
    /// Where the point may be, in the frame of `seen_from`.
    solids: Vec<Solid>,
    /// Closed edges of where the direction may point, on the unit sphere of `seen_from`.
    edges: Vec<Vec<[f64; 3]>>,
}

impl Kept {
    /// Draws what a result keeps; what cannot be drawn is said.
    pub(super) fn of(
        result: &ResultFile,
        robot: &RobotModel,
        scene: &Scene,
        space: &ConfigurationSpace,
        held: &[f64],
    ) -> (Self, Option<String>) {
        match asked(result, robot, scene, held) {
            Ok(all) => {
                let mut walk = Walk::new(robot, space, held);
                (walk.draw(result, &all), too_many(all.len()))
            }
            Err(error) => (Self::default(), Some(format!("not drawn: {error}"))),
        }
    }
}

/// The constraints of a result, with directions as they are where its path starts.
fn asked(
    result: &ResultFile,
    robot: &RobotModel,
    scene: &Scene,
    held: &[f64],
) -> Result<Vec<Constraint>, ConstraintError> {
    let text = result.path_constraints.clone();
    let text = match result.path_before.first() {
        Some(first) => text.started(robot, scene, first, held)?,
        None => text,
    };
    constraints(&text, robot, scene)
}

fn too_many(count: usize) -> Option<String> {
    (count > MOST).then(|| format!("{MOST} of {count} constraints are drawn"))
}

/// A robot that walks along paths.
struct Walk<'a> {
    robot: &'a RobotModel,
    space: &'a ConfigurationSpace,
    held: &'a [f64],
    kinematics: Kinematics,
}

impl<'a> Walk<'a> {
    fn new(robot: &'a RobotModel, space: &'a ConfigurationSpace, held: &'a [f64]) -> Self {
        Self {
            robot,
            space,
            held,
            kinematics: Kinematics::default(),
        }
    }

    fn draw(&mut self, result: &ResultFile, all: &[Constraint]) -> Kept {
        if all.is_empty() {
            return Kept::default();
        }
        let before = places(&result.path_before);
        let after = places(&result.path);
        let drawn = all.iter().take(MOST);
        let mut drawn: Vec<Drawn> = drawn
            .map(|constraint| Drawn::of(constraint, result, self.robot))
            .collect();
        let all = &all[..drawn.len()];
        self.read(&result.path_before, &before, all, |index, read| {
            drawn[index].before.push(read);
        });
        self.read(&result.path, &after, all, |index, read| {
            drawn[index].after.push(read);
        });
        Kept {
            before,
            after,
            constraints: drawn,
        }
    }

    /// Reads every constraint at every place.
    fn read(
        &mut self,
        rows: &[Vec<f64>],
        places: &[Place],
        all: &[Constraint],
        mut tell: impl FnMut(usize, f64),
    ) {
        let still = vec![0.0; self.space.nv()];
        for &(segment, t) in places {
            let to = (segment + 1).min(rows.len() - 1);
            let configuration = self.space.between(&rows[segment], &rows[to], t);
            self.kinematics
                .update(self.robot, &configuration, self.held);
            let stand = Stand {
                kinematics: &self.kinematics,
                configuration: &configuration,
                velocity: &still,
            };
            for (index, constraint) in all.iter().enumerate() {
                tell(index, reading(constraint, &stand));
            }
        }
    }
}

/// Places of a path that show it well: all waypoints, and some in between.
fn places(rows: &[Vec<f64>]) -> Vec<Place> {
    let segments = rows.len().saturating_sub(1);
    let looks = (LOOKS / segments.max(1)).clamp(1, 100);
    let inner = (0..segments)
        .flat_map(|segment| (0..looks).map(move |look| (segment, look as f64 / looks as f64)));
    let last = match segments {
        0 => (0, 0.0),
        count => (count - 1, 1.0),
    };
    inner.chain([last]).collect()
}

fn reading(constraint: &Constraint, stand: &Stand) -> f64 {
    let held = &constraint.held;
    let left = held.left(held.watched.at(stand));
    held.reading(left)
        .map_or(left, |(used, _)| used)
}

impl Drawn {
    fn of(constraint: &Constraint, result: &ResultFile, robot: &RobotModel) -> Self {
        let named = NamedRequirement::constraint(constraint);
        let reading = constraint.held.reading(0.0);
        let asked = reading.map_or(0.0, |(_, allowed)| allowed);
        let raised = raised(result, &named).map(|raised| match reading {
            Some(_) => asked + raised,
            None => asked - raised,
        });
        Self {
            name: constraint.name.clone(),
            unit: named.unit.name(),
            sight: Seen::of(constraint, robot),
            is_left: reading.is_none(),
            allowed: [Some(asked), raised]
                .into_iter()
                .flatten()
                .collect(),
            before: Vec::new(),
            after: Vec::new(),
        }
    }
}

/// By how much a tolerance is raised.
fn raised(result: &ResultFile, named: &NamedRequirement) -> Option<f64> {
    let mut lowered = result.floors_lowered.iter();
    lowered
        .find(|lowered| lowered.requirement == *named)
        .map(|lowered| -lowered.floor)
}

impl Seen {
    fn of(constraint: &Constraint, robot: &RobotModel) -> Option<Self> {
        let watched = &constraint.held.watched;
        let regions = &constraint.held.regions;
        let (point, direction) = match watched.vector() {
            Vector::Point(point) => (Some(point.to_array()), None),
            Vector::Direction(direction) => (None, Some(direction.to_array())),
            Vector::Joint(_) => return None,
        };
        let [link, seen_from] = names(watched, robot);
        // No region is a mesh.
        let mut meshes = Meshes::default();
        Some(Self {
            link,
            seen_from,
            point,
            direction,
            solids: regions
                .iter()
                .filter_map(|region| solid(region, &mut meshes))
                .collect(),
            edges: regions.iter().flat_map(edges).collect(),
        })
    }
}

fn names(watched: &Watched, robot: &RobotModel) -> [Option<String>; 2] {
    [watched.link(), watched.seen_from()].map(|link| Some(robot.links()[link?].name.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_read_at_every_waypoint_and_often_enough_between() {
        let rows = |count: usize| vec![vec![0.0]; count];
        assert_eq!(places(&rows(1)), [(0, 0.0)]);
        let two = places(&rows(2));
        assert_eq!((two.len(), two[0], two[100]), (101, (0, 0.0), (0, 1.0)));
        let many = places(&rows(5000));
        assert_eq!(many.len(), 5000);
        assert_eq!(many[4999], (4998, 1.0));
        assert!(
            places(&rows(20))
                .windows(2)
                .all(|pair| pair[0] < pair[1])
        );
    }
}
