//! Daemons of other machines for a program that wants no helper beside it.

mod keeper;

use crate::caller::{Caller, Client};
use crate::network::{Network, NetworkError, declared};
use bytes::Bytes;
use keeper::{Keeper, Planner};
use std::sync::Arc;
use taut_ipc::ClientError;
use taut_ipc::control::{ControlReply, ControlRequest};
use taut_ipc::planner::Carrier;
use taut_ipc::planner::carrier::{Asked, Inbox};
use zenoh::bytes::ZBytes;

/// Daemons through Zenoh, for [`taut_ipc::planner::Planner::through`].
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use taut_ipc::planner::Planner;
/// use taut_zenoh::{Network, Zenoh};
/// let planner = Planner::through(Zenoh::connect(&Network::to(&["tcp/cell-7:7447"]))?);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Zenoh {
    caller: Arc<Caller>,
    client: Arc<Client>,
    keeper: Keeper,
}

impl Zenoh {
    /// Connects, as a client that is called as this process is.
    ///
    /// # Errors
    /// [`NetworkError`]. Gateways that are not there yet are no error: requests wait a second for
    /// them.
    pub fn connect(network: &Network) -> Result<Self, NetworkError> {
        Self::to(network, &[])
    }

    /// The same, to these daemons alone, the best first.
    ///
    /// # Errors
    /// [`NetworkError`].
    pub fn to(network: &Network, daemons: &[String]) -> Result<Self, NetworkError> {
        let caller = Caller::open(network, daemons)?;
        let keeper = declared("a thread for requests", Keeper::start())?;
        let thread = keeper.thread().clone();
        caller.live.wakes(move || thread.unpark());
        let client = Arc::new(caller.client(own_name())?);
        Ok(Self {
            caller,
            client,
            keeper,
        })
    }

    /// Requests sent more than once, and final answers that came after the first and were dropped.
    pub fn counts(&self) -> (u64, u64) {
        self.caller.counts()
    }
}

/// `host/program[pid]`.
fn own_name() -> String {
    let read = |file| std::fs::read_to_string(file).unwrap_or_default();
    let host = read("/proc/sys/kernel/hostname");
    let program = read("/proc/self/comm");
    let pid = std::process::id();
    format!("{}/{}[{pid}]", host.trim_end(), program.trim_end())
}

/// The sections of a request, which travel from where they are.
struct Words(Asked);

impl AsRef<[u8]> for Words {
    fn as_ref(&self) -> &[u8] {
        self.0.payload()
    }
}

impl Carrier for Zenoh {
    fn control(&self, message: ControlRequest) -> ControlReply {
        self.caller.control(&self.client, &message)
    }

    fn send(&self, asked: Asked, inbox: Inbox) -> Result<(), ClientError> {
        let header = asked.header;
        let payload = ZBytes::from(Bytes::from_owner(Words(asked)));
        let thread = self.keeper.thread().clone();
        inbox.ending().wakes(thread.clone());
        let planner = Planner::new(inbox, self.keeper.requests());
        let wake = move || thread.unpark();
        let call = self
            .caller
            .call(&self.client, header, payload, planner, wake);
        self.keeper.begin(header.request_id, call);
        Ok(())
    }
}
