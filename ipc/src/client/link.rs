//! The ports of one client.

use super::ClientError;
use super::Loss;
use super::refused::{from_loan, from_send};
use crate::control::{ControlReply, ControlRequest, decode, encode};
use crate::instance::Instance;
use crate::limits::*;
use crate::lock::{DaemonProbe, DaemonState};
use crate::memory::{self, Room};
use crate::time::monotonic_ns;
use crate::transport::{self, ServiceNode, Variant};
use crate::wire::{
    ControlHeader, ControlReplyHeader, RequestHeader, ResponseHeader, Section, WireError,
};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client as Port;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy};
use iceoryx2::request_mut::RequestMut;
use iceoryx2::service::port_factory::event;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

pub(super) type OptimizePort = Port<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
pub(super) type ControlPort = Port<Variant, [u8], ControlHeader, [u8], ControlReplyHeader>;
pub(super) type Stream = PendingResponse<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
pub(super) type OptimizeLoan = RequestMut<Variant, [u8], RequestHeader, [u8], ResponseHeader>;
type ControlStream = PendingResponse<Variant, [u8], ControlHeader, [u8], ControlReplyHeader>;
pub(super) type ControlLoan = RequestMut<Variant, [u8], ControlHeader, [u8], ControlReplyHeader>;

/// The ports, shared by the client, its requests in flight and its feeds.
#[derive(Debug)]
pub(super) struct Link {
    optimize: OptimizePort,
    control: ControlPort,
    notifier: Notifier<Variant>,
    listeners: Mutex<Vec<Listener<Variant>>>,
    listener_service: event::PortFactory<Variant>,
    pub(super) node: ServiceNode,
    probe: DaemonProbe,
    /// When a daemon was last known to serve these services, in monotonic nanoseconds; 0 = there is
    /// doubt.
    served_ns: AtomicU64,
    /// Whether something was sent of which nobody knows that the daemon received it.
    is_unheard: AtomicBool,
    root: String,
    room: Room,
}

impl Link {
    pub(super) fn open(instance: &Instance) -> Result<Self, ClientError> {
        let root = instance.root().display().to_string();
        let lost = |loss| ClientError::DaemonLost {
            root: root.clone(),
            loss,
        };
        let probe = DaemonProbe::open(instance)?.ok_or_else(|| lost(Loss::NeverStarted))?;
        let state = probe.state();
        Self::open_to(instance, probe, state, root.clone()).map_err(|error| match error {
            // A daemon announces itself when all of them are there.
            ClientError::Setup { reason, .. } if is_absence(&reason) => lost(Loss::Removed),
            ClientError::Setup { .. } | ClientError::Instance(_) if !is_still(instance, state) => {
                lost(Loss::Removed)
            }
            other => other,
        })
    }

    /// Opens the ports of a daemon that its lock file tells of.
    fn open_to(
        instance: &Instance,
        probe: DaemonProbe,
        state: DaemonState,
        root: String,
    ) -> Result<Self, ClientError> {
        let lost = |loss| ClientError::DaemonLost {
            root: root.clone(),
            loss,
        };
        instance.check_private()?;
        let generation = match state {
            DaemonState::Running { wire_version, .. } if wire_version != WIRE_VERSION => {
                return Err(WireError::Version(wire_version).into());
            }
            DaemonState::Running { generation, .. } => generation,
            DaemonState::Starting => return Err(lost(Loss::Starting)),
            DaemonState::Absent => return Err(lost(Loss::NotRunning)),
        };
        if memory::free_bytes() == 0 {
            return Err(ClientError::NoMemory(0));
        }
        let node = transport::node(instance, generation);
        let node = node.map_err(|error| ClientError::setup("node", error))?;
        Self::with_ports(node, probe, root)
    }

    fn with_ports(
        node: ServiceNode,
        probe: DaemonProbe,
        root: String,
    ) -> Result<Self, ClientError> {
        let listener_service = opened("wake-client", transport::wake_client(&node).open())?;
        let wake_server = opened("wake-server", transport::wake_server(&node).open())?;
        let first = opened("listener", transport::listener(&listener_service))?;
        Ok(Self {
            optimize: optimize_port(&node)?,
            control: control_port(&node)?,
            notifier: opened("notifier", wake_server.notifier_builder().create())?,
            listeners: Mutex::new(vec![first]),
            listener_service,
            node,
            probe,
            served_ns: AtomicU64::new(monotonic_ns()),
            is_unheard: AtomicBool::new(false),
            root,
            room: Room::default(),
        })
    }

    /// Whether no daemon will ever serve these services again. Asks the system only where that is
    /// in doubt, or was not known for a while.
    pub(super) fn is_stale(&self) -> bool {
        let now_ns = monotonic_ns();
        let age_ns = now_ns.saturating_sub(self.served_ns.load(Ordering::Relaxed));
        if u128::from(age_ns) < PROBE_INTERVAL.as_nanos() {
            return false;
        }
        match self.probe.state() {
            DaemonState::Running { generation, .. } => {
                let is_served = generation == self.node.generation;
                self.served_ns
                    .store(if is_served { now_ns } else { 0 }, Ordering::Relaxed);
                !is_served
            }
            DaemonState::Starting | DaemonState::Absent => !self.probe.is_in_place(),
        }
    }

    pub(super) fn loan(&self, bytes: usize) -> Result<OptimizeLoan, ClientError> {
        self.check_room(bytes)?;
        self.optimize
            .loan_slice(bytes)
            .map_err(|error| from_loan(error, bytes))
    }

    /// Sends a control message and waits for its reply, or until `stop` says so.
    pub(super) fn control(
        &self,
        message: &ControlRequest,
        request_id: u64,
        timeout: Duration,
        stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError> {
        let bytes = encode(message)?;
        let mut loan = self.loan_control(bytes.len())?;
        loan.payload_mut().copy_from_slice(&bytes);
        let header = ControlHeader {
            request_id,
            message: section(0, bytes.len()),
            ..ControlHeader::default()
        };
        self.exchange(loan, header, timeout, stop)
    }

    /// Sends what was written to a loan, and waits for its reply.
    pub(super) fn exchange(
        &self,
        loan: ControlLoan,
        header: ControlHeader,
        timeout: Duration,
        stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError> {
        let boot_id = self.running()?;
        let listener = self.take_listener()?;
        let stream = self.dispatch_control(loan, header, &listener, boot_id)?;
        let reply = self.reply(&stream, &listener, boot_id, timeout, stop);
        if reply.is_err() {
            self.was_unheard();
        }
        reply
    }

    fn dispatch_control(
        &self,
        mut request: ControlLoan,
        header: ControlHeader,
        listener: &WaitFor<'_>,
        boot_id: u64,
    ) -> Result<ControlStream, ClientError> {
        *request.user_header_mut() = ControlHeader {
            wire_version: WIRE_VERSION,
            header_len: size_of::<ControlHeader>() as u32,
            listener_id: listener.id(),
            ..header
        };
        let stream = request.send().map_err(from_send)?;
        if stream.number_of_server_connections() == 0 {
            self.check_alive(boot_id)?;
            return Err(ClientError::Overloaded);
        }
        self.call_daemon();
        Ok(stream)
    }

    fn reply(
        &self,
        stream: &ControlStream,
        listener: &WaitFor<'_>,
        boot_id: u64,
        timeout: Duration,
        stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError> {
        let end = Instant::now() + timeout;
        loop {
            let received = stream
                .receive()
                .map_err(|error| ClientError::transport("control reply", error))?;
            if let Some(response) = received {
                return Ok(decode(response.payload())?);
            }
            self.check_alive(boot_id)?;
            if !stream.is_connected() && !stream.has_response() {
                return Err(ClientError::NoAnswer);
            }
            listener.wait_until(end, timeout)?;
            if stop() {
                return Err(ClientError::GivenUp);
            }
        }
    }

    /// Nobody waits any more for what was sent, and nothing came back.
    pub(super) fn was_unheard(&self) {
        self.is_unheard.store(true, Ordering::Relaxed);
    }

    pub(super) fn loan_control(&self, bytes: usize) -> Result<ControlLoan, ClientError> {
        self.check_room(bytes)?;
        self.control
            .loan_slice(bytes)
            .map_err(|error| from_loan(error, bytes))
    }

    /// Sends a request and wakes the daemon; gives the stream of its responses and the daemon's boot
    /// id.
    pub(super) fn dispatch(
        &self,
        mut loan: OptimizeLoan,
        header: RequestHeader,
    ) -> Result<(Stream, u64), ClientError> {
        let boot_id = self.running()?;
        *loan.user_header_mut() = header;
        let stream = loan.send().map_err(from_send)?;
        if stream.number_of_server_connections() == 0 {
            self.check_alive(boot_id)?;
            return Err(ClientError::Overloaded);
        }
        self.call_daemon();
        Ok((stream, boot_id))
    }

    fn check_room(&self, bytes: usize) -> Result<(), ClientError> {
        if self.room.take(bytes) {
            Ok(())
        } else {
            Err(ClientError::NoMemory(bytes))
        }
    }

    /// Tells the daemon to look at its ports.
    pub(super) fn call_daemon(&self) {
        // Fails only if the daemon is gone, which waiting finds out, or if it is being woken
        // already.
        let _ = self.notifier.notify();
    }

    pub(super) fn daemon_state(&self) -> DaemonState {
        self.probe.state()
    }

    /// The boot id of the daemon that lives now.
    pub(super) fn running(&self) -> Result<u64, ClientError> {
        match self.probe.state() {
            DaemonState::Running {
                boot_id,
                generation,
                ..
            } if generation == self.node.generation => Ok(boot_id),
            state => Err(self.gone(state, Loss::NotRunning)),
        }
    }

    /// Whether the daemon that got a request still lives.
    pub(super) fn check_alive(&self, boot_id: u64) -> Result<(), ClientError> {
        match self.probe.state() {
            DaemonState::Running { boot_id: now, .. } if now == boot_id => Ok(()),
            state => Err(self.gone(state, Loss::WentAway)),
        }
    }

    /// Of a daemon that is not the one that was waited for; `absence` where there is none.
    fn gone(&self, now: DaemonState, absence: Loss) -> ClientError {
        self.served_ns.store(0, Ordering::Relaxed);
        self.lost(match now {
            _ if !self.probe.is_in_place() => Loss::Removed,
            DaemonState::Running { generation, .. } if generation != self.node.generation => {
                Loss::Removed
            }
            DaemonState::Running { .. } => Loss::Restarted,
            DaemonState::Starting => Loss::Starting,
            DaemonState::Absent => absence,
        })
    }

    pub(super) fn lost(&self, loss: Loss) -> ClientError {
        ClientError::DaemonLost {
            root: self.root.clone(),
            loss,
        }
    }

    /// A listener of this client's own, back into the pool when dropped.
    pub(super) fn take_listener(&self) -> Result<WaitFor<'_>, ClientError> {
        let pooled = self.pool().pop();
        let listener = match pooled {
            Some(listener) => listener,
            None => opened("listener", transport::listener(&self.listener_service))?,
        };
        Ok(WaitFor {
            link: self,
            listener: Some(listener),
        })
    }

    fn pool(&self) -> std::sync::MutexGuard<'_, Vec<Listener<Variant>>> {
        self.listeners
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn put_listener(&self, listener: Listener<Variant>) {
        self.pool().push(listener);
    }
}

impl Drop for Link {
    /// Leaves once the daemon has received what was sent: what it receives later, iceoryx2 (0.10.0)
    /// never lets go. The answer to a control message says that it has.
    fn drop(&mut self) {
        if *self.is_unheard.get_mut() {
            let _ = self.control(&ControlRequest::List, 0, LEAVE, &|| false);
        }
    }
}

/// A listener on loan.
#[derive(Debug)]
pub(super) struct WaitFor<'a> {
    link: &'a Link,
    listener: Option<Listener<Variant>>,
}

impl WaitFor<'_> {
    /// Keeps the listener out of the pool; [`Link::put_listener`] brings it back.
    pub(super) fn keep(mut self) -> Listener<Variant> {
        self.listener
            .take()
            .expect("taken only here and by drop")
    }

    pub(super) fn id(&self) -> [u64; 2] {
        self.listener
            .as_ref()
            .map_or([0; 2], listener_id)
    }

    pub(super) fn wait_until(&self, end: Instant, asked: Duration) -> Result<(), ClientError> {
        self.listener
            .as_ref()
            .map_or(Ok(()), |listener| wait_until(listener, end, asked))
    }
}

impl Drop for WaitFor<'_> {
    fn drop(&mut self) {
        if let Some(listener) = self.listener.take() {
            self.link.put_listener(listener);
        }
    }
}

pub(super) fn listener_id(listener: &Listener<Variant>) -> [u64; 2] {
    let id = listener.id().value();
    [id as u64, (id >> 64) as u64]
}

/// Sleeps until called, until `end`, or for a probe interval; fails once `end` has passed.
pub(super) fn wait_until(
    listener: &Listener<Variant>,
    end: Instant,
    asked: Duration,
) -> Result<(), ClientError> {
    let left = end
        .saturating_duration_since(Instant::now())
        .min(PROBE_INTERVAL);
    if left.is_zero() {
        return Err(ClientError::Timeout(asked));
    }
    match listener.timed_wait(|_| (), left) {
        Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
        Err(error) => Err(ClientError::transport("listener", error)),
    }
}

fn opened<T, E: std::fmt::Display>(
    what: &'static str,
    result: Result<T, E>,
) -> Result<T, ClientError> {
    result.map_err(|error| {
        let reason = error.to_string();
        if reason.contains("ExceedsMax") {
            ClientError::TooManyClients
        } else {
            ClientError::setup(what, reason)
        }
    })
}

/// Bytes of a control message's payload.
pub(super) fn section(offset: usize, bytes: usize) -> Section {
    Section {
        offset: offset as u32,
        count: bytes as u32,
    }
}

/// Whether the lock file that the instance has now says the same of the daemon.
fn is_still(instance: &Instance, state: DaemonState) -> bool {
    let probe = DaemonProbe::open(instance).ok().flatten();
    probe.is_some_and(|probe| probe.state() == state)
}

/// Whether this is said of a service that is not there, or not whole.
fn is_absence(reason: &str) -> bool {
    let absences = ["DoesNotExist", "HangsInCreation", "CorruptedState"];
    absences
        .iter()
        .any(|absence| reason.contains(absence))
}

/// Waiting for a full daemon would hang the planner.
fn give_up(_: &BackpressureInfo) -> BackpressureAction {
    BackpressureAction::DiscardDataAndFail
}

fn optimize_port(node: &ServiceNode) -> Result<OptimizePort, ClientError> {
    let service = opened("optimize", transport::optimize(node).open())?;
    let builder = service
        .client_builder()
        .initial_max_slice_len(MAX_PAYLOAD)
        .allocation_strategy(AllocationStrategy::Static)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .set_backpressure_handler(give_up);
    opened("request port", builder.create())
}

fn control_port(node: &ServiceNode) -> Result<ControlPort, ClientError> {
    let service = opened("control", transport::control(node).open())?;
    let builder = service
        .client_builder()
        .initial_max_slice_len(CONTROL_MAX)
        .allocation_strategy(AllocationStrategy::Static)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .set_backpressure_handler(give_up);
    opened("control port", builder.create())
}
