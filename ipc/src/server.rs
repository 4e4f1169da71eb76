//! The daemon's side: owns every port, never blocks on a client.

mod bell;
mod cleanup;
mod error;
mod incoming;
mod janitor;
mod own_files;
mod ports;
mod service_files;

pub use bell::Waker;
pub use cleanup::{CleanUp, clean_dead_nodes, tidy};
pub use error::ServerError;
pub use incoming::{IncomingControl, IncomingRequest, SendError};
pub use janitor::Janitor;

use crate::instance::Instance;
use crate::limits::{ACTIVE_REQUESTS_PER_CLIENT, MAX_CLIENTS, WIRE_VERSION};
use crate::lock::DaemonLock;
use crate::memory::{self, Room};
use crate::time::unique_number;
use crate::transport::{self, ServiceNode, Variant};
use crate::wire::{SceneEvent, StatusRecord};
use bell::ClientBell;
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{CallbackProgression, PortFactory};
use iceoryx2::service::dynamic_config::request_response::ClientDetails;
use own_files::OwnFiles;
use ports::{
    ControlPort, ControlService, OptimizePort, OptimizeService, control_port, listener, made,
    optimize_port, scene_event_port, status_port,
};
use rustix::process::{Resource, getrlimit, setrlimit};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Open files the daemon may need.
pub const FILES_WANTED: u64 = 512 + FILES_OF_CLIENT * MAX_CLIENTS as u64;
/// Open files that a client costs the daemon at most.
const FILES_OF_CLIENT: u64 = 16;
/// Open files that the daemon needs for itself at least.
const FILES_OF_DAEMON: u64 = 64;

/// What every response of a server shares.
#[derive(Debug)]
pub(crate) struct Shared {
    bell: ClientBell,
    boot_id: u64,
    room: Room,
    waker: Waker,
    /// Whether somebody has more to be received once an earlier message of theirs is let go.
    is_held_back: AtomicBool,
}

impl Shared {
    /// A message is let go: whoever waits at the port looks whether its client has another.
    fn let_go(&self) {
        if self.is_held_back.swap(false, Ordering::SeqCst) {
            self.waker.wake();
        }
    }

    /// A client whose earlier messages are still being held has to wait for its next one: that is
    /// no error, and whoever lets one of them go says so. Neither is one client's broken
    /// connection, which shows only once.
    fn received<T>(
        &self,
        mut receive: impl FnMut() -> Result<Option<T>, ReceiveError>,
    ) -> Result<Option<T>, ReceiveError> {
        let received = receive().or_else(|_| receive());
        if !is_held_back(&received) {
            return received;
        }
        self.is_held_back.store(true, Ordering::SeqCst);
        // One may have been let go before that could be seen.
        let received = receive();
        match is_held_back(&received) {
            true => Ok(None),
            false => received,
        }
    }
}

fn is_held_back<T>(received: &Result<Option<T>, ReceiveError>) -> bool {
    matches!(received, Err(ReceiveError::ExceedsMaxBorrows))
}

/// Lets a message go, once its memory has been given back.
#[derive(Debug)]
struct LetGo(Arc<Shared>);

impl Drop for LetGo {
    fn drop(&mut self) {
        self.0.let_go();
    }
}

/// All ports of the daemon, for all of its threads; one of them waits at a time.
#[derive(Debug)]
pub struct Server {
    optimize: OptimizePort,
    control: ControlPort,
    status: Publisher<Variant, StatusRecord, ()>,
    scene_events: Publisher<Variant, SceneEvent, ()>,
    listener: Listener<Variant>,
    shared: Arc<Shared>,
    heartbeat: AtomicU64,
    /// Requests that were received before a control message.
    early: Mutex<VecDeque<IncomingRequest>>,
    service: OptimizeService,
    control_service: ControlService,
    files: OwnFiles,
    _node: ServiceNode,
    // Last: the instance is free only when everything above is gone.
    hold: Hold,
}

/// Who sends through a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer {
    /// The connection: both ports of one [`crate::Client`] have the same.
    pub connection: u128,
    /// Its process; 0 = the system does not tell.
    pub pid: u32,
}

impl Peer {
    fn of(node: UniqueNodeId) -> Self {
        let pid = node.pid::<Variant>();
        Self {
            connection: node.value(),
            pid: pid.map_or(0, |pid| pid.value() as u32),
        }
    }
}

/// The instance while a daemon has it. Leaves nothing behind if the daemon was the last to go.
#[derive(Debug)]
struct Hold {
    instance: Instance,
    lock: DaemonLock,
}

impl Drop for Hold {
    fn drop(&mut self) {
        // Where the lock's file was removed, what lies there now may be another daemon's.
        if self.lock.is_in_place() {
            cleanup::clean_end(&self.instance);
        }
    }
}

impl Server {
    /// Takes the instance, removes what dead processes left there, and opens all services.
    ///
    /// # Errors
    /// [`ServerError::AlreadyRunning`] if another daemon lives; otherwise what could not be made.
    pub fn create(instance: &Instance) -> Result<Self, ServerError> {
        instance.prepare()?;
        let lock = Self::lock(instance)?;
        let last = lock.last_generation;
        Self::serve(instance, lock, last)
    }

    /// The same after files of the instance were removed under a daemon: its clients, of whom files
    /// may be gone too, have to connect anew, and one may have made the root again, with rights of
    /// others.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn create_again(instance: &Instance) -> Result<Self, ServerError> {
        instance.prepare_again()?;
        Self::serve(instance, Self::lock(instance)?, None)
    }

    fn lock(instance: &Instance) -> Result<DaemonLock, ServerError> {
        DaemonLock::acquire(instance)?.ok_or_else(|| already_running(instance))
    }

    /// `last` are the services that clients which live may go on with.
    fn serve(
        instance: &Instance,
        lock: DaemonLock,
        last: Option<u64>,
    ) -> Result<Self, ServerError> {
        let clients = clients_with(raised_file_limit());
        transport::quiet();
        transport::set_global_config(instance)?;
        if memory::free_bytes() == 0 {
            return Err(ServerError::NoMemory);
        }
        let generation = cleanup::clean_start(instance, last);
        let hold = Hold {
            instance: instance.clone(),
            lock,
        };
        let node = transport::node(instance, generation).map_err(setup("node"))?;
        let boot_id = unique_number();
        let service = made(
            "optimize",
            transport::optimize_settings(transport::optimize(&node), clients).open_or_create(),
        )?;
        let control_service = made(
            "control",
            transport::control_settings(transport::control(&node)).open_or_create(),
        )?;
        let mut server = Self {
            optimize: optimize_port(&service)?,
            control: control_port(&control_service)?,
            status: status_port(&node)?,
            scene_events: scene_event_port(&node)?,
            listener: listener(&node)?,
            shared: Arc::new(Shared {
                bell: ClientBell::new(&node).map_err(setup("wake-client"))?,
                boot_id,
                room: Room::default(),
                waker: Waker::new(&node).map_err(setup("waker"))?,
                is_held_back: AtomicBool::new(false),
            }),
            heartbeat: AtomicU64::new(0),
            early: Mutex::default(),
            service,
            control_service,
            files: OwnFiles::of(instance, node.id()).ok_or_else(|| removed(instance))?,
            _node: node,
            hold,
        };
        memory::make_private(instance);
        let announced = server.hold.lock.announce(boot_id, generation);
        announced.map_err(|source| instance.file_error(instance.root(), source))?;
        Ok(server)
    }

    /// Changes with every start; in every response.
    pub fn boot_id(&self) -> u64 {
        self.shared.boot_id
    }

    /// A file that is gone of those by which others find this daemon; `None` while all are in place.
    /// Costs some 40 system calls, less than 0.1 ms.
    ///
    /// What is connected works on, and nobody else comes: end what is open, drop this server and
    /// create one anew.
    pub fn missing_file(&self) -> Option<&Path> {
        self.files.missing()
    }

    /// A handle with which any thread ends [`Self::wait`].
    pub fn waker(&self) -> Waker {
        self.shared.waker.clone()
    }

    /// Clients connected now, dead ones included until they are cleaned up.
    pub fn clients(&self) -> usize {
        self.service
            .dynamic_config()
            .number_of_clients()
    }

    /// Who sends through a port ([`IncomingRequest::client_id`], [`IncomingControl::client_id`]);
    /// `None` = it is gone.
    pub fn peer(&self, client_id: u128) -> Option<Peer> {
        let mut peer = None;
        let mut look = |client: &ClientDetails| {
            if client.client_id.value() != client_id {
                return CallbackProgression::Continue;
            }
            peer = Some(Peer::of(client.node_id));
            CallbackProgression::Stop
        };
        self.service
            .dynamic_config()
            .list_clients(&mut look);
        self.control_service
            .dynamic_config()
            .list_clients(&mut look);
        peer
    }

    /// Sleeps until a client or a [`Waker`] calls, or `timeout` passes; tells whether somebody
    /// called.
    ///
    /// A call that came before is not lost. Signals end the wait too. The kernel rounds the timeout
    /// up to its tick, up to 4 ms.
    ///
    /// # Errors
    /// [`ServerError::Port`] if the listener is broken.
    pub fn wait(&self, timeout: Duration) -> Result<bool, ServerError> {
        if !self.early().is_empty() {
            return Ok(true);
        }
        // A timeout of zero would mean for ever to the socket.
        let heard = if timeout.is_zero() {
            self.listener.try_wait(|_| ())
        } else {
            self.listener.timed_wait(|_| (), timeout)
        };
        match heard {
            Ok(calls) => Ok(calls > 0),
            Err(ListenerWaitError::InterruptSignal) => Ok(true),
            Err(error) => Err(port("listener")(error)),
        }
    }

    /// The next request, if any. Those whose client is gone already are skipped. A client has at
    /// most [`crate::limits::ACTIVE_REQUESTS_PER_CLIENT`] requests here: while cancelled ones are
    /// not dropped yet, its next ones wait.
    ///
    /// # Errors
    /// [`ServerError::Port`] if the port is broken.
    pub fn receive(&self) -> Result<Option<IncomingRequest>, ServerError> {
        let early = self.early().pop_front();
        match early {
            Some(request) => Ok(Some(request)),
            None => self.receive_next(),
        }
    }

    fn receive_next(&self) -> Result<Option<IncomingRequest>, ServerError> {
        let active = self
            .shared
            .received(|| self.optimize.receive())
            .map_err(port("request port"))?;
        Ok(active.map(|active| IncomingRequest::new(active, self.shared.clone())))
    }

    fn early(&self) -> MutexGuard<'_, VecDeque<IncomingRequest>> {
        self.early
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Receives what was sent before a control message that came: its answer says so.
    fn catch_up(&self) -> Result<(), ServerError> {
        for _ in 0..MAX_CLIENTS * ACTIVE_REQUESTS_PER_CLIENT {
            match self.receive_next()? {
                Some(request) => self.early().push_back(request),
                None => break,
            }
        }
        Ok(())
    }

    /// The next control message, if any. Its client's earlier requests have been received by then.
    ///
    /// # Errors
    /// As [`Self::receive`].
    pub fn receive_control(&self) -> Result<Option<IncomingControl>, ServerError> {
        let active = self
            .shared
            .received(|| self.control.receive())
            .map_err(port("control port"))?;
        if active.is_some() {
            self.catch_up()?;
        }
        Ok(active.map(|active| IncomingControl::new(active, self.shared.clone())))
    }

    /// Publishes the daemon's state; version, boot id and heartbeat are filled in.
    ///
    /// # Errors
    /// [`ServerError::Port`] if it cannot be sent.
    pub fn publish_status(&self, status: &StatusRecord) -> Result<(), ServerError> {
        let heartbeat = 1 + self.heartbeat.fetch_add(1, Ordering::Relaxed);
        let record = StatusRecord {
            wire_version: WIRE_VERSION,
            header_len: size_of::<StatusRecord>() as u32,
            boot_id: self.shared.boot_id,
            heartbeat,
            ..*status
        };
        self.status
            .send_copy(record)
            .map(drop)
            .map_err(port("status port"))
    }

    /// Publishes a change of a scene; version and boot id are filled in.
    ///
    /// # Errors
    /// [`ServerError::Port`] if it cannot be sent.
    pub fn publish_scene_event(&self, event: &SceneEvent) -> Result<(), ServerError> {
        let record = SceneEvent {
            wire_version: WIRE_VERSION,
            boot_id: self.shared.boot_id,
            ..*event
        };
        self.scene_events
            .send_copy(record)
            .map(drop)
            .map_err(port("scene event port"))
    }
}

/// Raises the limit of open files, of which the usual one of 1024 is below what all clients need,
/// as far as the system lets it; gives what it is then.
fn raised_file_limit() -> u64 {
    let mut limit = getrlimit(Resource::Nofile);
    let wanted = limit
        .maximum
        .map_or(FILES_WANTED, |maximum| maximum.min(FILES_WANTED));
    if limit
        .current
        .is_some_and(|current| current < wanted)
    {
        limit.current = Some(wanted);
        let _ = setrlimit(Resource::Nofile, limit);
    }
    getrlimit(Resource::Nofile)
        .current
        .unwrap_or(u64::MAX)
}

/// Clients that so many open files are enough for. Others are told at once that the daemon is full,
/// for a daemon that cannot open their ports never hears of them.
fn clients_with(files: u64) -> usize {
    let clients = files.saturating_sub(FILES_OF_DAEMON) / FILES_OF_CLIENT;
    usize::try_from(clients)
        .unwrap_or(MAX_CLIENTS)
        .clamp(1, MAX_CLIENTS)
}

fn removed(instance: &Instance) -> ServerError {
    ServerError::Removed {
        root: instance.root().display().to_string(),
    }
}

fn already_running(instance: &Instance) -> ServerError {
    ServerError::AlreadyRunning {
        name: instance.name().to_owned(),
        root: instance.root().display().to_string(),
    }
}

fn setup(what: &'static str) -> impl Fn(String) -> ServerError {
    move |reason| ServerError::Setup { what, reason }
}

fn port<E: std::fmt::Display>(what: &'static str) -> impl Fn(E) -> ServerError {
    move |error| ServerError::Port {
        what,
        reason: error.to_string(),
    }
}

// Every thread of the daemon sends; whoever waits at the port receives.
const _: () = {
    const fn shared<T: Send + Sync>() {}
    const fn handed_on<T: Send>() {}
    shared::<Server>();
    handed_on::<IncomingRequest>();
    handed_on::<IncomingControl>();
};
