//! Handles: what a caller holds, and what is alive behind it.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use taut_ipc::planner::PlannerError;
use taut_ipc::wire::Code;

/// Ids are never used twice and never shared by two kinds, so that no old or foreign handle is
/// taken for another.
static LAST: AtomicUsize = AtomicUsize::new(0);

/// What lives behind the handles of one kind.
pub(crate) struct Table<T>(Mutex<BTreeMap<usize, Arc<T>>>);

impl<T> Table<T> {
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    fn live(&self) -> MutexGuard<'_, BTreeMap<usize, Arc<T>>> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// An opaque type of the header.
pub(crate) trait Handle: Sized + 'static {
    /// What is behind it.
    type Value: Send + Sync + 'static;
    /// Its name in the header.
    const NAME: &'static str;

    fn table() -> &'static Table<Self::Value>;

    /// A new handle.
    fn of(value: Self::Value) -> *mut Self {
        // Even, as pointers are, so that nobody's tagging of them goes wrong.
        let id = (LAST.fetch_add(1, Ordering::Relaxed) + 1) << 4;
        Self::table().live().insert(id, Arc::new(value));
        std::ptr::without_provenance_mut(id)
    }

    /// What is behind a handle.
    fn get(handle: *const Self) -> Result<Arc<Self::Value>, PlannerError> {
        Self::table()
            .live()
            .get(&handle.addr())
            .cloned()
            .ok_or_else(|| Self::none(handle))
    }

    /// Ends a handle; what was behind it, if it was one.
    fn end(handle: *const Self) -> Option<Arc<Self::Value>> {
        Self::table().live().remove(&handle.addr())
    }

    fn none(handle: *const Self) -> PlannerError {
        let what = if handle.is_null() {
            "is NULL"
        } else {
            "was freed, or never was one"
        };
        wrong(format!(
            "the {} {what}; give one that taut made and that is not freed",
            Self::NAME
        ))
    }
}

/// A call that is wrong in itself.
pub(crate) fn wrong(message: impl Into<String>) -> PlannerError {
    PlannerError::Invalid {
        code: Code::MalformedRequest,
        message: message.into(),
    }
}
