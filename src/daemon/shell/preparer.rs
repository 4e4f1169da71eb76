//! Threads that make collision models before their first request is computed, so that nobody else
//! waits for them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread::JoinHandle;

use crossbeam_channel::{Receiver, Sender, unbounded};
use taut::store::PreparedModel;
use taut_ipc::monotonic_ns;

use crate::daemon::service::event::Event;
use crate::daemon::threads::spawn_nice;

/// Models made at once: a large one does not keep a small one waiting.
const THREADS: usize = 2;

/// Where models go that are to be made.
pub(super) type ToPrepare = Sender<Arc<PreparedModel>>;

/// Starts the preparers, which tell of each model that they have made; they end when the sender is
/// dropped.
pub(super) fn start(
    niceness: i32,
    tell: impl Fn(Event) -> bool + Clone + Send + 'static,
) -> std::io::Result<(ToPrepare, Vec<JoinHandle<()>>)> {
    let (models, receiver) = unbounded();
    let threads =
        (0..THREADS).map(|index| preparer(index, niceness, receiver.clone(), tell.clone()));
    Ok((models, threads.collect::<Result<_, _>>()?))
}

fn preparer(
    index: usize,
    niceness: i32,
    models: Receiver<Arc<PreparedModel>>,
    tell: impl Fn(Event) -> bool + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    spawn_nice(&format!("taut-preparer-{index}"), niceness, move || {
        for model in models {
            model.begin(monotonic_ns());
            make(&model);
            if !tell(Event::Prepared) {
                return;
            }
        }
    })
}

/// One that panics is made again by its request's worker, which answers with what it says.
fn make(model: &PreparedModel) {
    let made = catch_unwind(AssertUnwindSafe(|| model.get().is_ok()));
    if made.is_err() {
        model.give_up();
    }
}
