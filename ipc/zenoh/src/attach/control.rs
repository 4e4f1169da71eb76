//! Control messages of planners of this machine.

use crate::caller::{Caller, Client};
use crate::network::NetworkError;
use std::sync::Arc;
use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::server::IncomingControl;
use taut_ipc::wire::Code;

/// Has a thread do it: some take minutes.
pub(super) fn start(
    caller: &Arc<Caller>,
    client: Result<Arc<Client>, NetworkError>,
    message: IncomingControl,
) {
    let caller = caller.clone();
    let work = move || {
        let reply = answer(&caller, client, &message);
        if let Err(error) = message.reply(&reply) {
            tracing::warn!("a control reply was not sent: {error}");
        }
    };
    let builder = std::thread::Builder::new().name("taut-control".into());
    if let Err(error) = builder.spawn(work) {
        tracing::error!("no thread for a control message: {error}");
    }
}

fn answer(
    caller: &Arc<Caller>,
    client: Result<Arc<Client>, NetworkError>,
    message: &IncomingControl,
) -> ControlReply {
    let client = match client {
        Ok(client) => client,
        Err(error) => return refused(Code::ResourceExhausted, error.to_string()),
    };
    match message.message() {
        Ok(ControlRequest::Introduce { .. }) => ControlReply::Done,
        Ok(message) => caller.control(&client, &message),
        Err(refusal) => ControlReply::Refused(refusal),
    }
}

fn refused(code: Code, message: String) -> ControlReply {
    ControlReply::Refused(Refusal::new(code, message))
}
