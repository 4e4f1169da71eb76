//! Starting and ending the daemon.

use std::collections::{BTreeMap, BTreeSet};
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
use taut::store::ModelStore;
use taut_ipc::server::{Janitor, Server};
use taut_ipc::{DaemonState, Instance, daemon_state, monotonic_ns};

use super::cleaning::Cleaning;
use super::drive::{Ended, Shell};
use super::heal::{self, Configured};
use super::lines::Lines;
use super::port::Port;
use super::pulse::Pulse;
use super::warm_up::WarmUp;
use super::web::Web;
use super::{framer, loader, preparer, worker};
use crate::daemon::config::Config;
use crate::daemon::durability::journal::{self, Entry, Journal, Key, State};
use crate::daemon::durability::prepared::Prepared;
use crate::daemon::durability::restore::{self, Beginning, say};
use crate::daemon::error::DaemonError;
use crate::daemon::observe::live::{self, Live};
use crate::daemon::observe::metrics::Metrics;
use crate::daemon::observe::recording::{self, Counts, Recorder};
use crate::daemon::observe::scrape;
use crate::daemon::service::event::{Event, KeptUpTo};
use crate::daemon::service::schedule::{self, Pressure};
use crate::daemon::service::{Outfit, Service};
use crate::daemon::state;
use crate::daemon::threads::{Started, spawn};

/// Threads of the crew besides those that have begun a job: one at the port, and one to hand it to.
const SPARE: usize = 2;

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
    let (mut disk, kept) = opened(config, instance)?;
    let mut begun = restore::begin(config, kept, disk.as_ref().map(|disk| &disk.prepared), out)?;
    let configured = Configured::of(&begun);
    let is_asked_to_stop = stop_flag().map_err(system("signal handler"))?;
    let mut server = Server::create(instance)?;
    loop {
        let (shell, threads) = assemble(config, instance, server, begun, disk)?;
        threads.pages.announce(out);
        announce(config, instance, out);
        if is_asked_to_stop.load(Relaxed) {
            shell.tell(Event::Stop);
        }
        if run(&shell, threads, config)? == Ended::Stopped {
            return Ok(());
        }
        let shell = Arc::into_inner(shell).expect("all threads that share it have ended");
        begun = configured.again(shell.into_store());
        (server, disk) = heal::again(instance, || opened_again(config, instance))?;
    }
}

/// Serves until all threads have ended.
fn run(shell: &Arc<Shell>, threads: Threads, config: &Config) -> Result<Ended, DaemonError> {
    let crew =
        worker::start(shell, config.niceness, config.fault_injection).map_err(system("thread"))?;
    let joined = crew.into_iter().map(JoinHandle::join).collect();
    let ended = shell.close();
    threads.join();
    resume(joined);
    Ok(ended?)
}

/// A panic of the crew is one here, once all has ended.
fn resume(ended: Vec<std::thread::Result<()>>) {
    for ended in ended {
        if let Err(panic) = ended {
            std::panic::resume_unwind(panic);
        }
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
fn opened(
    config: &Config,
    instance: &Instance,
) -> Result<(Option<Disk>, journal::Kept), DaemonError> {
    let Some(folder) = state::folder(config, instance)? else {
        return Ok((None, journal::Kept::default()));
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

/// Where robots and scenes are kept.
struct Disk {
    journal: Journal,
    prepared: Prepared,
}

/// Every thread besides the main one. Each can wake the port, which keeps it open: they have to end
/// before it.
struct Threads {
    signals: Handle,
    joined: Vec<JoinHandle<()>>,
    pages: Pages,
}

impl Threads {
    /// Begins with the thread that stops the daemon on a signal.
    fn new(tell: impl Fn(Event) -> bool + Send + 'static) -> Result<Self, DaemonError> {
        let (signals, thread) = stop_on_signals(tell).map_err(system("signal handler"))?;
        Ok(Self {
            signals,
            joined: vec![thread],
            pages: Pages::default(),
        })
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
        kept: Kept,
        tell: impl Fn(Event) -> bool + Send + 'static,
    ) -> Result<Sender<Entry>, DaemonError> {
        outlive_full_disks()?;
        let told = move |change, failure| {
            // The journal ends with its line.
            let _ = tell(Event::Kept(KeptUpTo { change, failure }));
        };
        let journal = kept
            .journal
            .start(kept.live, kept.configured, Box::new(told));
        self.add(with_thread(journal))
    }

    /// Waits for the end of all; a panic of one is one here.
    fn join(self) {
        self.signals.close();
        drop(self.pages);
        for thread in self.joined {
            if let Err(panic) = thread.join() {
                std::panic::resume_unwind(panic);
            }
        }
    }
}

/// What is on the disk, or to be there, when the daemon begins.
struct Kept {
    journal: Journal,
    live: BTreeMap<Key, State>,
    configured: BTreeSet<Key>,
}

impl Kept {
    fn of(journal: Journal, begun: &mut Beginning) -> Self {
        Self {
            journal,
            live: std::mem::take(&mut begun.live),
            configured: std::mem::take(&mut begun.configured),
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

/// What is read from outside with a browser or by Prometheus.
#[derive(Default)]
struct Pages {
    scrape: Option<Web>,
    live: Option<Web>,
}

impl Pages {
    fn open(
        config: &Config,
        registry: Arc<Registry>,
        live: Option<&Arc<Live>>,
    ) -> Result<Self, DaemonError> {
        let scrape = config
            .metrics
            .map(|address| serve_metrics(address, registry));
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

/// What threads share, and those besides the crew's.
fn assemble(
    config: &Config,
    instance: &Instance,
    server: Server,
    mut begun: Beginning,
    disk: Option<Disk>,
) -> Result<(Arc<Shell>, Threads), DaemonError> {
    let prepared = disk.as_ref().map(|disk| disk.prepared.clone());
    let kept = disk.map(|disk| Kept::of(disk.journal, &mut begun));
    let warm_up = WarmUp::of(&begun.store, prepared.clone());
    let counts = Arc::<Counts>::default();
    let metrics = Metrics::new(monotonic_ns());
    let registry = metrics.registry();
    let shell = shell(
        config,
        instance,
        server,
        begun.store,
        metrics,
        &counts,
        kept.is_some(),
    )?;
    let mut threads = Threads::new(telling(&shell))?;
    let niceness = config.niceness;
    let lines = lines(&shell, niceness, counts, kept, prepared, &mut threads)?;
    shell.connect(lines);
    threads.add(with_thread(warm_up.start(niceness, telling(&shell))))?;
    threads.pages = Pages::open(config, registry, shell.live.as_ref())?;
    Ok((shell, threads))
}

/// The service behind its ports.
fn shell(
    config: &Config,
    instance: &Instance,
    server: Server,
    store: ModelStore,
    metrics: Metrics,
    counts: &Arc<Counts>,
    keeps: bool,
) -> Result<Arc<Shell>, DaemonError> {
    let pressure = Arc::<Pressure>::default();
    let outfit = Outfit {
        store,
        metrics,
        recorder: Recorder::new(counts.clone()),
        keeps,
        shows: config.http.is_some(),
        boot_id: server.boot_id(),
        pressure: pressure.clone(),
    };
    let service = Service::new(config, outfit, monotonic_ns());
    let live = config
        .http
        .map(|_| Arc::new(Live::new(instance.name())));
    let cleaning = start_cleaning(instance, &server)?;
    let port = Port::new(server, cleaning);
    let threads = schedule::most_begun(config.worker_count()) + SPARE;
    let shell = Shell::new(service, port, threads, pressure, live);
    Ok(Arc::new(shell))
}

/// Starts the threads that do what takes long.
fn lines(
    shell: &Arc<Shell>,
    niceness: i32,
    counts: Arc<Counts>,
    kept: Option<Kept>,
    prepared: Option<Prepared>,
    threads: &mut Threads,
) -> Result<Lines, DaemonError> {
    let tell = telling(shell);
    let written = tell.clone();
    let written = move |ticket, answer| {
        written(Event::Written {
            ticket,
            answer: Box::new(answer),
        });
    };
    let journal = kept.map(|kept| threads.keeping(kept, tell.clone()));
    let loader =
        |name, prepared| with_thread(loader::start(name, niceness, prepared, tell.clone()));
    Ok(Lines {
        models: threads.add(loader("taut-loader", prepared))?,
        diffs: threads.add(loader("taut-diffs", None))?,
        frames: threads.add(with_thread(framer::start(shell, niceness)))?,
        to_prepare: threads.add(preparer::start(niceness, tell.clone()))?,
        recorder: threads.add(with_thread(recording::start(counts, Box::new(written))))?,
        journal: journal.transpose()?,
        pulse: threads.add(Pulse::start())?,
    })
}

/// How another thread tells what happened; false once nobody needs the next.
fn telling(shell: &Arc<Shell>) -> impl Fn(Event) -> bool + Clone + Send + 'static {
    let shell = Arc::clone(shell);
    move |event| {
        shell.tell(event);
        !shell.crew.is_closed()
    }
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
fn stop_on_signals(tell: impl Fn(Event) -> bool + Send + 'static) -> Started<Handle> {
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let handle = signals.handle();
    let stop = move || {
        signals
            .forever()
            .for_each(|_| _ = tell(Event::Stop));
    };
    Ok((handle, spawn("taut-signals", stop)?))
}
