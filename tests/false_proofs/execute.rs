//! Executes a path number by number, as a controller does, and looks how near bodies come.

use super::distance::{Apart, apart, overlap};
use super::pose::{Pose, Quaternion, length, quaternion_dot, slerp, sub};
use super::robot::{Kind, Robot};
use super::world::{Body, Pair, World};

/// How far is looked (m): a proved segment that comes nearer than this says something.
pub const NEAR_M: f64 = 0.05;
/// Less than this (m) refutes nothing: it is rounding.
pub const ROUNDING_M: f64 = 1e-6;
/// What an overlap counts as, where nothing is promised (m).
const OVERLAP_M: f64 = 1.0;
/// Bodies move about this far (m) from one sample to the next.
const STEP_M: f64 = 0.04;
const FEWEST_SAMPLES: usize = 6;
const MOST_SAMPLES: usize = 600;
/// Orientations whose dot product is this small stand half a turn apart: they name no way.
const HALF_A_TURN: f64 = 1e-9;

/// Where a motion does what was proved not to happen.
#[derive(Clone, Debug)]
pub struct Refutation {
    pub segment: usize,
    pub t: f64,
    pub bodies: [String; 2],
    /// Distance (m); of bodies that overlap at most 0.
    pub distance_m: f64,
    /// What was promised (m).
    pub floor_m: f64,
    /// Whether the bodies overlap; else they only come nearer than was promised.
    pub is_overlap: bool,
}

/// What a path does when it is executed.
#[derive(Clone, Debug, Default)]
pub struct Executed {
    pub refutation: Option<Refutation>,
    /// Nearest that bodies come on each segment, as far as was looked (m).
    pub nearest_m: Vec<f64>,
}

/// Executes a path; each pair has been promised to keep its floor. Where two orientations stand
/// half a turn apart, both ways must keep it, or one of them where it `is_said` that there are two.
pub fn path(world: &World, rows: &[Vec<f64>], floors: &[f64], is_said: bool) -> Executed {
    let mut executed = Executed::default();
    let mut motion = Motion {
        is_said,
        ..Motion::new(world, floors)
    };
    let single = [rows[0].clone(), rows[0].clone()];
    let rows = if rows.len() == 1 { &single[..] } else { rows };
    executed.refutation = motion.standing(&rows[0]);
    for (segment, ends) in rows.windows(2).enumerate() {
        let (nearest, refutation) = motion.segment(&ends[0], &ends[1]);
        executed.nearest_m.push(nearest);
        executed.refutation = executed
            .refutation
            .or(refutation.map(|found| Refutation { segment, ..found }));
    }
    executed
}

/// Whether bodies keep a distance (m) from each other on a straight line.
pub fn is_free(world: &World, from: &[f64], to: &[f64], keeping_m: f64) -> bool {
    let floors: Vec<f64> = world
        .pairs
        .iter()
        .map(|pair| if pair.is_moving { keeping_m } else { 0.0 })
        .collect();
    let mut motion = Motion::new(world, &floors);
    motion.standing(from).is_none() && motion.segment(from, to).1.is_none()
}

/// Pairs that overlap at a row.
pub fn overlapping(world: &World, row: &[f64]) -> Vec<Pair> {
    let mut motion = Motion::new(world, &[]);
    motion.row = row.to_vec();
    motion.stand();
    world
        .pairs
        .iter()
        .filter(|pair| motion.overlaps(**pair))
        .copied()
        .collect()
}

/// The distance (m) of two bodies at a place of a segment, as far as is looked; `None` where they
/// may touch.
pub fn distance_at(
    world: &World,
    [from, to]: [&Vec<f64>; 2],
    t: f64,
    names: &[String; 2],
) -> Option<f64> {
    let name = |body: usize| &world.bodies[body].name;
    let is_named = |pair: &&Pair| {
        let found = [name(pair.a), name(pair.b)];
        found == [&names[0], &names[1]] || found == [&names[1], &names[0]]
    };
    let pair = world.pairs.iter().find(is_named)?;
    let mut motion = Motion::new(world, &[]);
    between(&world.robot, from, to, t, false, &mut motion.row);
    motion.stand();
    Some(
        motion
            .nearer(*pair, NEAR_M)
            .map_or(NEAR_M, |distance| distance.at_most),
    )
}

/// The nearest pair at a place of a segment.
#[derive(Clone, Copy)]
struct Place {
    t: f64,
    /// Distance less what was promised (m).
    spare_m: f64,
    pair: usize,
    distance: Apart,
}

struct Motion<'a> {
    world: &'a World,
    floors: &'a [f64],
    row: Vec<f64>,
    links: Vec<Pose>,
    poses: Vec<Pose>,
    balls: Vec<[f64; 3]>,
    is_said: bool,
}

impl<'a> Motion<'a> {
    fn new(world: &'a World, floors: &'a [f64]) -> Self {
        Self {
            world,
            floors,
            row: Vec::new(),
            links: Vec::new(),
            poses: Vec::new(),
            balls: Vec::new(),
            is_said: false,
        }
    }

    /// Samples a segment, closer where it is nearest; how near it comes (m), and what refutes it.
    fn segment(&mut self, from: &[f64], to: &[f64]) -> (f64, Option<Refutation>) {
        let samples = samples(&self.world.robot, from, to);
        let mut nearest = NEAR_M;
        let mut refutations = Vec::new();
        let ways = ways(&self.world.robot, from, to);
        for &is_flipped in &ways {
            let place = self.worst(from, to, samples, is_flipped);
            nearest = nearest.min(place.distance.at_most);
            if place.spare_m < -ROUNDING_M {
                refutations.push(self.refuted(from, to, &place, is_flipped));
            }
        }
        let is_refuted = !self.is_said || refutations.len() == ways.len();
        (
            nearest,
            refutations
                .into_iter()
                .next()
                .filter(|_| is_refuted),
        )
    }

    fn worst(&mut self, from: &[f64], to: &[f64], samples: usize, is_flipped: bool) -> Place {
        let worst = |a: Place, b: Place| if b.spare_m < a.spare_m { b } else { a };
        let places =
            (0..=samples).map(|i| self.look(from, to, i as f64 / samples as f64, is_flipped));
        let mut place = places.reduce(worst).expect("there are samples");
        let mut step = 0.5 / samples as f64;
        // Only what comes near may come nearer between two samples.
        while place.distance.at_most < NEAR_M && step > 1e-4 / samples as f64 {
            for t in [place.t - step, place.t + step] {
                place = worst(place, self.look(from, to, t.clamp(0.0, 1.0), is_flipped));
            }
            step *= 0.5;
        }
        place
    }

    fn refuted(&mut self, from: &[f64], to: &[f64], place: &Place, is_flipped: bool) -> Refutation {
        between(
            &self.world.robot,
            from,
            to,
            place.t,
            is_flipped,
            &mut self.row,
        );
        self.stand();
        let pair = self.world.pairs[place.pair];
        Refutation {
            segment: 0,
            t: place.t,
            bodies: self.names(pair),
            distance_m: place.distance.at_most,
            floor_m: self.floors[place.pair],
            is_overlap: self.overlaps(pair),
        }
    }

    /// What no column moves must not overlap.
    fn standing(&mut self, row: &[f64]) -> Option<Refutation> {
        self.row = row.to_vec();
        self.stand();
        let pair = self
            .world
            .pairs
            .iter()
            .find(|pair| !pair.is_moving && self.overlaps(**pair))?;
        let bodies = self.names(*pair);
        Some(Refutation {
            segment: 0,
            t: 0.0,
            bodies,
            distance_m: 0.0,
            floor_m: 0.0,
            is_overlap: true,
        })
    }

    fn names(&self, pair: Pair) -> [String; 2] {
        [pair.a, pair.b].map(|body| self.world.bodies[body].name.clone())
    }

    fn overlaps(&self, pair: Pair) -> bool {
        let parts = |body: usize| {
            self.world.bodies[body]
                .parts
                .iter()
                .map(move |part| (part, &self.poses[body]))
        };
        parts(pair.a).any(|a| parts(pair.b).any(|b| overlap(a, b, ROUNDING_M)))
    }

    /// Puts every body where it is at the present row.
    fn stand(&mut self) {
        self.world
            .robot
            .place(&self.row, &mut self.links);
        let bodies = &self.world.bodies;
        self.poses.clear();
        self.poses
            .extend(bodies.iter().map(|body| body.pose(&self.links)));
        self.balls.clear();
        self.balls.extend(
            bodies
                .iter()
                .zip(&self.poses)
                .map(|(body, pose)| pose.point(body.ball.0)),
        );
    }

    fn look(&mut self, from: &[f64], to: &[f64], t: f64, is_flipped: bool) -> Place {
        between(&self.world.robot, from, to, t, is_flipped, &mut self.row);
        self.stand();
        let far = Apart {
            at_least: NEAR_M,
            at_most: NEAR_M,
        };
        let mut worst = Place {
            t,
            spare_m: NEAR_M,
            pair: 0,
            distance: far,
        };
        for (index, pair) in self
            .world
            .pairs
            .iter()
            .enumerate()
            .filter(|(_, pair)| pair.is_moving)
        {
            let enough = worst.spare_m + self.floors[index];
            let Some(distance) = self.nearer(*pair, enough) else {
                continue;
            };
            // Of parts that overlap only that is known.
            let is_overlap = distance.at_most <= 0.0 && self.overlaps(*pair);
            let spare_m = if is_overlap {
                -OVERLAP_M
            } else {
                distance.at_most - self.floors[index]
            };
            worst = Place {
                t,
                spare_m,
                pair: index,
                distance,
            };
        }
        worst
    }

    /// The distance of two bodies, where it is less than `enough`.
    fn nearer(&self, pair: Pair, enough: f64) -> Option<Apart> {
        let (a, b): (&Body, &Body) = (&self.world.bodies[pair.a], &self.world.bodies[pair.b]);
        let beyond = |centres: f64, radii: f64| centres - radii >= enough;
        if beyond(
            length(sub(self.balls[pair.a], self.balls[pair.b])),
            a.ball.1 + b.ball.1,
        ) {
            return None;
        }
        let pose_a = &self.poses[pair.a];
        let pose_b = &self.poses[pair.b];
        let mut least: Option<Apart> = None;
        for one in &a.parts {
            let centre = pose_a.point(one.ball.0);
            for other in &b.parts {
                if beyond(
                    length(sub(centre, pose_b.point(other.ball.0))),
                    one.ball.1 + other.ball.1,
                ) {
                    continue;
                }
                let found = apart((one, pose_a), (other, pose_b), enough);
                if found.at_most < enough && least.is_none_or(|least| found.at_most < least.at_most)
                {
                    least = Some(found);
                }
            }
        }
        least
    }
}

/// Whether quaternions are flipped from the shorter arc: half a turn apart they may go either way.
fn ways(robot: &Robot, from: &[f64], to: &[f64]) -> Vec<bool> {
    let is_open = turns(robot)
        .any(|q| quaternion_dot(quaternion(from, q), quaternion(to, q)).abs() < HALF_A_TURN);
    if is_open {
        vec![false, true]
    } else {
        vec![false]
    }
}

/// First columns of the quaternions.
fn turns(robot: &Robot) -> impl Iterator<Item = usize> {
    let is_first = |(_, column): &(usize, &super::robot::Column)| {
        robot.joints[column.joint].kind == Kind::Floating && column.part == 3
    };
    robot
        .columns
        .iter()
        .enumerate()
        .filter(is_first)
        .map(|(q, _)| q)
}

fn quaternion(row: &[f64], q: usize) -> Quaternion {
    super::pose::normalised([row[q], row[q + 1], row[q + 2], row[q + 3]])
}

/// The row at a ratio of the way: every number on a straight line, quaternions on the shorter arc.
pub fn between(
    robot: &Robot,
    from: &[f64],
    to: &[f64],
    t: f64,
    is_flipped: bool,
    row: &mut Vec<f64>,
) {
    row.clear();
    row.extend(
        from.iter()
            .zip(to)
            .map(|(from, to)| from + t * (to - from)),
    );
    for q in turns(robot) {
        let a = quaternion(from, q);
        let b = quaternion(to, q);
        let is_longer = quaternion_dot(a, b) < 0.0;
        let b = if is_longer != is_flipped {
            b.map(|x| -x)
        } else {
            b
        };
        row[q..q + 4].copy_from_slice(&slerp(a, b, t));
    }
}

/// How many samples a segment gets, by how far its bodies may move: robots here reach about a
/// metre.
fn samples(robot: &Robot, from: &[f64], to: &[f64]) -> usize {
    let mut travel = 0.0;
    for (q, column) in robot.columns.iter().enumerate() {
        let by = (to[q] - from[q]).abs();
        let followers = robot
            .followers(column.joint)
            .into_iter()
            .map(|(_, multiplier)| multiplier.abs());
        travel += by * (1.0 + followers.sum::<f64>());
    }
    ((travel / STEP_M) as usize).clamp(FEWEST_SAMPLES, MOST_SAMPLES)
}
