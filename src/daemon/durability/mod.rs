//! What survives the daemon: robots and scenes, as they were when it ended.

pub(crate) mod journal;
pub(crate) mod persisted;
pub(crate) mod prepared;
pub(crate) mod record_log;
pub(crate) mod restore;
