//! The only place that sees wire and domain types together.

mod answer;
mod client;
mod models;
mod records;
mod request;
mod sections;

pub use answer::code_of;
pub(super) use answer::{Reply, answered, expired, preempted, progress, refused};
pub use client::{AnswerError, outcome, request_header};
pub use models::robot_source;
pub(super) use models::{
    describe, file_refusal, model_refusal, name_refusal, robot_files, robot_summary, scene_refusal, scene_state,
    scene_summary, store_refusal,
};
pub(super) use request::{request_refusal, settings_and_path};
