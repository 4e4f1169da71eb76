//! Control messages about recordings.

use std::path::PathBuf;

use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::monotonic_ns;
use taut_ipc::server::IncomingControl;
use taut_ipc::wire::Code;

use super::Recorder;
use crate::daemon::control::check_absolute;
use crate::daemon::event_loop::EventLoop;
use crate::daemon::keep::{refuse, reply};

impl EventLoop {
    /// Begins to record, or tells how it goes.
    pub(in crate::daemon) fn record(&mut self, control: IncomingControl, file: PathBuf) {
        if let Err(refusal) = check_absolute(&file) {
            return refuse(control, refusal);
        }
        let token = self.next_number();
        match self
            .recorder
            .record(file, token, monotonic_ns())
        {
            Ok(Some(state)) => reply(control, &ControlReply::Recording(state)),
            Ok(None) => self.loading.wait(control, token),
            Err(refusal) => refuse(control, refusal),
        }
    }

    /// Ends the recording.
    pub(in crate::daemon) fn end_recording(&mut self, control: IncomingControl) {
        self.ask_recorder(control, |recorder, token| recorder.end(Some(token)));
    }

    /// Writes one request to a file of its own.
    pub(in crate::daemon) fn bundle(&mut self, control: IncomingControl, id: &str, file: PathBuf) {
        let stories = self.stories.find(id);
        let known = stories.first().map(|story| story.request_id);
        let known = known.ok_or_else(|| unknown(id));
        let story = serde_json::to_string(&stories).expect("stories hold only plain values");
        self.ask_recorder(control, |recorder, token| {
            check_absolute(&file)?;
            recorder.bundle(known?, file, story, token)
        });
    }

    fn ask_recorder(
        &mut self,
        control: IncomingControl,
        ask: impl FnOnce(&mut Recorder, u64) -> Result<(), Refusal>,
    ) {
        let token = self.next_number();
        match ask(&mut self.recorder, token) {
            Ok(()) => self.loading.wait(control, token),
            Err(refusal) => refuse(control, refusal),
        }
    }
}

fn unknown(id: &str) -> Refusal {
    let text =
        format!("no request {id} among the last ones; `taut why` without an id lists the newest");
    Refusal::new(Code::InvalidObjectName, text)
}
