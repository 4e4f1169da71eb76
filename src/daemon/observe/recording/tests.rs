use std::path::Path as FilePath;
use std::sync::Arc;

use taut::constraint::ConstraintsFile;
use taut::files::{self, Geometry, Packages, Problem, Reader};
use taut::math::{Pose, Vec3};
use taut::optimize::{Settings, Workspace};
use taut::scene::{Scene, SceneChange};
use taut::store::{PreparedModel, Snapshot};
use taut::translate::Timing;
use taut_ipc::wire::{Code, ResponseFlags, Times};

use super::read::{Recording, parse};
use super::record::RunRecord;
use super::replay::{Replay, Verdict};
use super::write::RunWriter;
use super::{Answer, Question};
use crate::daemon::durability::persisted::RUN;
use crate::daemon::service::client::Client;
use crate::daemon::service::event::Way;
use crate::daemon::service::job::{Job, StopCause};
use taut::answer::{self, Answered};

fn problem(name: &str) -> Problem {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR"))
        .join("config/problems")
        .join(name);
    Reader::new(Packages::default())
        .problem(&file, Geometry::Given)
        .unwrap()
}

fn job(problem: &Problem, scene: Arc<Scene>, number: u64) -> Job {
    let robot = Arc::new(problem.model().unwrap());
    let model = Arc::new(PreparedModel::new(robot.clone(), scene.clone()));
    let scene_hash = scene.hash();
    let weights = vec![1.0; robot.space().nv()];
    let settings = Settings {
        weights: Some(weights.clone()),
        seed: number,
        ..Settings::default()
    };
    let weights = weights.into();
    let scene_version = number;
    let snapshot = Snapshot {
        robot,
        weights,
        scene,
        model,
        scene_id: 7,
        scene_hash,
        scene_version,
    };
    Job {
        id: number,
        request_id: 100 + number,
        client: Client::default(),
        snapshot,
        path: Arc::new(problem.path.clone()),
        settings: Arc::new(settings),
        deadline_ns: None,
        received_ns: 0,
        timing: None,
        priority: 0,
        stop: Arc::default(),
        asked: Default::default(),
    }
}

/// The job's answer when it is told to end at its ask of this number.
fn answer(job: &Job, at: Option<u64>) -> Answer {
    answer_in_parts(job, [at, None])
}

/// The same when it is told so in each of its parts.
fn answer_in_parts(job: &Job, at: [Option<u64>; 2]) -> Answer {
    let mut asked = [0, 0];
    let mut stop = |part| {
        let part = part as usize;
        asked[part] += 1;
        at[part]
            .filter(|at| asked[part] >= *at)
            .map(|_| StopCause::Deadline)
    };
    let Answered { reply, stops, .. } = answer::answer(
        job.question(),
        &mut Workspace::default(),
        &mut stop,
        &mut |_| {},
    );
    Answer {
        reply,
        way: Way::Computed(stops),
    }
}

/// What a file holds that is written like this.
fn written(write: impl FnOnce(&mut RunWriter)) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.taut");
    write(&mut RunWriter::create(&file).unwrap());
    std::fs::read(file).unwrap()
}

fn verdicts(run: &Recording) -> Vec<Verdict> {
    let replay = Replay::new(run);
    let mut workspace = Workspace::default();
    (0..run.requests.len())
        .map(|index| replay.run(index, &mut workspace).verdict)
        .collect()
}

#[test]
fn whenever_it_was_stopped_a_run_gives_the_same_bits_again() {
    let problem = problem("arm_window.json");
    let job = job(&problem, Arc::new(problem.scene.clone()), 1);
    let whole = answer(&job, None);
    assert_eq!(whole.reply.header.code, i32::from(Code::Success));
    // Each stop gives another answer, or the same path after other work; all of them come again.
    let stops: Vec<u64> = (0..12)
        .map(|power| 1 << power)
        .chain([3, 77, 1500])
        .collect();
    let mut lengths = std::collections::BTreeSet::new();
    let bytes = written(|run| {
        for at in stops.iter().map(|at| Some(*at)).chain([None]) {
            let answer = answer(&job, at);
            lengths.insert(answer.reply.header.length_after.to_bits());
            run.request(&Question::of(&job, true)).unwrap();
            run.answer(job.id, &answer).unwrap();
        }
    });
    assert!(lengths.len() > 3, "the stops fall on several paths");
    let run = parse(&bytes).unwrap();
    assert_eq!((run.requests.len(), run.missed, run.torn), (16, None, 0));
    assert!(
        verdicts(&run)
            .iter()
            .all(|verdict| *verdict == Verdict::Equal),
        "{:?}",
        verdicts(&run)
    );
}

#[test]
fn an_answer_that_is_another_is_named() {
    let problem = problem("corner.json");
    let job = job(&problem, Arc::new(problem.scene.clone()), 1);
    let right = answer(&job, None);
    type Change = fn(&mut Answer);
    let changes: [(&str, Change); 4] = [
        ("length_after was", |answer| {
            answer.reply.header.length_after *= 1.0 + f64::EPSILON
        }),
        ("work was", |answer| answer.reply.header.work += 1),
        ("code was TIMED_OUT, is SUCCESS", |answer| {
            answer.reply.header.code = Code::TimedOut.into()
        }),
        ("proved was 0, is 1", |answer| {
            answer.reply.header.flags &= !ResponseFlags::PROVED
        }),
    ];
    for (what, change) in changes {
        let mut wrong = Answer {
            reply: right.reply.clone(),
            way: right.way,
        };
        change(&mut wrong);
        let bytes = written(|run| {
            run.request(&Question::of(&job, true)).unwrap();
            run.answer(job.id, &wrong).unwrap();
        });
        match &verdicts(&parse(&bytes).unwrap())[..] {
            [Verdict::Differs(text)] => assert!(text.contains(what), "{text}"),
            other => panic!("{what}: {other:?}"),
        }
    }
}

#[test]
fn scenes_that_live_robots_and_meshes_stand_there_once() {
    let problem = problem("corner.json");
    let mut scene = Arc::new(problem.scene.clone());
    let id = scene
        .obstacles()
        .iter()
        .next()
        .expect("an obstacle")
        .id
        .clone();
    let mut first = 0;
    let bytes = written(|run| {
        for number in 1..=20 {
            let job = job(&problem, scene.clone(), number);
            run.request(&Question::of(&job, true)).unwrap();
            run.answer(number, &answer(&job, Some(50)))
                .unwrap();
            first = if number == 1 { run.bytes } else { first };
            let pose = Pose::from_translation(Vec3::X * 10.0 * number as f64);
            scene = Arc::new(
                scene
                    .with([SceneChange::Move {
                        id: id.clone(),
                        pose,
                    }])
                    .unwrap(),
            );
        }
        run.write(&RunRecord::Abandoned { number: 20 })
            .unwrap();
        run.write(&RunRecord::Ended { missed: 3 })
            .unwrap();
    });
    let run = parse(&bytes).unwrap();
    let hashes: Vec<u64> = run
        .requests
        .iter()
        .map(|recorded| recorded.question.scene.hash())
        .collect();
    assert_eq!(
        hashes
            .iter()
            .collect::<std::collections::HashSet<_>>()
            .len(),
        20
    );
    assert_eq!((run.missed, run.requests[19].abandoned), (Some(3), true));
    assert!(
        verdicts(&run)
            .iter()
            .all(|verdict| *verdict == Verdict::Equal),
        "{:?}",
        verdicts(&run)
    );
    let twice = written(|run| {
        for number in [1, 1] {
            run.request(&Question::of(
                &job(&problem, Arc::new(problem.scene.clone()), number),
                true,
            ))
            .unwrap();
        }
    });
    assert!(
        (twice.len() as u64) < 2 * first,
        "{} bytes, {first} with an answer for one",
        twice.len()
    );
}

#[test]
fn a_file_that_was_cut_is_read_as_far_as_it_goes_and_a_damaged_one_is_not() {
    let problem = problem("corner.json");
    let job = job(&problem, Arc::new(problem.scene.clone()), 1);
    let bytes = written(|run| {
        run.request(&Question::of(&job, true)).unwrap();
        run.answer(1, &answer(&job, None)).unwrap();
        run.write(&RunRecord::Ended { missed: 0 })
            .unwrap();
    });
    assert_eq!(parse(&bytes).unwrap().missed, Some(0));
    for end in (11..bytes.len()).step_by(97) {
        let run = parse(&bytes[..end]).unwrap();
        assert!(run.missed.is_none() && run.requests.len() <= 1);
        assert!(
            verdicts(&run)
                .iter()
                .all(|verdict| !matches!(verdict, Verdict::Differs(_)))
        );
    }
    for place in (0..bytes.len()).step_by(131) {
        let mut wrong = bytes.clone();
        wrong[place] ^= 0x10;
        // A length that is too large makes the rest look unfinished; all else is seen.
        if let Ok(run) = parse(&wrong) {
            assert!(run.torn > 0, "byte {place}");
        }
    }
    let mut wrong = bytes;
    let last = wrong.len() - 1;
    wrong[last] ^= 1;
    let error = parse(&wrong).err().unwrap();
    assert!(error.starts_with("it is damaged at byte "), "{error}");
}

#[test]
fn what_is_kept_of_constraints_comes_again_to_the_last_bit() {
    let problem = problem("arm_window.json");
    let mut job = job(&problem, Arc::new(problem.scene.clone()), 1);
    let constraints = ConstraintsFile::parse("keep hand in ball 3 at 0,0,0").unwrap();
    let settings = Settings {
        constraints: constraints.clone(),
        work_budget: 20_000,
        ..Settings::clone(&job.settings)
    };
    job.settings = Arc::new(settings);
    let told = answer(&job, None);
    let body = told.reply.body();
    assert_eq!(
        (body.keeps.len(), body.constraints),
        (1, &*constraints.text())
    );
    assert_eq!(body.constraint_claims.len(), body.certificate.len());
    let bytes = written(|run| {
        run.request(&Question::of(&job, true)).unwrap();
        run.answer(job.id, &told).unwrap();
    });
    assert_eq!(verdicts(&parse(&bytes).unwrap()), [Verdict::Equal]);
}

#[test]
fn what_is_no_run_or_of_another_version_is_not_called_damaged() {
    let now = RUN.version;
    for (bytes, expected) in [
        (
            b"taut run 3\n".to_vec(),
            format!("it is a recorded run of version 3, this release reads version {now}; "),
        ),
        (
            b"something else".to_vec(),
            "it is no recorded run".to_owned(),
        ),
        (Vec::new(), "it is no recorded run".to_owned()),
    ] {
        let error = parse(&bytes).err().unwrap();
        assert!(error.starts_with(&expected), "{error}");
    }
}

#[test]
fn times_come_again_to_the_last_bit_wherever_they_were_told_to_end() {
    let problem = problem("arm_window.json");
    let mut job = job(&problem, Arc::new(problem.scene.clone()), 1);
    job.settings = Arc::new(Settings {
        work_budget: 20_000,
        ..Settings::clone(&job.settings)
    });
    let asked = files::Timing::parse("acceleration=2/s work=20000").unwrap();
    let timing = Timing {
        settings: asked
            .unwrap()
            .settings(&job.snapshot.robot, &job.path)
            .unwrap(),
        clearance_m: 1e-3,
        ignores_scaling: true,
    };
    job.timing = Some(Arc::new(timing));
    let told =
        [[None, None], [None, Some(1)], [Some(300), Some(40)]].map(|at| answer_in_parts(&job, at));
    let times = told
        .each_ref()
        .map(|told| Times::try_from(told.reply.header.times).unwrap());
    assert_eq!(times, [Times::Timed, Times::NotReached, Times::Timed]);
    let codes = told
        .each_ref()
        .map(|told| told.reply.header.code);
    assert_eq!(codes[1], i32::from(Code::Untimed));
    assert!(told[1].reply.message().contains("no times yet"));
    let bytes = written(|run| {
        for told in &told {
            run.request(&Question::of(&job, true)).unwrap();
            run.answer(job.id, told).unwrap();
        }
    });
    let run = parse(&bytes).unwrap();
    assert_eq!(verdicts(&run), [(); 3].map(|()| Verdict::Equal));
}
