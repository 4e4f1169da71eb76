//! A sensor's frame becomes the shape of a sensed object.

use std::sync::Arc;

use super::points::Points;
use crate::collision::OwnBodies;
use crate::math::{Pose, Quat, Vec3};
use crate::robot::{Kinematics, RobotModel, stand};
use crate::scene::{SensedFrame, Sensing};
use crate::shape::sensed::{Spacing, Thinned};
use crate::shape::{Cloud, PlacedShape, Shape};
use crate::store::{PreparedScene, Snapshot};
use crate::warning::grouped;
use taut_ipc::control::{CloudFrame, Refusal};
use taut_ipc::wire::{Code, RequestHeader};

/// How soon to look again for the first frame of a sensor.
const RETRY_MS: u32 = 100;
/// Quaternions may differ from unit length by this much: sensors send single precision.
const NORM_TOLERANCE: f64 = 1e-3;
/// Clocks of one machine do not differ; a stamp this far ahead (ns) is of another clock.
const AHEAD_NS: u64 = 1_000_000;

/// What a frame is seen among.
#[derive(Debug)]
pub struct Scenery {
    /// The scene that it changes.
    pub scene: Arc<PreparedScene>,
    /// What is made of its points.
    pub sensing: Sensing,
    /// The robot that may be in the picture, with what it carries.
    pub robot: Option<Snapshot>,
    /// The time (ns, monotonic).
    pub now_ns: u64,
}

/// A frame that is read.
#[derive(Debug)]
pub struct TakenFrame {
    /// Content of the scene that it changes.
    pub before: u64,
    /// That scene with it, and its solids.
    pub prepared: Arc<PreparedScene>,
    /// Where the sensor is in the world.
    pub pose: Pose,
    /// The shape.
    pub shapes: Arc<[PlacedShape]>,
    /// What it is.
    pub frame: SensedFrame,
    /// What a person should know, a line each.
    pub warnings: Vec<String>,
}

/// Refuses what is asked of a scene of which a part is not seen yet, or was seen longer than the
/// request allows before `now_ns` (monotonic).
///
/// # Errors
/// The refusal, with the object that is missing or too old.
pub fn check_seen(snapshot: &Snapshot, header: &RequestHeader, now_ns: u64) -> Result<(), Refusal> {
    let scene = &snapshot.scene;
    if let Some(id) = scene.awaited().next() {
        return Err(unseen(
            Code::Loading,
            format!(
                "object {id:?} is sensed, and no frame of its sensor has come yet: nothing is known of what is there"
            ),
        ));
    }
    match scene.oldest_frame() {
        Some((object, frame)) if is_too_old(header.max_age_ns, frame.age_ns(now_ns)) => {
            let [age_ms, most_ms] =
                [frame.age_ns(now_ns), header.max_age_ns].map(|ns| ns as f64 * 1e-6);
            let id = &object.id;
            Err(unseen(
                Code::CloudTooOld,
                format!(
                    "object {id:?} was seen {age_ms:.1} ms ago, max_age is {most_ms} ms: see whether its sensor sends"
                ),
            ))
        }
        _ => Ok(()),
    }
}

/// Whether something of this age is refused; 0 allows any.
pub fn is_too_old(max_age_ns: u64, age_ns: u64) -> bool {
    max_age_ns != 0 && age_ns > max_age_ns
}

fn unseen(code: Code, why: String) -> Refusal {
    Refusal {
        code: code.into(),
        message: format!("{why}; send again in {RETRY_MS} ms"),
        retry_after_ms: RETRY_MS,
    }
}

/// Reads a frame of an object, once, where it lies, and makes the solids of its scene.
///
/// # Errors
/// A refusal: a layout, pose or joint value that is none, a stamp of another clock, no point at all.
pub fn read_frame(
    around: &Scenery,
    object: &str,
    frame: &CloudFrame,
    body: &[u8],
) -> Result<TakenFrame, Refusal> {
    check_time(frame, around.now_ns)?;
    let points = Points::new(&frame.layout, body)?;
    let view = View::new(around, frame)?;
    let mut seen = SensedFrame {
        taken_ns: frame.taken_ns,
        came: points.len() as u32,
        ..SensedFrame::default()
    };
    let kept = view.sort(&points, around.sensing.self_padding_m, &mut seen);
    if kept.is_empty() {
        return Err(nothing_left(object, &seen));
    }
    let sensing = &around.sensing;
    let warnings = warnings(object, sensing, &kept);
    let (points, radius_m) = thinned(kept, sensing, &mut seen)?;
    let cloud = Cloud::of_points(points.iter().map(Vec3::to_array), radius_m)
        .map_err(|error| malformed(format!("object {object:?}: {error}")))?;
    let shapes: Arc<[PlacedShape]> = [PlacedShape {
        pose: Pose::identity(),
        shape: Shape::Cloud(cloud.into()),
    }]
    .into();
    let before = around.scene.scene();
    let scene = before
        .with_frame(object, view.pose, shapes.clone(), seen)
        .map_err(|error| super::scene_refusal(&error))?;
    let prepared = PreparedScene::after(&around.scene, Arc::new(scene));
    prepared.solids();
    Ok(TakenFrame {
        before: before.hash(),
        prepared: prepared.into(),
        pose: view.pose,
        shapes,
        frame: seen,
        warnings,
    })
}

fn check_time(frame: &CloudFrame, now_ns: u64) -> Result<(), Refusal> {
    if frame.taken_ns <= now_ns.saturating_add(AHEAD_NS) {
        return Ok(());
    }
    Err(malformed(format!(
        "taken_ns {} is {:.3} s in the future; it is CLOCK_MONOTONIC of this machine, in nanoseconds",
        frame.taken_ns,
        (frame.taken_ns - now_ns) as f64 * 1e-9
    )))
}

/// Where a sensor is, and whom it may see.
struct View {
    pose: Pose,
    robot: Option<OwnBodies>,
}

impl View {
    fn new(around: &Scenery, frame: &CloudFrame) -> Result<Self, Refusal> {
        let pose = pose(&frame.pose)?;
        let Some(snapshot) = &around.robot else {
            return match frame.link.as_str() {
                "" => Ok(Self { pose, robot: None }),
                link => Err(malformed(format!(
                    "link {link:?} of no robot; name the robot, and its joint values"
                ))),
            };
        };
        let robot = &snapshot.robot;
        let kinematics =
            stand(robot, &frame.joints).map_err(|error| malformed(error.to_string()))?;
        let model = snapshot.model.get();
        let model = model.map_err(|error| super::model_refusal(error, robot))?;
        let pose = link_pose(robot, &kinematics, &frame.link)? * pose;
        Ok(Self {
            robot: Some(OwnBodies::of(model, &kinematics).seen_from(&pose)),
            pose,
        })
    }

    /// Points of the world; the others are counted.
    fn sort(&self, points: &Points<'_>, padding: f64, seen: &mut SensedFrame) -> Vec<Vec3> {
        let own = |point| self.robot.as_ref()?.near(point, padding);
        let mut kept = Vec::with_capacity(points.len());
        points.each(|point| {
            if !point.is_finite() || point == Vec3::ZERO {
                seen.not_finite += 1;
            } else if let Some(distance) = own(point) {
                seen.on_robot += 1;
                seen.in_padding += u32::from(distance > 0.0);
            } else {
                kept.push(point);
            }
        });
        kept
    }
}

fn pose(numbers: &[f64; 7]) -> Result<Pose, Refusal> {
    let [x, y, z, qx, qy, qz, qw] = *numbers;
    let rotation = Quat::from_xyzw(qx, qy, qz, qw);
    let is_finite = numbers.iter().all(|number| number.is_finite());
    if !is_finite || (rotation.length() - 1.0).abs() > NORM_TOLERANCE {
        return Err(malformed(format!(
            "pose {numbers:?}; valid: a finite position and a unit quaternion x, y, z, w"
        )));
    }
    let position = Vec3::new(x, y, z);
    Ok(Pose::from_parts(position, rotation.normalize()))
}

fn link_pose(robot: &RobotModel, kinematics: &Kinematics, link: &str) -> Result<Pose, Refusal> {
    if link.is_empty() {
        return Ok(Pose::identity());
    }
    let found = robot
        .links()
        .iter()
        .position(|known| known.name == link);
    found
        .map(|index| kinematics.poses()[index])
        .ok_or_else(|| {
            let names = robot
                .links()
                .iter()
                .map(|link| link.name.as_str());
            malformed(format!("link {link:?}; the robot has: {}", listed(names)))
        })
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

/// Points as many as are asked for, and the radius of the balls that they stand for.
fn thinned(
    points: Vec<Vec3>,
    sensing: &Sensing,
    seen: &mut SensedFrame,
) -> Result<(Vec<Vec3>, f64), Refusal> {
    let came = points.len();
    let (points, radius_m) = match sensing.thin_m {
        0.0 => (points, sensing.radius_m),
        cell => {
            let thinned = Thinned::of(&points, cell).map_err(malformed)?;
            (thinned.points, sensing.radius_m + thinned.growth)
        }
    };
    seen.thinned = (came - points.len()) as u32;
    seen.points = points.len() as u32;
    Ok((points, radius_m))
}

/// What is odd about the first frame of an object: to look at each would take longer than to read
/// it.
fn warnings(object: &str, sensing: &Sensing, points: &[Vec3]) -> Vec<String> {
    let spacing = match sensing.frame {
        None => Spacing::of(points),
        Some(_) => None,
    };
    let wide = spacing.filter(|spacing| sensing.radius_m < spacing.median / 2.0);
    let warning = wide.map(|spacing| {
        format!(
            "object {object:?}: half of its points lie {:.1} mm or more apart, 5 % {:.1} mm, and each is a ball of radius {:.1} mm: nothing is proved of what lies between them; give a radius of {:.1} mm or more",
            spacing.median * 1e3,
            spacing.most * 1e3,
            sensing.radius_m * 1e3,
            spacing.most / 2.0 * 1e3
        )
    });
    warning.into_iter().collect()
}

fn nothing_left(object: &str, seen: &SensedFrame) -> Refusal {
    malformed(format!(
        "object {object:?}: of {} points none is left ({} not finite, {} the robot's); a frame without a point says nothing of what is there: check sensor, pose and joint values",
        grouped(seen.came as usize),
        grouped(seen.not_finite as usize),
        grouped(seen.on_robot as usize)
    ))
}

fn malformed(text: String) -> Refusal {
    Refusal::new(Code::MalformedRequest, text)
}
