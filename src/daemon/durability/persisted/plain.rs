//! Poses, vectors and warnings.

use serde::{Deserialize, Serialize};
use taut::math::{Pose, Quat, Vec3};
use taut::warning::{Warning, WarningClass};

/// A pose.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct PoseRecord {
    /// Unit quaternion x y z w.
    rotation: [f64; 4],
    translation: [f64; 3],
}

impl From<Pose> for PoseRecord {
    fn from(pose: Pose) -> Self {
        Self {
            rotation: pose.rotation.to_array(),
            translation: pose.translation.to_array(),
        }
    }
}

impl From<PoseRecord> for Pose {
    fn from(record: PoseRecord) -> Self {
        Self::from_parts(
            Vec3::from_array(record.translation),
            Quat::from_array(record.rotation),
        )
    }
}

/// A line for people.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct WarningRecord {
    class: ClassRecord,
    text: String,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
enum ClassRecord {
    Uncovered,
    Cosmetic { topic: String },
}

impl WarningRecord {
    /// The records of warnings.
    pub fn all(warnings: &[Warning]) -> Vec<Self> {
        warnings.iter().map(Self::from).collect()
    }

    /// The warnings of records.
    pub fn restored(records: Vec<Self>) -> Vec<Warning> {
        records.into_iter().map(Warning::from).collect()
    }
}

impl From<&Warning> for WarningRecord {
    fn from(warning: &Warning) -> Self {
        let class = match warning.class() {
            WarningClass::Uncovered => ClassRecord::Uncovered,
            WarningClass::Cosmetic { topic } => ClassRecord::Cosmetic {
                topic: topic.clone(),
            },
        };
        Self {
            class,
            text: warning.text().to_owned(),
        }
    }
}

impl From<WarningRecord> for Warning {
    fn from(record: WarningRecord) -> Self {
        match record.class {
            ClassRecord::Uncovered => Self::uncovered(record.text),
            ClassRecord::Cosmetic { topic } => Self::cosmetic(&topic, record.text),
        }
    }
}
