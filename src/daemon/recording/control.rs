//! Control messages about recordings.

use std::path::{Path, PathBuf};

use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::monotonic_ns;
use taut_ipc::server::IncomingControl;
use taut_ipc::wire::Code;

use super::Recorder;
use crate::daemon::event_loop::EventLoop;
use crate::daemon::keep::reply;

impl EventLoop {
    /// Begins to record, or tells how it goes.
    pub(in crate::daemon) fn record(&mut self, control: IncomingControl, file: PathBuf) {
        if let Err(refusal) = absolute(&file) {
            return reply(control, &ControlReply::Refused(refusal));
        }
        let token = self.next_number();
        match self.recorder.record(file, token, monotonic_ns()) {
            Ok(Some(state)) => reply(control, &ControlReply::Recording(state)),
            Ok(None) => self.wait_for_thread(control, token),
            Err(refusal) => reply(control, &ControlReply::Refused(refusal)),
        }
    }

    /// Ends the recording.
    pub(in crate::daemon) fn end_recording(&mut self, control: IncomingControl) {
        self.ask_recorder(control, |recorder, token| recorder.end(Some(token)));
    }

    /// Writes one request to a file of its own.
    pub(in crate::daemon) fn bundle(&mut self, control: IncomingControl, id: &str, file: PathBuf) {
        let stories = self.stories.find(id);
        let known = stories
            .first()
            .map(|story| story.request_id)
            .ok_or_else(|| {
                let text = format!(
                    "no request {id} among the last ones; `taut why` without an id lists the newest"
                );
                Refusal::new(Code::InvalidObjectName, text)
            });
        let story = serde_json::to_string(&stories).expect("stories hold only plain values");
        self.ask_recorder(control, |recorder, token| {
            absolute(&file)?;
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
            Ok(()) => self.wait_for_thread(control, token),
            Err(refusal) => reply(control, &ControlReply::Refused(refusal)),
        }
    }
}

fn absolute(file: &Path) -> Result<(), Refusal> {
    match file.is_absolute() {
        true => Ok(()),
        false => {
            let text = format!("{}: name files by absolute paths", file.display());
            Err(Refusal::new(Code::MalformedRequest, text))
        }
    }
}
