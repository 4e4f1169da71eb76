//! The gate against false proofs: random robots, scenes and paths are written as files, taut says
//! "proved", and what it hands back is executed number by number, as a controller does, by means
//! that share nothing with taut. Collisions that it reports are looked at, too.
//!
//! The short form runs with all tests. The long form, a million proved segments:
//! `TAUT_CASES=16000 TAUT_SEED=$RANDOM cargo test --release --test false_proofs -- --nocapture`.
//! A case is found again by its number: `TAUT_FIRST=NUMBER TAUT_CASES=1` with the same seed.
//!
//! `make` draws a robot, a scene and paths; `write` writes them, `read` reads meshes and exported
//! paths back by readers of its own. `world` has what the files mean, `execute` moves it and looks
//! (`distance`) how near bodies come.

mod binary;
mod case;
mod distance;
mod execute;
mod library;
mod make;
mod pose;
mod read;
mod robot;
mod shape;
mod solid;
mod summary;
mod theme;
mod verdict;
mod world;
mod write;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use fastrand::Rng;
use taut::optimize::{Mode, Settings};

use case::Case;
use library::Answer;
use make::pick;
use summary::{Asked, Refuted, Summary};
use theme::Theme;

/// Cases of the short form.
const CASES: u64 = 540;
const SEED: u64 = 20_260;
/// What the folders of cases begin with.
const SCRATCH: &str = "false_proof";
/// Paths of a case that are checked, and that are shortened.
const CHECKED: usize = 12;
const SHORTENED: usize = 6;
/// One case of so many also goes through the command line; of every theme, since it has no factor
/// of their number.
const BY_COMMAND: u64 = 13;

/// Which cases to run.
#[derive(Clone, Debug)]
struct Plan {
    cases: u64,
    seed: u64,
    first: u64,
    /// Cases are all of this theme.
    theme: Option<Theme>,
}

impl Plan {
    fn from_environment() -> Self {
        let number = |name: &str| {
            std::env::var(name)
                .ok()
                .and_then(|text| text.parse::<u64>().ok())
        };
        let named = std::env::var("TAUT_THEME").ok();
        let theme = named.map(|name| {
            Theme::ALL
                .into_iter()
                .find(|theme| format!("{theme:?}") == name)
        });
        Self {
            cases: number("TAUT_CASES").unwrap_or(CASES),
            seed: number("TAUT_SEED").unwrap_or(SEED),
            first: number("TAUT_FIRST").unwrap_or(0),
            theme: theme.map(|theme| theme.expect("TAUT_THEME is one of Theme")),
        }
    }

    fn theme_of(&self, case: u64) -> Theme {
        self.theme
            .unwrap_or(Theme::ALL[(case % Theme::ALL.len() as u64) as usize])
    }
}

#[test]
fn what_is_proved_is_free_when_its_numbers_are_executed() {
    let plan = Plan::from_environment();
    let begun = Instant::now();
    let next = AtomicU64::new(plan.first);
    let all = Mutex::new(Summary::default());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, std::num::NonZero::get) {
            scope.spawn(|| {
                let mut own = Summary::default();
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= plan.first + plan.cases {
                        break;
                    }
                    run(&plan, number, &mut own);
                }
                all.lock()
                    .expect("no thread has panicked")
                    .add(own);
            });
        }
    });
    let summary = all
        .into_inner()
        .expect("no thread has panicked");
    let Plan { cases, seed, .. } = plan;
    println!(
        "{cases} cases of seed {seed}, {}\n{summary}",
        summary::minutes(begun.elapsed())
    );
    assert!(
        summary.refuted.is_empty(),
        "{} answers are refuted:\n{summary}",
        summary.refuted.len()
    );
    if plan.theme.is_none() && cases >= CASES {
        summary.assert_says_something();
    }
}

/// Runs a case; its files stay where something is refuted.
fn run(plan: &Plan, number: u64, summary: &mut Summary) {
    let mut rng = Rng::with_seed(
        plan.seed
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(number),
    );
    let prefix = format!("{SCRATCH}_{}_{number}_", plan.seed);
    let scratch = tempfile::Builder::new()
        .prefix(&prefix)
        .tempdir_in(env!("CARGO_TARGET_TMPDIR"));
    let scratch = scratch.expect("the build's scratch folder can be written");
    let case = Case::new(&mut rng, plan.theme_of(number), scratch.path());
    summary.cases += 1;
    let mut run = Run {
        number,
        case: &case,
        rng,
        summary,
        is_refuted: false,
    };
    match library::load(&case) {
        Ok(loaded) if !case.names.is_empty() => {
            run.in_process(loaded);
            if number.is_multiple_of(BY_COMMAND)
                && case.files.diff.is_none()
                && case.theme != Theme::RestContacts
            {
                run.by_command();
            }
        }
        Ok(_) => {}
        Err(reason) => run.summary.unread(case.theme, &reason),
    }
    if run.is_refuted {
        let _ = scratch.keep();
    }
}

/// One case on its way.
struct Run<'a> {
    number: u64,
    case: &'a Case,
    rng: Rng,
    summary: &'a mut Summary,
    is_refuted: bool,
}

impl Run<'_> {
    fn in_process(&mut self, mut loaded: library::Loaded) {
        let checking = Settings {
            mode: Mode::Check,
            contacts: false,
            ..Settings::default()
        };
        for index in 0..CHECKED {
            let Some(made) = self.case.path(&mut self.rng) else {
                continue;
            };
            let file = self.write(&made, index);
            let answer = loaded.ask(self.case, &file, &checking);
            self.judge(Asked::Check, &made, answer);
        }
        for index in CHECKED..CHECKED + SHORTENED {
            let Some(made) = self.case.long_path(&mut self.rng) else {
                continue;
            };
            let file = self.write(&made, index);
            // What pushes is what leaves soft limits.
            let pushes = self.case.theme == Theme::SoftLimits;
            let modes = if pushes {
                &[Mode::Gradient, Mode::Contact, Mode::Hybrid][..]
            } else {
                &Mode::ALL[1..]
            };
            let mode = pick(&mut self.rng, modes);
            let work_budget = if pushes {
                10_000
            } else {
                pick(&mut self.rng, &[200, 2_000, 10_000])
            };
            let settings = Settings {
                mode,
                seed: self.rng.u64(..),
                work_budget,
                ..checking.clone()
            };
            let answer = loaded.ask(self.case, &file, &settings);
            self.judge(Asked::Shorten, &made, answer);
        }
    }

    fn by_command(&mut self) {
        for _ in 0..2 {
            let Some(made) = self.case.path(&mut self.rng) else {
                continue;
            };
            let file = self.write(&made, 100);
            self.judge(Asked::CommandCheck, &made, binary::check(self.case, &file));
        }
        if let Some(made) = self.case.long_path(&mut self.rng) {
            let file = self.write(&made, 101);
            let ending = if self.rng.bool() { "csv" } else { "yaml" };
            self.judge(
                Asked::Export,
                &made,
                binary::export(self.case, &file, ending),
            );
        }
    }

    /// Writes a path as one of the forms that users have.
    fn write(&mut self, made: &make::path::Made, index: usize) -> std::path::PathBuf {
        let robot = &self.case.world.robot;
        let (text, ending) = match made.constraint {
            Some(constraint) => (write::path::request(robot, &made.rows, constraint), "yaml"),
            None => write::path::path(robot, &made.rows, self.rng.usize(..)),
        };
        let file = self
            .case
            .files
            .folder
            .join(format!("path{index}.{ending}"));
        std::fs::write(&file, text).expect("the scratch folder can be written");
        file
    }

    fn judge(&mut self, asked: Asked, made: &make::path::Made, answer: Answer) {
        match answer {
            Answer::Unread(reason) => self.summary.unread(self.case.theme, &reason),
            Answer::Refused(refused) => {
                let against = verdict::false_collision(self.case, made, &refused);
                self.summary.refused(refused.reason);
                self.found(asked, made, against);
            }
            Answer::Proved(proved) => {
                let verdict = verdict::of(self.case, made, &proved);
                self.found(asked, made, verdict.against.clone());
                self.summary
                    .proved(self.case, asked, &made.steps, &proved.rows, &verdict);
            }
        }
    }

    fn found(&mut self, asked: Asked, made: &make::path::Made, against: Option<String>) {
        let Some(what) = against else { return };
        self.is_refuted = true;
        self.summary.refuted.push(Refuted {
            case: self.number,
            theme: self.case.theme,
            asked,
            steps: made.steps.clone(),
            what,
            folder: self.case.files.folder.display().to_string(),
            after: self.summary.of_theme(self.case.theme),
        });
    }
}
