//! `--check`: what a proof costs, a refusal, and the sampling that others do.

mod figures;
mod measure;
mod report;

pub(super) use measure::measure;
pub(super) use report::{Report, Row};
