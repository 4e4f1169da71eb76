//! Starting and ending the daemon.

use std::io::Write;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::thread::JoinHandle;

use crossbeam_channel::Sender;
use prometheus_client::registry::Registry;
use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::{Handle, Signals};
use taut::store::{ModelStore, PreparedModel};
use taut_ipc::server::{Janitor, Server};
use taut_ipc::{DaemonState, Instance, daemon_state};

use super::cleaning::Cleaning;
use super::clients::Clients;
use super::config::Config;
use super::error::DaemonError;
use super::event::{Event, EventSender};
use super::event_loop::{Ended, EventLoop, Limits};
use super::heal::{self, Configured};
use super::journal::{self, Entry, Journal, Kept};
use super::keeping::{Keeping, KeptUpTo};
use super::live::{self, Live};
use super::loader::Loader;
use super::loading::Loading;
use super::metrics::Metrics;
use super::open_request::{OpenRequests, Watches};
use super::poison::Poison;
use super::prepared::Prepared;
use super::preparer;
use super::pulse::Pulse;
use super::recording::Recorder;
use super::restore::{self, Beginning, say};
use super::schedule::{self, Schedule};
use super::scrape;
use super::state;
use super::status_clock::StatusClock;
use super::story::Stories;
use super::threads::{Started, spawn};
use super::web::Web;
use super::worker::Crew;

fn system(what: &'static str) -> impl Fn(std::io::Error) -> DaemonError {
    move |source| DaemonError::System { what, source }
}

/// Serves an instance until SIGINT, SIGTERM or a client's shutdown; `out` gets the lines of the
/// start.
///
/// # Errors
/// What could not be loaded or opened, or a port that stopped working.
pub fn serve(config: &Config, instance: &Instance, out: &mut dyn Write) -> Result<(), DaemonError> {
    refuse_second(instance)?;
    let stop = stop_flag().map_err(system("signal handler"))?;
    let (mut disk, kept) = opened(config, instance)?;
    let mut begun = restore::begin(config, kept, disk.as_ref().map(|disk| &disk.prepared), out)?;
    let configured = Configured::of(&begun);
    let mut server = Server::create(instance)?;
    loop {
        let (mut event_loop, threads) = assemble(config, instance, server, begun, disk)?;
        threads.pages.announce(out);
        announce(config, instance, out);
        threads.stop_if(&stop);
        let ended = event_loop.run();
        event_loop.close();
        threads.join();
        if ended? == Ended::Stopped {
            return Ok(());
        }
        begun = configured.again(event_loop.into_store());
        (server, disk) = heal::again(instance, || opened_again(config, instance))?;
    }
}

/// Says who serves the instance already: loading first would only take time.
fn refuse_second(instance: &Instance) -> Result<(), DaemonError> {
    if let DaemonState::Running { .. } = daemon_state(instance)? {
        // Creating the server says who it is.
        Server::create(instance)?;
    }
    Ok(())
}

fn announce(config: &Config, instance: &Instance, out: &mut dyn Write) {
    let name = instance.name();
    let workers = config.worker_count();
    let clearance_mm = config.clearance_m * 1e3;
    say(
        out,
        &format!("serving instance {name}  {workers} workers  clearance {clearance_mm} mm"),
    );
}

/// Opens what an instance keeps its robots and scenes in, where it keeps them.
fn opened(config: &Config, instance: &Instance) -> Result<(Option<Disk>, Kept), DaemonError> {
    let Some(folder) = state::folder(config, instance)? else {
        return Ok((None, Kept::default()));
    };
    let (journal, kept) = journal::open(&folder)?;
    let prepared = Prepared::new(&folder);
    Ok((Some(Disk { journal, prepared }), kept))
}

/// The same for a daemon that knows what was kept.
fn opened_again(config: &Config, instance: &Instance) -> Result<Option<Disk>, DaemonError> {
    let Some(folder) = state::folder(config, instance)? else {
        return Ok(None);
    };
    let journal = journal::open_again(&folder)?;
    let prepared = Prepared::new(&folder);
    Ok(Some(Disk { journal, prepared }))
}

/// What is kept of robots and scenes.
struct Disk {
    journal: Journal,
    prepared: Prepared,
}

/// Every thread besides the I/O thread. Each can wake it, which keeps its ports open: they have to
/// end before it.
struct Threads {
    events: EventSender,
    signals: Handle,
    joined: Vec<JoinHandle<()>>,
    pages: Pages,
}

impl Threads {
    /// Begins with the thread that stops the daemon on a signal.
    fn new(events: &EventSender) -> Result<Self, DaemonError> {
        let (signals, thread) =
            stop_on_signals(events.clone()).map_err(system("signal handler"))?;
        Ok(Self {
            events: events.clone(),
            signals,
            joined: vec![thread],
            pages: Pages::default(),
        })
    }

    /// Stops the daemon if a signal has come already.
    fn stop_if(&self, asked: &AtomicBool) {
        if asked.load(Relaxed) {
            self.events.send(Event::Stop);
        }
    }

    /// Takes the threads of what has been started, and gives that.
    fn add<T>(
        &mut self,
        started: std::io::Result<(T, impl IntoIterator<Item = JoinHandle<()>>)>,
    ) -> Result<T, DaemonError> {
        let (what, threads) = started.map_err(system("thread"))?;
        self.joined.extend(threads);
        Ok(what)
    }

    /// Starts what keeps changes on the disk, from what the labels name now.
    fn keeping(
        &mut self,
        disk: Disk,
        begun: &mut Beginning,
        events: &EventSender,
    ) -> Result<Keeping, DaemonError> {
        outlive_full_disks()?;
        let entries = self.journal(disk.journal, begun, events)?;
        let prepared = disk.prepared.start(alone(&begun.store));
        let to_prepare = self.add(with_thread(prepared))?;
        Ok(Keeping::new(entries, to_prepare))
    }

    fn journal(
        &mut self,
        journal: Journal,
        begun: &mut Beginning,
        events: &EventSender,
    ) -> Result<Sender<Entry>, DaemonError> {
        let live = std::mem::take(&mut begun.live);
        let configured = std::mem::take(&mut begun.configured);
        let events = events.clone();
        let told = move |ticket, failure| events.send(Event::Kept(KeptUpTo { ticket, failure }));
        self.add(with_thread(journal.start(live, configured, Box::new(told))))
    }

    fn join(self) {
        self.signals.close();
        drop(self.events);
        drop(self.pages);
        for thread in self.joined {
            // Workers and loader catch their panics; one that ended all the same has nothing to say
            // here.
            let _ = thread.join();
        }
    }
}

/// What was started with one thread, as [`Threads::add`] takes it.
fn with_thread<T>(started: Started<T>) -> std::io::Result<(T, [JoinHandle<()>; 1])> {
    started.map(|(what, thread)| (what, [thread]))
}

/// A file that may not grow is then an error like a full disk, not the end.
fn outlive_full_disks() -> Result<(), DaemonError> {
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))
        .map_err(system("signal handler"))?;
    Ok(())
}

/// The robots of a store with nothing around them.
fn alone(store: &ModelStore) -> Vec<Arc<PreparedModel>> {
    let robots = store.robots().values();
    robots
        .filter_map(|entry| store.alone(&entry.robot).cloned())
        .collect()
}

/// What is read from outside with a browser or by Prometheus.
#[derive(Default)]
struct Pages {
    scrape: Option<Web>,
    live: Option<Web>,
}

impl Pages {
    fn open(
        config: &Config,
        metrics: &Metrics,
        live: Option<&Arc<Live>>,
    ) -> Result<Self, DaemonError> {
        let scrape = config
            .metrics
            .map(|address| serve_metrics(address, metrics.registry()));
        let live = config
            .http
            .zip(live.cloned())
            .map(|(address, live)| serve_live(address, live));
        Ok(Self {
            scrape: scrape.transpose()?,
            live: live.transpose()?,
        })
    }

    fn announce(&self, out: &mut dyn Write) {
        if let Some(live) = &self.live {
            say(out, &format!("page at http://{}/", live.address()));
        }
        if let Some(scrape) = &self.scrape {
            let address = scrape.address();
            say(out, &format!("metrics at http://{address}/metrics"));
        }
    }
}

fn serve_metrics(address: SocketAddr, registry: Arc<Registry>) -> Result<Web, DaemonError> {
    let answer = move |request| scrape::answer(request, &registry);
    Web::start(address, "taut-metrics", answer).map_err(system("address for metrics"))
}

fn serve_live(address: SocketAddr, live: Arc<Live>) -> Result<Web, DaemonError> {
    let answer = move |request| live::answer(request, &live);
    Web::start(address, "taut-page", answer).map_err(system("address for the page"))
}

fn start_cleaning(instance: &Instance, server: &Server) -> Result<Cleaning, DaemonError> {
    let waker = server.waker();
    let janitor = Janitor::start(instance, move |_| waker.wake());
    janitor
        .map(Cleaning::new)
        .map_err(system("thread"))
}

fn assemble(
    config: &Config,
    instance: &Instance,
    server: Server,
    mut begun: Beginning,
    disk: Option<Disk>,
) -> Result<(EventLoop, Threads), DaemonError> {
    let (events, receiver) = EventSender::new(server.waker());
    let mut threads = Threads::new(&events)?;
    let cleaning = start_cleaning(instance, &server)?;
    let loader = threads.add(Loader::start(&events))?;
    let limits = Limits::of(config);
    let schedule = Arc::new(Schedule::new(limits.workers));
    let preparer = threads.add(preparer::start(&schedule))?;
    let keeping = match disk {
        Some(disk) => threads.keeping(disk, &mut begun, &events)?,
        None => Keeping::default(),
    };
    let recorder = threads.add(with_thread(Recorder::start(events.clone())))?;
    let pulse = threads.add(Pulse::start())?;
    let live = config
        .http
        .map(|_| Arc::new(Live::new(instance.name())));
    let crew = Crew {
        schedule: schedule.clone(),
        events,
        live: live.clone(),
        fault_injection: config.fault_injection,
    };
    let mailboxes = threads.add(crew.start(schedule::threads(limits.workers)))?;
    let metrics = Metrics::new();
    threads.pages = Pages::open(config, &metrics, live.as_ref())?;
    let event_loop = EventLoop {
        server,
        cleaning,
        schedule,
        preparer: Some(preparer),
        clients: Clients::new(config.quota, limits.workers),
        stories: Stories::default(),
        recorder,
        live,
        poison: Poison::default(),
        limits,
        store: begun.store,
        keeping,
        pulse,
        mailboxes,
        events: receiver,
        loading: Loading::new(loader),
        metrics,
        status_clock: StatusClock::new(config.status_rate_hz),
        open: OpenRequests::default(),
        watches: Watches::default(),
        next_number: 0,
        is_draining: false,
        is_removed: false,
    };
    Ok((event_loop, threads))
}

/// Set by a signal to stop, also by one that comes while no thread waits for it.
fn stop_flag() -> std::io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, flag.clone())?;
    }
    Ok(flag)
}

/// The thread ends when the handle is closed.
fn stop_on_signals(events: EventSender) -> Started<Handle> {
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let handle = signals.handle();
    let stop = move || {
        signals
            .forever()
            .for_each(|_| events.send(Event::Stop))
    };
    Ok((handle, spawn("taut-signals", stop)?))
}
