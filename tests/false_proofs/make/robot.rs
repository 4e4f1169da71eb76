//! Random robots: a chain on a fixed, planar or floating base, with joints beside it that follow
//! others.

use std::f64::consts::{FRAC_PI_2, PI};

use fastrand::Rng;

use super::mesh::{Form, Format, Mesh};
use super::{direction, one_in, pick, quaternion, uniform, vector};
use crate::pose::{Pose, Quaternion};
use crate::robot::{Column, Joint, Kind, Mimic, Origin, Robot, Turn};
use crate::shape::Geometry;
use crate::theme::Theme;

/// A shape of a link.
#[derive(Clone, Debug)]
pub struct Shape {
    pub geometry: Geometry,
    pub origin: Origin,
}

/// A robot and what its links look like.
#[derive(Clone, Debug)]
pub struct Made {
    pub robot: Robot,
    pub shapes: Vec<Vec<Shape>>,
    /// Its shapes are visuals.
    pub is_visual_only: bool,
    /// Frame of the virtual joint.
    pub world_frame: &'static str,
}

struct Maker<'a> {
    rng: &'a mut Rng,
    theme: Theme,
    joints: Vec<Joint>,
    links: Vec<String>,
    shapes: Vec<Vec<Shape>>,
}

/// A robot for a theme.
pub fn robot(rng: &mut Rng, theme: Theme) -> Made {
    let mut maker = Maker {
        rng,
        theme,
        joints: Vec::new(),
        links: Vec::new(),
        shapes: Vec::new(),
    };
    maker.base();
    match theme {
        Theme::RestContacts => maker.folding(),
        _ => {
            maker.chain();
            maker.beside();
        }
    }
    maker.finish()
}

impl Maker<'_> {
    fn add(&mut self, kind: Kind, parent: Option<usize>, origin: Origin) -> usize {
        let index = self.joints.len();
        let axis = if one_in(self.rng, 3) {
            direction(self.rng)
        } else {
            pick(self.rng, &AXES)
        };
        let limits = match kind {
            Kind::Revolute => Some((-uniform(self.rng, 1.2, 3.0), uniform(self.rng, 1.2, 3.0))),
            Kind::Prismatic => Some((-uniform(self.rng, 0.1, 0.5), uniform(self.rng, 0.1, 0.5))),
            Kind::Fixed | Kind::Continuous | Kind::Planar | Kind::Floating => None,
        };
        let has_soft = self.theme == Theme::Mixed && one_in(self.rng, 4);
        let soft_limits = limits
            .filter(|_| has_soft)
            .map(|(lower, upper)| (lower * 0.4, upper * 0.4));
        let name = format!("j{index}");
        self.joints.push(Joint {
            name,
            kind,
            parent,
            origin,
            axis,
            limits,
            soft_limits,
            mimic: None,
        });
        self.links.push(format!("l{index}"));
        self.shapes.push(Vec::new());
        index
    }

    /// The joint between world and root, and sometimes a planar or floating joint of the URDF's.
    fn base(&mut self) {
        let still = Origin {
            at: [0.0; 3],
            turn: Turn::Rpy([0.0; 3]),
        };
        let must_float = self.theme == Theme::Quaternions;
        let kind = match self.rng.usize(0..6) {
            0 => Kind::Planar,
            1 => Kind::Floating,
            _ if must_float => Kind::Floating,
            _ => Kind::Fixed,
        };
        let kind = if self.theme == Theme::RestContacts {
            Kind::Fixed
        } else {
            kind
        };
        self.add(kind, None, still);
        let second = match self.rng.usize(0..8) {
            0 => Kind::Planar,
            1 => Kind::Floating,
            _ => return,
        };
        if kind == Kind::Fixed && self.theme != Theme::RestContacts {
            let origin = self.origin([0.1, 0.0, 0.05]);
            self.add(second, Some(0), origin);
        }
    }

    fn chain(&mut self) {
        let mut parent = self.joints.len() - 1;
        self.body(parent, 0.12);
        for _ in 0..self.rng.usize(2..5) {
            let kind = match self.rng.usize(0..8) {
                0..3 => Kind::Revolute,
                3..6 => Kind::Continuous,
                6 => Kind::Prismatic,
                _ => Kind::Fixed,
            };
            let length = uniform(self.rng, 0.16, 0.3);
            let origin = self.origin([length, 0.0, 0.0]);
            parent = self.add(kind, Some(parent), origin);
            self.body(parent, length);
        }
    }

    /// Joints that follow others, each with a body of its own.
    fn beside(&mut self) {
        let leads = self.theme.has(Theme::Leaders);
        let count = if leads {
            self.rng.usize(1..4)
        } else {
            usize::from(one_in(self.rng, 3))
        };
        for _ in 0..count {
            let single = |joint: &Joint| {
                matches!(
                    joint.kind,
                    Kind::Revolute | Kind::Continuous | Kind::Prismatic
                )
            };
            let fits = |joint: &Joint| single(joint) && (leads || joint.kind != Kind::Continuous);
            let leaders: Vec<usize> = (0..self.joints.len())
                .filter(|&i| fits(&self.joints[i]))
                .collect();
            if leaders.is_empty() {
                return;
            }
            let leader = pick(self.rng, &leaders);
            let kind = pick(
                self.rng,
                &[
                    Kind::Prismatic,
                    Kind::Prismatic,
                    Kind::Revolute,
                    Kind::Continuous,
                ],
            );
            let multiplier = match kind {
                Kind::Prismatic => pick(self.rng, &[0.01, -0.02, 0.1, 0.05]),
                _ => pick(self.rng, &[1.0, -1.0, 2.0, 0.5, -0.5, 3.0, 1.5, 0.1]),
            };
            let offset = if one_in(self.rng, 3) {
                uniform(self.rng, -0.2, 0.2)
            } else {
                0.0
            };
            let parent = self.rng.usize(0..self.joints.len());
            let at = vector(self.rng, 0.35);
            let origin = self.origin(at);
            let joint = self.add(kind, Some(parent), origin);
            self.joints[joint].mimic = Some(Mimic {
                leader,
                multiplier,
                offset,
            });
            self.body(joint, 0.15);
        }
    }

    /// A forearm that lies on the base with every joint at 0, and is free beyond.
    fn folding(&mut self) {
        let rng = &mut *self.rng;
        let [reach, arm] = [uniform(rng, 0.15, 0.25), uniform(rng, 0.25, 0.35)];
        let boxed = |size: [f64; 3], x: f64| Shape {
            geometry: Geometry::Box(size),
            origin: Origin {
                at: [x, 0.0, 0.0],
                turn: Turn::Rpy([0.0; 3]),
            },
        };
        let plain = |at| Origin {
            at,
            turn: Turn::Rpy([0.0; 3]),
        };
        let height = uniform(rng, 0.065, 0.074);
        self.shapes[0] = vec![boxed([2.0 * reach, 0.1, 0.1], 0.0)];
        let shoulder = self.add(Kind::Revolute, Some(0), plain([reach, 0.0, height]));
        self.shapes[shoulder] = vec![boxed([arm, 0.05, 0.05], -arm / 2.0)];
        let elbow = self.add(Kind::Revolute, Some(shoulder), plain([-arm, 0.0, 0.0]));
        self.shapes[elbow] = vec![boxed([arm, 0.05, 0.05], arm / 2.0)];
        for joint in [shoulder, elbow] {
            self.joints[joint].axis = [0.0, 1.0, 0.0];
        }
    }

    fn origin(&mut self, at: [f64; 3]) -> Origin {
        let turn = if self.theme.has(Theme::QuaternionOrigins) {
            Turn::Quaternion(if self.rng.bool() {
                near_vertical(self.rng)
            } else {
                quaternion(self.rng)
            })
        } else if self.rng.bool() {
            Turn::Rpy([0, 1, 2].map(|_| pick(self.rng, &[0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, PI])))
        } else {
            Turn::Rpy(vector(self.rng, 1.2))
        };
        Origin { at, turn }
    }

    /// Gives a link shapes about half of its length; some links have none.
    fn body(&mut self, link: usize, length: f64) {
        if one_in(self.rng, 8) && link > 0 {
            return;
        }
        let count = if one_in(self.rng, 4) { 2 } else { 1 };
        for index in 0..count {
            let along = length * if index == 0 { 0.5 } else { 0.2 };
            let geometry = geometry(self.rng, self.theme, &Format::FILES, 0.05, length * 0.3);
            let turn = self.origin([0.0; 3]).turn;
            let wanted = Pose {
                rotation: turn.rotation(),
                at: [along, 0.0, 0.0],
            };
            let at = geometry.origin_for(&wanted);
            self.shapes[link].push(Shape {
                geometry,
                origin: Origin { at, turn },
            });
        }
    }

    fn finish(self) -> Made {
        let Self {
            rng,
            theme,
            joints,
            links,
            shapes,
        } = self;
        let is_virtual = joints[0].kind != Kind::Fixed;
        let mut robot = Robot {
            joints,
            links,
            columns: Vec::new(),
            disabled: None,
        };
        let mut with_columns: Vec<usize> = (0..robot.joints.len())
            .filter(|&i| {
                robot.joints[i].kind != Kind::Fixed
                    && (robot.joints[i].mimic.is_none() || one_in(rng, 20))
            })
            .collect();
        rng.shuffle(&mut with_columns);
        // A joint without a column is held at 0, which its limits allow.
        if with_columns.len() > 2 && one_in(rng, 10) {
            with_columns.pop();
        }
        let columns = |joint: usize| {
            let parts = robot.joints[joint].kind.parts().len();
            (0..parts).map(move |part| Column { joint, part })
        };
        robot.columns = with_columns
            .into_iter()
            .flat_map(columns)
            .collect();
        if is_virtual || theme != Theme::RestContacts && one_in(rng, 3) {
            let neighbours =
                (1..robot.links.len()).map(|link| (robot.joints[link].parent.unwrap_or(0), link));
            robot.disabled = Some(neighbours.collect());
        }
        let world_frame = pick(rng, &["world", "odom", "map"]);
        Made {
            robot,
            shapes,
            is_visual_only: theme == Theme::VisualOnly,
            world_frame,
        }
    }
}

const AXES: [[f64; 3]; 4] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
];

/// A turn that points x nearly up or down, up to 6 mrad beside it.
fn near_vertical(rng: &mut Rng) -> Quaternion {
    let half = 0.5 * (FRAC_PI_2 - uniform(rng, -6e-3, 6e-3)).copysign(uniform(rng, -1.0, 1.0));
    [0.0, half.sin(), 0.0, half.cos()]
}

/// A shape of about a size (m), between `least` and `most` from its middle.
pub fn geometry(
    rng: &mut Rng,
    theme: Theme,
    formats: &[Format],
    least: f64,
    most: f64,
) -> Geometry {
    // A notch that nothing fits into tells nothing.
    let most = if theme == Theme::Concave {
        1.8 * most
    } else {
        most
    };
    let size = uniform(rng, least, most.max(least * 1.1));
    let forms: &[Form] = match theme {
        Theme::Concave => &[Form::Star, Form::Comb],
        Theme::Warped => &[Form::Roof],
        Theme::Mixed => &[Form::Box, Form::Star, Form::Comb, Form::Roof],
        _ => &[Form::Box],
    };
    let share = match theme {
        Theme::Concave | Theme::Warped => 3,
        Theme::FarMeshes => 2,
        _ => 1,
    };
    if rng.usize(0..4) < share {
        let form = pick(rng, forms);
        // Only these have polygons.
        let with_polygons = [Format::Obj, Format::Dae];
        let has_both = with_polygons
            .iter()
            .all(|format| formats.contains(format));
        let formats = if share == 3 && has_both && rng.bool() {
            &with_polygons
        } else {
            formats
        };
        let format = pick(rng, formats);
        let mut mesh = Mesh::new(rng, form, format, size);
        if theme.has(Theme::FarMeshes) && !matches!(mesh.format, Format::StlBinary) {
            mesh.put_far(rng);
        }
        return Geometry::Mesh(Box::new(mesh));
    }
    match rng.usize(0..4) {
        0 => Geometry::Sphere { radius: size },
        1 => Geometry::Cylinder {
            length: 2.0 * size,
            radius: size * uniform(rng, 0.3, 0.8),
        },
        2 => Geometry::Capsule {
            length: size,
            radius: size * uniform(rng, 0.3, 0.6),
        },
        _ => Geometry::Box([0, 1, 2].map(|_| size * uniform(rng, 0.6, 1.8))),
    }
}
