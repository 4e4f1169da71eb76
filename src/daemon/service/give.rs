//! Files from clients of other machines: taken in pieces, and read from where they are named.

use std::sync::Arc;

use taut_ipc::control::{ControlReply, FileId, Files, Refusal};
use taut_ipc::wire::Code;

use super::Service;
use super::contents::Taken;
use super::control::{Replied, told};
use super::effect::{Effect, Source, Work};
use super::event::{Purpose, Ticket};

impl Service {
    /// Takes a piece of a file.
    pub(super) fn give(
        &mut self,
        ticket: Ticket,
        file: FileId,
        offset: u64,
        bytes: Vec<u8>,
    ) -> Replied {
        match self
            .contents
            .give(ticket, file, offset, bytes)?
        {
            Taken::UpTo(bytes) => Ok(Some(ControlReply::Given { bytes })),
            Taken::Waits => Ok(None),
            Taken::ToCheck(pieces) => {
                self.have_done(ticket, Work::Check { file, pieces });
                Ok(None)
            }
        }
    }

    /// All of a file was compared with its name; `None` where it is not what that says.
    pub(super) fn checked(&mut self, file: &FileId, content: Option<Arc<[u8]>>) {
        let reply = match &content {
            Some(_) => ControlReply::Given { bytes: file.bytes },
            None => ControlReply::Refused(not_its_content(file)),
        };
        for ticket in self.contents.checked(file, content) {
            self.effects
                .push(Effect::Reply(ticket, Box::new(reply.clone())));
        }
    }

    /// Has something read from the files that were given, where any were.
    pub(super) fn load_from(
        &mut self,
        ticket: Ticket,
        label: String,
        purpose: Purpose,
        source: Source,
        files: Option<&Files>,
    ) -> Replied {
        let given = files.map(|files| self.contents.gather(files));
        match given.transpose() {
            Ok(given) => self.load(ticket, label, purpose, source, given),
            Err(unread) => told(unread),
        }
    }
}

fn not_its_content(file: &FileId) -> Refusal {
    let text = format!("what came is not file {file}: it changed while it was sent; send it again");
    Refusal::new(Code::MalformedRequest, text)
}
