//! Which bodies are checked against each other, and where in the kinematic tree they part.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::body::{Body, BodyKind};
use super::error::CollisionModelError;
use super::frames::check_frames;
use crate::robot::{JointKind, RobotModel, kinematics};
use crate::scene::Scene;
use crate::solid::TOUCHING_M;
use crate::solid::cover::Ball;

/// Two bodies that are checked against each other. `a` moves with the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyPair {
    /// First body.
    pub a: usize,
    /// Second body.
    pub b: usize,
    /// Nearest link that carries both; `None` is the world.
    pub ancestor: Option<usize>,
    /// How many motions of each body's chain act at or above the ancestor.
    pub motions_above: [usize; 2],
}

/// The pairs of a model.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    /// Those that some joint moves against each other.
    pub moving: Arc<[BodyPair]>,
    /// Those that no joint moves, but that may overlap as they stand.
    pub standing: Arc<[BodyPair]>,
    /// Of the moving, those with a mesh, in which the other body may be hidden.
    pub hollow: Arc<[usize]>,
    /// Of the standing, those that are not far apart for good.
    pub close: Vec<usize>,
}

impl Pairs {
    fn new(
        robot: &RobotModel,
        bodies: &[Body],
        moving: Vec<BodyPair>,
        standing: Vec<BodyPair>,
    ) -> Self {
        let is_hollow =
            |pair: &BodyPair| bodies[pair.a].solid.hollow || bodies[pair.b].solid.hollow;
        let hollow = (0..moving.len())
            .filter(|&index| is_hollow(&moving[index]))
            .collect();
        let pairs = Self {
            moving: moving.into(),
            standing: standing.into(),
            hollow,
            close: Vec::new(),
        };
        pairs.placed(robot, bodies)
    }

    /// Memory that they take (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.moving)
            + size_of_val(&*self.standing)
            + size_of_val(&*self.hollow)
            + size_of_val(&*self.close)
    }

    /// The same pairs of bodies that may stand elsewhere. Finds those that each request looks at:
    /// of a thousand objects far away it should not hear.
    pub fn placed(&self, robot: &RobotModel, bodies: &[Body]) -> Self {
        let balls: Vec<_> = bodies
            .iter()
            .map(|body| fixed_ball(robot, body))
            .collect();
        let is_close = |pair: &BodyPair| match (&balls[pair.a], &balls[pair.b]) {
            (Some(a), Some(b)) => a.center.distance(b.center) <= a.radius + b.radius + TOUCHING_M,
            _ => true,
        };
        let close = (0..self.standing.len())
            .filter(|&index| is_close(&self.standing[index]))
            .collect();
        Self {
            close,
            ..self.clone()
        }
    }
}

/// Ball in the world around a body that no joint of any kind carries.
fn fixed_ball(robot: &RobotModel, body: &Body) -> Option<Ball> {
    let mut ball = body.ball();
    let mut at = body.link;
    while let Some(link) = at {
        let joint = &robot.joints()[link];
        if joint.kind != JointKind::Fixed {
            return None;
        }
        ball.center = joint.origin.transform_point(ball.center);
        at = joint.parent;
    }
    Some(ball)
}

/// What the scene says about pairs of links and objects, the names that it mentions as numbers.
pub struct Rules<'a> {
    robot: &'a RobotModel,
    scene: &'a Scene,
    numbers: HashMap<&'a str, u32>,
    allowed: HashSet<(u32, u32)>,
    forbidden: HashSet<(u32, u32)>,
}

impl<'a> Rules<'a> {
    /// The rules of a scene for a robot.
    ///
    /// # Errors
    /// A pair, padding, touch link or attachment that names neither a link nor an object.
    pub fn new(robot: &'a RobotModel, scene: &'a Scene) -> Result<Self, CollisionModelError> {
        check_frames(robot, scene)?;
        let allowed = HashSet::new();
        let forbidden = HashSet::new();
        let mut rules = Self {
            robot,
            scene,
            numbers: HashMap::new(),
            allowed,
            forbidden,
        };
        for (a, b) in scene.allowed() {
            let pair = rules.pair(a, b, || format!("allows {a} × {b}"))?;
            rules.allowed.insert(pair);
        }
        for attached in scene.attached() {
            let id = &attached.object.id;
            if robot.link_index(&attached.link_name).is_none() {
                return Err(rules.unknown_link(id, &attached.link_name));
            }
            for name in attached
                .touch_links
                .iter()
                .chain([&attached.link_name])
            {
                let pair = rules.pair(id, name, || format!("lets {id} touch {name}"))?;
                rules.allowed.insert(pair);
            }
        }
        for (a, b) in scene.forbidden() {
            let pair = rules.pair(a, b, || format!("forbids {a} × {b}"))?;
            rules.forbidden.insert(pair);
        }
        for (name, _) in scene.padded() {
            rules.pair(name, name, || format!("pads {name}"))?;
        }
        for (name, _) in scene.scaled() {
            rules.pair(name, name, || format!("scales {name}"))?;
        }
        Ok(rules)
    }

    fn pair(
        &mut self,
        a: &'a str,
        b: &'a str,
        what: impl Fn() -> String,
    ) -> Result<(u32, u32), CollisionModelError> {
        let mut number = |name: &'a str, beside: &str| {
            if self.robot.link_index(name).is_none() && self.scene.object(name).is_none() {
                return Err(CollisionModelError::UnknownName {
                    what: what(),
                    name: name.to_owned(),
                    beside: beside.to_owned(),
                    links: self.link_names(),
                    objects: self.object_names(),
                });
            }
            let next = self.numbers.len() as u32;
            Ok(*self.numbers.entry(name).or_insert(next))
        };
        Ok(sorted(number(a, b)?, number(b, a)?))
    }

    fn unknown_link(&self, object: &str, link: &str) -> CollisionModelError {
        let object = object.to_owned();
        let link = link.to_owned();
        let links = self.link_names();
        CollisionModelError::UnknownLink {
            object,
            link,
            links,
        }
    }

    fn link_names(&self) -> String {
        self.robot
            .links()
            .iter()
            .map(|link| link.name.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    }

    fn object_names(&self) -> String {
        let names: Vec<_> = self
            .scene
            .objects()
            .map(|object| object.id.as_str())
            .collect();
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        }
    }

    /// The pairs among `bodies`. The first of them are the links' and what they carry: each is
    /// checked against every other of these, and against obstacles, which are the bodies from
    /// `obstacles` on, as the body that `facing` has for it.
    pub fn pairs(&self, bodies: &[Body], facing: &[usize], obstacles: usize) -> Pairs {
        // Most scenes have many objects and mention few of them.
        let number = |body: &Body| self.numbers.get(&*body.name).copied();
        let numbers: Vec<_> = bodies
            .iter()
            .map(|body| {
                if self.numbers.is_empty() {
                    None
                } else {
                    number(body)
                }
            })
            .collect();
        let of = |a: usize, b: usize| Some(sorted(numbers[a]?, numbers[b]?));
        let mut moving = Vec::new();
        let mut standing = Vec::new();
        for (a, &outer) in facing.iter().enumerate() {
            let body_a = &bodies[a];
            for (b, body_b) in bodies
                .iter()
                .enumerate()
                .take(facing.len())
                .skip(a + 1)
            {
                let names = of(a, b);
                if self.may_touch(body_a, body_b, names) {
                    continue;
                }
                let ancestor = common_ancestor(self.robot, body_a.link, body_b.link);
                let motions_above = [
                    body_a.motions_up_to(ancestor),
                    body_b.motions_up_to(ancestor),
                ];
                let pair = BodyPair {
                    a,
                    b,
                    ancestor,
                    motions_above,
                };
                if [body_a, body_b]
                    .iter()
                    .any(|body| moves_below(self.robot, body.link, ancestor))
                {
                    moving.push(pair);
                } else if self.may_stand_wrongly(body_a, body_b, names) {
                    standing.push(pair);
                }
            }
            let pairs = if moves_below(self.robot, body_a.link, None) {
                &mut moving
            } else {
                &mut standing
            };
            for (b, body_b) in bodies.iter().enumerate().skip(obstacles) {
                if !self.may_touch(body_a, body_b, of(a, b)) {
                    pairs.push(BodyPair {
                        a: outer,
                        b,
                        ancestor: None,
                        motions_above: [0, 0],
                    });
                }
            }
        }
        Pairs::new(self.robot, bodies, moving, standing)
    }

    /// Whether two bodies may touch; `names` are their numbers, where the scene mentions both.
    fn may_touch(&self, a: &Body, b: &Body, names: Option<(u32, u32)>) -> bool {
        if names.is_some_and(|names| self.forbidden.contains(&names)) {
            return false;
        }
        // What the robot says of two links it does not say of what they carry.
        let of_robot = match (a.kind, b.kind, a.link, b.link) {
            (BodyKind::Link, BodyKind::Link, Some(a), Some(b)) => self.robot.is_allowed(a, b),
            _ => false,
        };
        of_robot || names.is_some_and(|names| self.allowed.contains(&names))
    }

    /// Whether two bodies that no joint moves against each other are looked at. A robot's own links
    /// are built as they are; what somebody placed or attached, or asked to be checked, may be in
    /// the wrong place.
    fn may_stand_wrongly(&self, a: &Body, b: &Body, names: Option<(u32, u32)>) -> bool {
        let are_links = a.kind == BodyKind::Link && b.kind == BodyKind::Link;
        !are_links || names.is_some_and(|names| self.forbidden.contains(&names))
    }
}

fn sorted(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// Nearest link that both hang on (it may be one of them); `None` is the world, where obstacles
/// are.
fn common_ancestor(robot: &RobotModel, a: Option<usize>, b: Option<usize>) -> Option<usize> {
    let mut a = a?;
    let mut b = b?;
    // Parents come before children, so the later of the two is never above the other.
    while a != b {
        if a > b {
            a = robot.joints()[a].parent?;
        } else {
            b = robot.joints()[b].parent?;
        }
    }
    Some(a)
}

/// Whether a variable moves some joint between `ancestor` (excluded) and `link`.
fn moves_below(robot: &RobotModel, link: Option<usize>, ancestor: Option<usize>) -> bool {
    let mut at = link;
    while at != ancestor {
        let Some(link) = at else { return false };
        let joint = &robot.joints()[link];
        if kinematics::rate(robot.joints(), joint).is_some() {
            return true;
        }
        at = joint.parent;
    }
    false
}
