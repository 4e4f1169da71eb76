//! The table of options: what a request may ask for beside its robot, its scene and its path.
//!
//! Each option is written down once, here. Made of it are the fields of
//! [`Request`](crate::planner::Request) with defaults and checks, the flags and fields of the wire's
//! header, the flags of `taut shorten` and `taut check`, and, by
//! `UPDATE_OPTIONS=1 cargo test -p taut-ipc --test options`, the options of C, C++ and Python and
//! `docs/options.md`.
//!
//! A row's documentation is what people read in every language: one sentence, or a few. Behind it
//! stand the fields of [`Option`](crate::planner::options::Row) that are not as usual.

/// Hands the table to the macro of this name.
macro_rules! option_table {
    ($make:ident) => {
        $make! {
            // field: type = default, field of the wire's header
            scalars {
                /// Time that the request may take, from when it is sent; the best path by then is
                /// the answer
                deadline: Option<Duration> = None, deadline_ns {
                    default: Default::Unset("no limit"), unit: "s", asked: Asked::Check,
                    c: Name::Is("deadline_s"),
                };
                /// Distance that every pair of bodies must keep
                clearance_m: Option<f64> = None, clearance_m {
                    default: Default::Is("1mm"), range: Range::Positive, unit: "m",
                    asked: Asked::Watch, python: Name::Is("clearance"), cpp: Name::Is("clearance"),
                    flag: Name::Is("clearance"),
                };
                /// Most work to spend on a shorter path, in the units of the answer's `work`: the
                /// same on every machine
                work_budget: u64 = 0, work_budget {
                    default: Default::Unset("200,000,000"), metavar: "WORK",
                    python: Name::Is("budget"), cpp: Name::Is("budget"), flag: Name::Is("budget"),
                };
                /// Seed of every random choice
                seed: u64 = 0, seed { default: Default::Is("0"), asked: Asked::Check, };
                /// Version of the scene, of those that are kept
                scene_version: u64 = 0, scene_version {
                    default: Default::Unset("the newest"), asked: Asked::Check,
                    metavar: "VERSION",
                };
                /// Refuse where what a sensor sees of the scene is older than this
                max_age: Option<Duration> = None, max_age_ns {
                    default: Default::Unset("any age"), range: Range::Positive, unit: "s",
                    asked: Asked::Watch, c: Name::Is("max_age_s"),
                };
                /// Optimizer
                mode: Mode = Mode::Hybrid, mode { default: Default::Is("hybrid"), };
                /// Class of the request: one of a higher class is served first
                priority: u32 = 0, priority { default: Default::Is("0"), asked: Asked::Check, };
            }
            // field = default, bit of the wire's flags and its name; the bit says the contrary of
            // the default
            flags {
                /// Refuse a path that keeps less, instead of lowering the clearance of the pairs
                /// that come closer
                strict = false, 0 STRICT { asked: Asked::Watch, };
                /// Take the columns of continuous joints as they stand, as real numbers and not as
                /// angles on the circle
                unwrapped = false, 1 UNWRAPPED { asked: Asked::Watch, };
                /// Look for what is nearest along the path; without it the answer comes sooner
                contacts = true, 2 WITHOUT_CONTACTS { asked: Asked::Check, };
                /// Mode check only: tell again when a change of the scene makes the path unsafe or
                /// safe, until the request is dropped
                watch = false, 3 WATCH {
                    python: Name::Elsewhere("Planner.watch"),
                    flag: Name::Elsewhere("taut check --watch"),
                };
                /// Keep the goal's numbers: refuse a path whose angles lead there only by a step of
                /// more than half a turn, and take no path that ends whole turns away
                keep_goal = false, 5 KEEP_GOAL { asked: Asked::Watch, };
                /// Prove each segment at the largest clearance that it keeps, up to 10 cm, and tell
                /// how far what is executed may stray from the path
                corridor = false, 4 CORRIDOR { asked: Asked::Check, };
            }
            // field: type, place on the wire
            sections {
                /// Names of the path's columns, in the path's order; joints of the robot that are
                /// missing stand still
                columns: Vec<String>, "path, group_mask" {
                    default: Default::Unset("all of the robot's, in its order"),
                    asked: Asked::Watch, c: Name::Is("columns column_count"),
                    flag: Name::Elsewhere("the file's header"),
                };
                /// Where a joint stands that is no column of the path, instead of at 0
                held: Vec<(String, f64)>, "path, held_values" {
                    default: Default::Unset("0"), unit: "rad or m", asked: Asked::Watch,
                    c: Name::Is("held_names held_values held_count"), python: Name::Is("hold"),
                    cpp: Name::Is("hold"), flag: Name::Is("hold"),
                };
                /// Weights of the metric, one per velocity coordinate of the robot
                metric: Vec<f64>, "weights" {
                    default: Default::Unset("metres of reach"), range: Range::Positive,
                    asked: Asked::Check, c: Name::Is("weights weight_count"),
                    cpp: Name::Is("weights"), flag: Name::Elsewhere("--weights"),
                };
                /// Weight of a joint in the metric, by its name, instead of the one that it has
                joint_weights: Vec<(String, f64)>, "weights" {
                    default: Default::Unset("the metric's"), range: Range::Positive,
                    metavar: "NAME=WEIGHT",
                    c: Name::Is("joint_weight_names joint_weights joint_weight_count"),
                    python: Name::Is("weights"), cpp: Name::Is("joint_weight"),
                    flag: Name::Is("joint-weight"),
                };
                /// Waypoints that stay as they are to the last bit, counted from 0; the ends always
                /// do
                fixed_waypoints: Vec<usize>, "fixed_waypoints" {
                    default: Default::Unset("the ends"), metavar: "LIST",
                    c: Name::Is("fixed_waypoints fixed_count"), python: Name::Is("fix"),
                    cpp: Name::Is("fixed"), flag: Name::Is("fix"),
                };
                /// Group of the robot: only its joints may move otherwise than on the path given
                group: Option<String>, "group_mask" {
                    default: Default::Unset("all may"), metavar: "NAME",
                };
                /// What the path must keep besides clearance, see docs/constraints.md: MoveIt's
                /// Constraints in JSON, a list of such, or few words such as
                /// "upright hand:x=0.1"
                constraints: String, "constraints" {
                    default: Default::Unset("nothing"), asked: Asked::Watch,
                    flag: Name::Elsewhere("--path-constraints, --keep-upright, --keep"),
                };
                /// A trajectory along the path, near the least time that the motors allow and proved
                /// as it is written, see docs/timing.md: what they allow, and how it is executed.
                /// MoveIt's joint_limits.yaml, with our words beside it, or few words such as
                /// "acceleration=2/s speed=0.5"
                timing: String, "timing" {
                    default: Default::Unset("no times"), asked: Asked::Check,
                    flag: Name::Elsewhere("--time, --limits, --acceleration, --speed and others"),
                };
            }
        }
    };
}
