//! The robot that the files describe, and where its links are at a row of numbers.

use super::pose::{
    Pose, Quaternion, Rotation, Vector, about, normalised, of_quaternion, of_rpy, scaled,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Planar,
    Floating,
}

impl Kind {
    pub const MOVING: [Self; 5] = [
        Self::Revolute,
        Self::Continuous,
        Self::Prismatic,
        Self::Planar,
        Self::Floating,
    ];

    pub fn word(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Planar => "planar",
            Self::Floating => "floating",
        }
    }

    /// What follows the joint's name in the names of its columns.
    pub fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Fixed => &[],
            Self::Revolute | Self::Continuous | Self::Prismatic => &[""],
            Self::Planar => &["/x", "/y", "/theta"],
            Self::Floating => &[
                "/trans_x", "/trans_y", "/trans_z", "/rot_x", "/rot_y", "/rot_z", "/rot_w",
            ],
        }
    }
}

/// How a file says a turn.
#[derive(Clone, Copy, Debug)]
pub enum Turn {
    Rpy(Vector),
    /// URDF 1.1's `quat_xyzw`.
    Quaternion(Quaternion),
}

impl Turn {
    pub fn rotation(&self) -> Rotation {
        match self {
            Self::Rpy(rpy) => of_rpy(*rpy),
            Self::Quaternion(q) => of_quaternion(*q),
        }
    }
}

/// An `<origin>`.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    pub at: Vector,
    pub turn: Turn,
}

impl Origin {
    pub fn pose(&self) -> Pose {
        Pose {
            rotation: self.turn.rotation(),
            at: self.at,
        }
    }
}

/// `multiplier` · the value of `leader` + `offset`.
#[derive(Clone, Copy, Debug)]
pub struct Mimic {
    pub leader: usize,
    pub multiplier: f64,
    pub offset: f64,
}

/// A joint; it carries the link of its own number.
#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    pub kind: Kind,
    /// Link that it hangs on; `None` is the world, for the first.
    pub parent: Option<usize>,
    pub origin: Origin,
    pub axis: Vector,
    pub limits: Option<(f64, f64)>,
    pub soft_limits: Option<(f64, f64)>,
    pub mimic: Option<Mimic>,
}

impl Joint {
    pub fn bounds(&self) -> (f64, f64) {
        self.limits
            .unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// Where it may be: limit ∩ soft limit.
    pub fn soft_bounds(&self) -> (f64, f64) {
        let (lower, upper) = self.bounds();
        self.soft_limits.map_or((lower, upper), |soft| {
            (lower.max(soft.0), upper.min(soft.1))
        })
    }
}

/// A column of a path: part `part` of joint `joint`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    pub joint: usize,
    pub part: usize,
}

#[derive(Clone, Debug)]
pub struct Robot {
    /// The first is the virtual joint, which may be fixed; parents come before children.
    pub joints: Vec<Joint>,
    pub links: Vec<String>,
    /// Columns of its paths.
    pub columns: Vec<Column>,
    /// Pairs of links that its SRDF leaves out; `None` where it has none.
    pub disabled: Option<Vec<(usize, usize)>>,
}

impl Robot {
    pub fn name_of(&self, column: Column) -> String {
        let joint = &self.joints[column.joint];
        format!("{}{}", joint.name, joint.kind.parts()[column.part])
    }

    /// First column of a joint that has some.
    pub fn column_of(&self, joint: usize) -> Option<usize> {
        self.columns
            .iter()
            .position(|column| column.joint == joint)
    }

    /// Value of a joint of one number: its column's, its leader's by the mimic, or 0.
    fn value(&self, joint: usize, row: &[f64]) -> f64 {
        match (self.column_of(joint), self.joints[joint].mimic) {
            (Some(column), _) => row[column],
            (None, Some(mimic)) => mimic.multiplier * self.value(mimic.leader, row) + mimic.offset,
            (None, None) => 0.0,
        }
    }

    /// Whether a column moves it, its own or its leader's.
    pub fn is_driven(&self, joint: usize) -> bool {
        self.joints[joint].kind != Kind::Fixed
            && (self.column_of(joint).is_some()
                || self.joints[joint]
                    .mimic
                    .is_some_and(|mimic| mimic.multiplier != 0.0 && self.is_driven(mimic.leader)))
    }

    /// Whether turning its number by a whole turn leaves the robot where it is: an angle, for a
    /// column.
    pub fn is_angle(&self, column: Column) -> bool {
        match self.joints[column.joint].kind {
            Kind::Planar => column.part == 2,
            Kind::Continuous => self
                .followers(column.joint)
                .iter()
                .all(|(joint, multiplier)| {
                    self.joints[*joint].kind != Kind::Prismatic && multiplier.fract() == 0.0
                }),
            Kind::Fixed | Kind::Revolute | Kind::Prismatic | Kind::Floating => false,
        }
    }

    /// Joints that follow a joint through any number of others, with what its number is multiplied
    /// by.
    pub fn followers(&self, leader: usize) -> Vec<(usize, f64)> {
        let follows = |(joint, mimic): (usize, Mimic)| {
            (mimic.leader == leader && self.column_of(joint).is_none()).then(|| {
                let beyond = self.followers(joint).into_iter();
                let beyond =
                    beyond.map(move |(other, multiplier)| (other, multiplier * mimic.multiplier));
                std::iter::once((joint, mimic.multiplier))
                    .chain(beyond)
                    .collect::<Vec<_>>()
            })
        };
        let mimics = self
            .joints
            .iter()
            .enumerate()
            .filter_map(|(index, joint)| Some((index, joint.mimic?)));
        mimics.filter_map(follows).flatten().collect()
    }

    /// Where every link is at a row of numbers.
    pub fn place(&self, row: &[f64], links: &mut Vec<Pose>) {
        links.clear();
        for (index, joint) in self.joints.iter().enumerate() {
            let parent = joint
                .parent
                .map_or(Pose::IDENTITY, |parent| links[parent]);
            links.push(
                parent
                    .then(&joint.origin.pose())
                    .then(&self.motion(index, row)),
            );
        }
    }

    fn motion(&self, index: usize, row: &[f64]) -> Pose {
        let joint = &self.joints[index];
        match joint.kind {
            Kind::Fixed => Pose::IDENTITY,
            Kind::Revolute | Kind::Continuous => {
                Pose::turn(about(joint.axis, self.value(index, row)))
            }
            Kind::Prismatic => Pose::shift(scaled(joint.axis, self.value(index, row))),
            Kind::Planar => match self.column_of(index) {
                Some(q) => Pose {
                    rotation: about([0.0, 0.0, 1.0], row[q + 2]),
                    at: [row[q], row[q + 1], 0.0],
                },
                None => Pose::IDENTITY,
            },
            Kind::Floating => match self.column_of(index) {
                Some(q) => {
                    let turn = normalised([row[q + 3], row[q + 4], row[q + 5], row[q + 6]]);
                    Pose {
                        rotation: of_quaternion(turn),
                        at: [row[q], row[q + 1], row[q + 2]],
                    }
                }
                None => Pose::IDENTITY,
            },
        }
    }

    /// Whether a moving joint stands between two links.
    pub fn moves_between(&self, a: usize, b: usize) -> bool {
        let above = |link: usize| {
            let up = |at: &usize| self.joints[*at].parent;
            std::iter::successors(Some(link), up).collect::<Vec<_>>()
        };
        let of_a = above(a);
        let of_b = above(b);
        let apart = |own: &[usize], other: &[usize]| {
            own.iter()
                .any(|at| !other.contains(at) && self.is_driven(*at))
        };
        apart(&of_a, &of_b) || apart(&of_b, &of_a)
    }

    /// Whether some joint moves a link in the world.
    pub fn moves(&self, link: usize) -> bool {
        let up = |at: &usize| self.joints[*at].parent;
        std::iter::successors(Some(link), up).any(|at| self.is_driven(at))
    }
}
