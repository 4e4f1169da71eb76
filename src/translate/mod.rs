//! The only place that sees wire and domain types together; the daemon and programs that answer
//! requests in their own process say the same by it.

mod answer;
mod client;
mod contents;
mod error;
mod frame;
mod lengths;
mod models;
mod number;
mod points;
mod records;
mod request;
mod result_times;
mod sections;
mod times;
mod timing;
mod warmth;

pub use answer::{
    Reply, StopCause, answered, code_of, expired, preempted, progress, refused, timed,
};
pub use client::{outcome, result_corridor};
pub use contents::{
    ReadRobot, Unread, diff_of, prepared, read_robot, reader, robot_of, scene_of, scene_text,
    selected, selected_label, warm_scene,
};
pub use error::AnswerError;
pub use frame::{Scenery, TakenFrame, check_seen, is_too_old, read_frame};
pub use lengths::Lengths;
pub use models::{
    describe, file_refusal, frame_refusal, model_refusal, name_refusal, robot_files, robot_source,
    robot_summary, scene_refusal, scene_state, scene_summary, store_refusal, worlds,
};
pub use request::{Question, check_layout, question, request_refusal, wanted, wanted_newest};
pub use result_times::result_times;
pub use times::{TimedPath, Times};
pub use timing::Timing;
pub use warmth::{loading, model_states, so_far, step_words, still_loading};
