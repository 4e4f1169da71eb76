//! Control messages about recordings.

use std::path::PathBuf;

use taut_ipc::control::{ControlReply, Refusal};
use taut_ipc::wire::Code;

use super::Service;
use super::control::check_absolute;
use super::event::Ticket;

impl Service {
    /// Begins to record, or tells how it goes.
    pub(super) fn record(
        &mut self,
        ticket: Ticket,
        file: PathBuf,
    ) -> Result<Option<ControlReply>, Refusal> {
        check_absolute(&file)?;
        let state = self
            .recorder
            .record(file, ticket, self.now_ns)?;
        Ok(state.map(ControlReply::Recording))
    }

    /// Ends the recording.
    pub(super) fn end_recording(
        &mut self,
        ticket: Ticket,
    ) -> Result<Option<ControlReply>, Refusal> {
        self.recorder.end(Some(ticket))?;
        Ok(None)
    }

    /// Writes one request to a file of its own.
    pub(super) fn bundle(
        &mut self,
        ticket: Ticket,
        id: &str,
        file: PathBuf,
    ) -> Result<Option<ControlReply>, Refusal> {
        check_absolute(&file)?;
        let stories = self.stories.find(id);
        let known = stories.first().ok_or_else(|| unknown(id))?;
        let story = serde_json::to_string(&stories).expect("stories hold only plain values");
        self.recorder
            .bundle(known.request_id, file, story, ticket)?;
        Ok(None)
    }
}

fn unknown(id: &str) -> Refusal {
    let text =
        format!("no request {id} among the last ones; `taut why` without an id lists the newest");
    Refusal::new(Code::InvalidObjectName, text)
}
