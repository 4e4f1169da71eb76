//! Certificates of trajectories.

use serde_json::Value;
use taut::validation::{Certificate, Interpolation, TimedClaims};

use super::common::{Place, Run};
use super::{Change, changed_problem, data, problem, read};

/// A trajectory of `taut time`.
struct Executed {
    place: Place,
    problem: String,
    /// JointTrajectory, and its certificate.
    trajectory: String,
    proof: String,
}

impl Executed {
    fn new() -> Self {
        let place = Place::new();
        let problem = problem("arm_window");
        let [trajectory, proof] =
            ["trajectory.json", "proof.json"].map(|name| place.file(name, ""));
        let run = place.taut(&[
            "time",
            &problem,
            "--acceleration",
            "2/s",
            "-o",
            &trajectory,
            "--write-certificate",
            &proof,
        ]);
        assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
        Self {
            place,
            problem,
            trajectory,
            proof,
        }
    }

    /// The certificate of `proof` held against a trajectory.
    fn verify(&self, trajectory: &str, proof: &str, problem: &str) -> Run {
        self.place.taut(&[
            "check",
            trajectory,
            "--timed",
            "--problem",
            problem,
            "--certificate",
            proof,
        ])
    }

    /// The same trajectory after a change, as another file.
    fn changed(&self, change: impl FnOnce(&mut Value)) -> String {
        let mut value = read(&self.trajectory);
        change(&mut value);
        self.place
            .file("changed.json", &value.to_string())
    }

    /// The same certificate after a change by someone who computes the digest anew.
    fn forged(&self, change: impl FnOnce(&mut Certificate)) -> String {
        let mut certificate = serde_json::from_value(read(&self.proof)).unwrap();
        change(&mut certificate);
        let text = serde_json::to_string(&certificate.sealed()).unwrap();
        self.place.file("forged.json", &text)
    }

    fn assert_refused(&self, run: &Run, reason: &str) {
        assert_eq!(
            (run.exit, run.err.as_str()),
            (2, ""),
            "{reason}: {}",
            run.out
        );
        assert!(
            run.out.starts_with("UNCERTIFIED ") && run.out.contains(reason),
            "{reason}: {}",
            run.out
        );
    }
}

#[test]
fn a_trajectory_is_verified_as_it_is_written() {
    let executed = Executed::new();
    let run = executed.verify(&executed.trajectory, &executed.proof, &executed.problem);
    assert_eq!((run.exit, run.err.as_str()), (0, ""), "{}", run.out);
    assert!(
        run.out.starts_with("verified   ") && run.out.contains(", limits of 7 variables"),
        "{}",
        run.out
    );
    // Checked by somebody else it is the same claim; an answer has it with it.
    let other = executed.place.file("other.json", "");
    let given = [
        "check",
        &executed.trajectory,
        "--timed",
        "--problem",
        &executed.problem,
        "--format",
        "json",
    ];
    let limits = ["--acceleration", "2/s", "--write-certificate", &other];
    let run = executed
        .place
        .taut(&[&given[..], &limits].concat());
    assert_eq!(run.exit, 0, "{}", run.out);
    assert_eq!(
        read(&other)["path_hash"],
        read(&executed.proof)["path_hash"]
    );
    let answer = executed.place.file("answer.json", &run.out);
    for proof in [&other, &answer] {
        let run = executed.verify(&executed.trajectory, proof, &executed.problem);
        assert_eq!(run.exit, 0, "{}", run.out);
    }
}

/// A controller goes by what both points say; so does the checker, and both say which.
#[test]
fn each_kind_of_piece_is_verified() {
    let executed = Executed::new();
    let zeros = || Value::from(vec![0.0; 7]);
    let mixed = executed.changed(|trajectory| {
        let points = trajectory["points"].as_array_mut().unwrap();
        let last = points.len() - 1;
        let mut still = points[last].clone();
        let end = still["time_from_start"]["sec"]
            .as_i64()
            .unwrap();
        points[last]["accelerations"] = zeros();
        for (later, kind) in [(1, "quintic"), (2, "linear"), (3, "linear")] {
            still["time_from_start"]["sec"] = (end + later).into();
            still["positions"][0] = (still["positions"][0].as_f64().unwrap() - 1e-3).into();
            still["accelerations"] = zeros();
            if kind == "linear" {
                let still = still.as_object_mut().unwrap();
                still.remove("velocities");
                still.remove("accelerations");
            }
            points.push(still.clone());
        }
    });
    let proof = executed.place.file("mixed_proof.json", "");
    let run = executed.place.taut(&[
        "check",
        &mixed,
        "--timed",
        "--problem",
        &executed.problem,
        "--keep",
        "hand in ball 2 at 0,0,0",
        "--write-certificate",
        &proof,
    ]);
    assert_eq!(run.exit, 0, "{}{}", run.out, run.err);
    let claimed = read(&proof);
    let kinds = claimed["timed"]["interpolation"]
        .as_array()
        .unwrap();
    assert_eq!(
        kinds[kinds.len() - 4..],
        ["cubic", "quintic", "linear", "linear"].map(Value::from)
    );
    let run = executed.verify(&mixed, &proof, &executed.problem);
    assert_eq!(run.exit, 0, "{}", run.out);
    assert!(run.out.contains("left: "), "{}", run.out);
    // More of the constraint than is left.
    let mut certificate: Certificate = serde_json::from_value(claimed).unwrap();
    certificate.constraints.as_mut().unwrap().left[0][0] = 1.9;
    let text = serde_json::to_string(&certificate.sealed()).unwrap();
    let forged = executed.place.file("forged.json", &text);
    let run = executed.verify(&mixed, &forged, &executed.problem);
    executed.assert_refused(&run, "left, claimed 1.9 m");
}

#[test]
fn another_trajectory_robot_or_scene_is_refused() {
    let executed = Executed::new();
    let changes: [(&str, Change); 4] = [
        ("a point moved by 1e-9", |t| {
            let number = &mut t["points"][3]["positions"][2];
            *number = (number.as_f64().unwrap() + 1e-9).into();
        }),
        ("a time", |t| {
            let number = &mut t["points"][3]["time_from_start"]["nanosec"];
            *number = (number.as_i64().unwrap() + 1).into();
        }),
        ("straight instead of cubic", |t| {
            drop(
                t["points"][3]
                    .as_object_mut()
                    .unwrap()
                    .remove("velocities"),
            )
        }),
        ("a piece less", |t| {
            drop(t["points"].as_array_mut().unwrap().pop())
        }),
    ];
    for (what, change) in changes {
        let changed = executed.changed(change);
        let run = executed.verify(&changed, &executed.proof, &executed.problem);
        assert!(
            run.out
                .contains("about the trajectory with hash"),
            "{what}: {}",
            run.out
        );
        executed.assert_refused(&run, "about the trajectory with hash");
    }
    let scene = changed_problem(&executed.place, "arm_window", |problem| {
        let position = &mut problem["scene"]["objects"][0]["primitive_poses"][0]["position"][0];
        *position = (position.as_f64().unwrap() - 1e-6).into();
    });
    let run = executed.verify(&executed.trajectory, &executed.proof, &scene);
    executed.assert_refused(&run, "about the scene with hash");
    let proof = data("arm_shelf.certificate.json");
    let run = executed.verify(&executed.trajectory, &proof, &executed.problem);
    executed.assert_refused(&run, "it is about a path, and a trajectory was given");
    let run = executed
        .place
        .taut(&["check", &executed.problem, "--certificate", &executed.proof]);
    executed.assert_refused(&run, "it is about a trajectory, and a path was given");
}

#[test]
fn a_forged_claim_of_a_trajectory_is_refused_by_name() {
    let executed = Executed::new();
    type Forgery = fn(&mut Certificate);
    let forgeries: [(Forgery, &str); 7] = [
        (
            |c| c.segments[3].clearance_m = Some(0.3),
            " m apart, claimed 0.3 m",
        ),
        (|c| c.segments[3].clearance_m = None, "nothing can collide"),
        (|c| c.segments.truncate(c.segments.len() - 1), "claims, "),
        (|c| c.robot_hash ^= 1, "about the robot with hash"),
        (
            |c| timed(c).interpolation[1] = Interpolation::Quintic,
            "segment 2: it claims that a controller goes by a quintic function, the points make it go by a cubic one",
        ),
        (
            |c| {
                timed(c)
                    .limits
                    .iter_mut()
                    .for_each(|limit| limit.velocity[1] *= 0.5)
            },
            "the velocity of ",
        ),
        (
            |c| {
                timed(c)
                    .limits
                    .iter_mut()
                    .for_each(|limit| limit.acceleration[0] *= 0.5)
            },
            "the acceleration of ",
        ),
    ];
    for (forgery, reason) in forgeries {
        let forged = executed.forged(forgery);
        let run = executed.verify(&executed.trajectory, &forged, &executed.problem);
        executed.assert_refused(&run, reason);
    }
    // Without a new digest.
    let mut changed = read(&executed.proof);
    changed["timed"]["limits"][0]["velocity"][1] = 9.0.into();
    let changed = executed
        .place
        .file("changed.json", &changed.to_string());
    let run = executed.verify(&executed.trajectory, &changed, &executed.problem);
    executed.assert_refused(&run, "changed after the proof");
}

fn timed(certificate: &mut Certificate) -> &mut TimedClaims {
    certificate.timed.as_mut().unwrap()
}
