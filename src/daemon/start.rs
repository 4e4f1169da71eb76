//! Starting and ending the daemon.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::JoinHandle;

use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::{Handle, Signals};
use taut_ipc::server::{Janitor, Server};
use taut_ipc::{DaemonState, Instance, daemon_state, monotonic_ns};

use super::clients::Clients;
use super::config::Config;
use super::error::DaemonError;
use super::event::{Event, EventSender};
use super::event_loop::EventLoop;
use super::journal::{self, Journal, Kept};
use super::keeping::{Keeping, KeptUpTo};
use super::live::{self, Live};
use super::loader::Loader;
use super::metrics::Metrics;
use super::poison::Poison;
use super::prepared::Prepared;
use super::preparer;
use super::pulse::Pulse;
use super::recording::Recorder;
use super::restore::{self, Beginning, say};
use super::schedule::{self, Schedule};
use super::scrape;
use super::state;
use super::story::Stories;
use super::web::Web;
use super::worker::Worker;

fn system(what: &'static str) -> impl Fn(std::io::Error) -> DaemonError {
    move |source| DaemonError::System { what, source }
}

/// Serves an instance until SIGINT, SIGTERM or a client's shutdown; `out` gets the lines of the
/// start.
///
/// # Errors
/// What could not be loaded or opened, or a port that stopped working.
pub fn serve(config: &Config, instance: &Instance, out: &mut dyn Write) -> Result<(), DaemonError> {
    if let DaemonState::Running { .. } = daemon_state(instance)? {
        // Creating the server says who serves; loading first would only take time.
        Server::create(instance)?;
    }
    let (disk, kept) = match state::folder(config, instance)? {
        Some(folder) => {
            let (journal, kept) = journal::open(&folder)?;
            (
                Some(Disk {
                    journal,
                    prepared: Prepared::new(&folder),
                }),
                kept,
            )
        }
        None => (None, Kept::default()),
    };
    let begun = restore::begin(config, kept, disk.as_ref().map(|disk| &disk.prepared), out)?;
    let (mut event_loop, threads) = assemble(config, instance, begun, disk)?;
    if let Some(page) = &threads.page {
        say(out, &format!("page at http://{}/", page.address()));
    }
    let name = instance.name();
    let workers = config.worker_count();
    if let Some(scrape) = &threads.scrape {
        say(
            out,
            &format!("metrics at http://{}/metrics", scrape.address()),
        );
    }
    say(
        out,
        &format!(
            "serving instance {name}  {workers} workers  clearance {} mm",
            config.clearance_m * 1e3
        ),
    );
    let served = event_loop.run();
    event_loop.close();
    threads.join();
    Ok(served?)
}

/// What is kept of robots and scenes.
struct Disk {
    journal: Journal,
    prepared: Prepared,
}

/// Every thread besides the I/O thread. Each can wake it, which keeps its ports open: they have to
/// end before it.
struct Threads {
    signals: Handle,
    joined: Vec<JoinHandle<()>>,
    scrape: Option<Web>,
    page: Option<Web>,
}

impl Threads {
    fn join(self) {
        self.signals.close();
        drop(self.scrape);
        drop(self.page);
        for thread in self.joined {
            // Workers and loader catch their panics; one that ended all the same has nothing to say
            // here.
            let _ = thread.join();
        }
    }
}

fn assemble(
    config: &Config,
    instance: &Instance,
    begun: Beginning,
    disk: Option<Disk>,
) -> Result<(EventLoop, Threads), DaemonError> {
    let server = Server::create(instance)?;
    let (events, receiver) = EventSender::new(server.waker());
    let (signals, signal_thread) =
        stop_on_signals(events.clone()).map_err(system("signal handler"))?;
    let waker = server.waker();
    let janitor = Janitor::start(instance, move |_| waker.wake()).map_err(system("thread"))?;
    let (loader, loader_threads) = Loader::start(&events).map_err(system("thread"))?;
    let mut joined = vec![signal_thread];
    joined.extend(loader_threads);
    let workers = config.worker_count();
    let schedule = Arc::new(Schedule::new(workers));
    let (preparer, preparers) = preparer::start(&schedule).map_err(system("thread"))?;
    joined.extend(preparers);
    let mut keeping = Keeping::default();
    if let Some(Disk { journal, prepared }) = disk {
        // A file that may not grow is then an error like a full disk, not the end.
        signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))
            .map_err(system("signal handler"))?;
        let events = events.clone();
        let told = move |ticket, failure| events.send(Event::Kept(KeptUpTo { ticket, failure }));
        let started = journal.start(begun.live, begun.configured, Box::new(told));
        let (entries, thread) = started.map_err(system("thread"))?;
        let robots = begun
            .store
            .robots()
            .values()
            .filter_map(|entry| begun.store.alone(&entry.robot).cloned());
        let robots = robots.collect();
        let (to_prepare, preparing) = prepared.start(robots).map_err(system("thread"))?;
        keeping = Keeping::new(entries, to_prepare);
        joined.extend([thread, preparing]);
    }
    let (recorder, recording) = Recorder::start(events.clone()).map_err(system("thread"))?;
    joined.push(recording);
    let (pulse, pulse_thread) = Pulse::start().map_err(system("thread"))?;
    joined.extend(pulse_thread);
    let live = config.http.map(|_| Arc::new(Live::new(instance.name())));
    let mut mailboxes = Vec::new();
    for index in 0..schedule::threads(workers) {
        let mailbox = Arc::default();
        mailboxes.push(Arc::clone(&mailbox));
        let schedule = schedule.clone();
        let events = events.clone();
        let live = live.clone();
        let fault_injection = config.fault_injection;
        let worker = Worker {
            index,
            schedule,
            mailbox,
            events,
            live,
            fault_injection,
        };
        joined.push(worker.start().map_err(system("thread"))?);
    }
    let metrics = Metrics::new();
    let scrape = config.metrics.map(|address| {
        let registry = metrics.registry();
        Web::start(address, "taut-metrics", move |request| {
            scrape::answer(request, &registry)
        })
    });
    let scrape = scrape.transpose().map_err(system("address for metrics"))?;
    let page = config.http.zip(live.clone()).map(|(address, live)| {
        Web::start(address, "taut-page", move |request| {
            live::answer(request, &live)
        })
    });
    let page = page.transpose().map_err(system("address for the page"))?;
    let event_loop = EventLoop {
        server,
        janitor,
        schedule,
        preparer: Some(preparer),
        clients: Clients::new(config.quota, workers),
        stories: Stories::default(),
        recorder,
        live,
        poison: Poison::default(),
        workers,
        store: begun.store,
        keeping,
        pulse,
        mailboxes,
        events: receiver,
        loader: Some(loader),
        metrics,
        default_clearance_m: config.clearance_m,
        queue_limit: config.queue,
        status_period_ns: (1e9 / config.status_rate_hz) as u64,
        open: HashMap::new(),
        watches: BTreeMap::new(),
        loads: BTreeMap::new(),
        loading: HashSet::new(),
        next_number: 0,
        next_status_ns: monotonic_ns(),
        is_draining: false,
        janitor_was_slow: false,
    };
    Ok((
        event_loop,
        Threads {
            signals,
            joined,
            scrape,
            page,
        },
    ))
}

/// The thread ends when the handle is closed.
fn stop_on_signals(events: EventSender) -> std::io::Result<(Handle, JoinHandle<()>)> {
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let handle = signals.handle();
    let thread = std::thread::Builder::new()
        .name("taut-signals".into())
        .spawn(move || {
            for _ in signals.forever() {
                events.send(Event::Stop);
            }
        })?;
    Ok((handle, thread))
}
