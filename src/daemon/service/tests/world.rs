//! A daemon without threads: clients that send, workers that take time, a journal that is slow.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use taut::math::{Pose, Vec3};
use taut::optimize::Settings;
use taut::path::Path;
use taut::robot::{LinkDescription, RobotDescription, RobotModel};
use taut::scene::Scene;
use taut::shape::{Mesh, PlacedShape, Shape};
use taut::store::{ModelStore, PreparedModel};
use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::wire::{
    Code, RequestHeader, ResponseFlags, ResponseHeader, SceneEvent, StatusRecord, label_id,
};

use crate::daemon::config::Config;
use crate::daemon::durability::journal::Entry;
use crate::daemon::observe::metrics::Metrics;
use crate::daemon::observe::recording::{Counts, Recorder};
use crate::daemon::service::client::Client;
use crate::daemon::service::effect::{Effect, FrameTask, InOrder, Task};
use crate::daemon::service::event::{Answered, Asked, Event, KeptUpTo, Surroundings, Ticket, Way};
use crate::daemon::service::job::{Job, Stops};
use crate::daemon::service::schedule::Pressure;
use crate::daemon::service::{Outfit, Service};
use crate::daemon::translate::{self, Question, Reply};

pub(super) const MS: u64 = 1_000_000;
/// How often a job that is computed asks whether to stop or to make room.
const STEP_NS: u64 = MS / 2;

/// What a client has heard of a request.
#[derive(Clone, Debug, Default)]
pub(super) struct Heard {
    /// Codes of responses that are not the last.
    pub told: Vec<i32>,
    /// Lengths of shorter paths.
    pub improved: u32,
    /// Code and time (ns) of the last response.
    pub last: Option<(i32, u64)>,
    /// What a refusal says.
    pub message: String,
    /// Whether the stream ended without a word.
    pub dropped: bool,
    /// Flags of the last response.
    pub flags: u32,
    /// What the last response says of the world's age.
    pub age_ns: u64,
}

impl Heard {
    const NOTHING: Self = Self {
        told: Vec::new(),
        improved: 0,
        last: None,
        message: String::new(),
        dropped: false,
        flags: 0,
        age_ns: 0,
    };

    /// The code of the last response.
    pub fn code(&self) -> Option<Code> {
        let (code, _) = self.last?;
        Code::try_from(code).ok()
    }
}

/// A job that has a slot, or has made room.
struct Running {
    job: Box<Job>,
    left_ns: u64,
    /// When it next asks; `None` while it has made room.
    asks_ns: Option<u64>,
}

/// The service and all around it.
pub(super) struct World {
    pub service: Service,
    pub now_ns: u64,
    pub robot: Arc<RobotModel>,
    /// How long (ns) each job is computed; others take a millisecond.
    pub costs: BTreeMap<Ticket, u64>,
    /// Whether paths are proved, of jobs that are computed from now on.
    pub proved: bool,
    pub heard: BTreeMap<Ticket, Heard>,
    pub replies: BTreeMap<Ticket, ControlReply>,
    pub published: Vec<SceneEvent>,
    pub statuses: Vec<StatusRecord>,
    pub tasks: Vec<Task>,
    pub frames: Vec<FrameTask>,
    pub journal: Vec<Entry>,
    /// Whether models are made as soon as that is wanted; else [`Self::make`] makes them.
    pub makes_at_once: bool,
    /// Models that are to be made.
    pub to_make: Vec<Arc<PreparedModel>>,
    pub lines: usize,
    /// Computing time (ns) that each client has had.
    pub computed_ns: BTreeMap<u128, u64>,
    /// The most jobs that were computed at once.
    pub most_at_once: usize,
    /// A file that is gone of those by which clients find the daemon.
    pub missing: Option<PathBuf>,
    /// Tickets whose responses do not arrive.
    pub deaf: BTreeSet<Ticket>,
    running: BTreeMap<Ticket, Running>,
    pressure: Arc<Pressure>,
    tickets: Ticket,
}

/// A mesh, so that making its solid takes a time that is known before.
fn tetrahedron() -> PlacedShape {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let sides = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let mesh = Mesh::new("part", corners, sides).unwrap();
    PlacedShape {
        pose: Pose::identity(),
        shape: Shape::Mesh(Arc::new(mesh)),
    }
}

fn robot() -> Arc<RobotModel> {
    let base = LinkDescription {
        name: "base".to_owned(),
        collision: vec![tetrahedron()],
    };
    let description = RobotDescription {
        links: vec![base],
        ..RobotDescription::default()
    };
    Arc::new(RobotModel::new(description).unwrap())
}

/// A store with robot `arm` and scene `cell`.
fn store(robot: &Arc<RobotModel>) -> ModelStore {
    let mut store = ModelStore::new(label_id);
    store
        .insert_robot("arm", robot.clone(), Arc::new([]), false)
        .unwrap();
    store
        .insert_scene("cell", Arc::new(Scene::default()), false)
        .unwrap();
    store
}

impl World {
    /// A service with a configuration.
    pub fn new(config: &Config) -> Self {
        Self::keeping(config, false)
    }

    /// One that keeps its changes.
    pub fn keeping(config: &Config, keeps: bool) -> Self {
        let robot = robot();
        let pressure = Arc::<Pressure>::default();
        let now_ns = 1_000 * MS;
        let outfit = Outfit {
            store: store(&robot),
            metrics: Metrics::new(now_ns),
            recorder: Recorder::new(Arc::<Counts>::default()),
            keeps,
            shows: true,
            boot_id: 7,
            pressure: pressure.clone(),
        };
        Self {
            service: Service::new(config, outfit, now_ns),
            now_ns,
            robot,
            costs: BTreeMap::new(),
            proved: true,
            heard: BTreeMap::new(),
            replies: BTreeMap::new(),
            published: Vec::new(),
            statuses: Vec::new(),
            tasks: Vec::new(),
            frames: Vec::new(),
            journal: Vec::new(),
            makes_at_once: true,
            to_make: Vec::new(),
            lines: 0,
            computed_ns: BTreeMap::new(),
            most_at_once: 0,
            missing: None,
            deaf: BTreeSet::new(),
            running: BTreeMap::new(),
            pressure,
            tickets: 0,
        }
    }

    /// A header about robot and scene.
    pub fn header(&self) -> RequestHeader {
        RequestHeader {
            robot_id: label_id("arm"),
            scene_id: label_id("cell"),
            layout_hash: self.robot.layout_hash(),
            waypoints: 1,
            ..RequestHeader::default()
        }
    }

    /// A client asks; gives the request's ticket.
    pub fn ask(&mut self, client: u128, header: RequestHeader) -> Ticket {
        self.ask_with(client, header, Ok(()))
    }

    /// A client asks for what is computed for so long (ns).
    pub fn ask_that_costs(&mut self, client: u128, header: RequestHeader, cost_ns: u64) -> Ticket {
        self.costs.insert(self.tickets + 1, cost_ns);
        self.ask(client, header)
    }

    /// A client asks with a payload that fits its header, or does not.
    pub fn ask_with(
        &mut self,
        client: u128,
        header: RequestHeader,
        checked: Result<(), Refusal>,
    ) -> Ticket {
        self.tickets += 1;
        let ticket = self.tickets;
        let asked = Asked {
            ticket,
            client: Client {
                id: client,
                pid: 100,
            },
            header,
            bytes: 64,
            checked,
        };
        self.happens(Event::Asked(Box::new(asked)));
        ticket
    }

    /// A client asks for something else; gives the ticket.
    pub fn control(&mut self, message: ControlRequest) -> Ticket {
        self.tickets += 1;
        let ticket = self.tickets;
        self.happens(Event::Controlled {
            ticket,
            client: Client { id: 1, pid: 100 },
            message: Ok(Box::new(message)),
            around: Surroundings::default(),
        });
        ticket
    }

    /// Its reply, which has to be there.
    pub fn replied(&mut self, message: ControlRequest) -> ControlReply {
        let ticket = self.control(message);
        self.replies[&ticket].clone()
    }

    /// What the client of a request has heard.
    pub fn of(&self, ticket: Ticket) -> &Heard {
        static NOTHING: Heard = Heard::NOTHING;
        self.heard.get(&ticket).unwrap_or(&NOTHING)
    }

    /// Something happens now, and what follows from it.
    pub fn happens(&mut self, event: Event) {
        let effects = self.service.handle(event, self.now_ns);
        for effect in effects.in_order {
            self.in_order(effect);
        }
        for effect in effects.alone {
            self.alone(effect);
        }
    }

    fn in_order(&mut self, effect: InOrder) {
        match effect {
            InOrder::Prepare(model) => self.prepare(model),
            InOrder::Load(task) => self.tasks.push(task),
            InOrder::Frame(task) => self.frames.push(*task),
            InOrder::Tell(ticket, reply, event) => self.tell(ticket, &reply, event),
            InOrder::Publish(event) => self.published.push(event),
            InOrder::Status(status) => self.statuses.push(*status),
            InOrder::Keep(entry) => self.journal.push(entry),
            InOrder::Record(_) => self.lines += 1,
            InOrder::Show(..) => {}
        }
    }

    fn prepare(&mut self, model: Arc<PreparedModel>) {
        self.to_make.push(model);
        if self.makes_at_once {
            self.make();
        }
    }

    /// A preparer begins with the models that are to be made.
    pub fn begin_to_make(&self) {
        let models = self.to_make.iter();
        models.for_each(|model| model.begin(self.now_ns));
    }

    /// The models that are to be made are made.
    pub fn make(&mut self) {
        for model in std::mem::take(&mut self.to_make) {
            model.get().unwrap();
            self.happens(Event::Prepared);
        }
    }

    fn alone(&mut self, effect: Effect) {
        match effect {
            Effect::Read { ticket, .. } => {
                let read = Ok(question());
                self.happens(Event::Read { ticket, read });
            }
            Effect::Refuse(ticket, refusal) => self.refused(ticket, refusal),
            Effect::Improve(ticket, _) => self.heard.entry(ticket).or_default().improved += 1,
            Effect::Answer(ticket, reply) => self.answered(ticket, &reply.header),
            Effect::Drop(ticket) => self.heard.entry(ticket).or_default().dropped = true,
            Effect::Begin(job) => self.begin(job),
            Effect::Pause(ticket) => self.running_job(ticket).asks_ns = None,
            Effect::GoOn(ticket) => {
                let asks_ns = self.now_ns + STEP_NS;
                self.running_job(ticket).asks_ns = Some(asks_ns);
            }
            Effect::Look(ticket) => self.happens(Event::Over(ticket)),
            Effect::LookForFiles => self.look_for_files(),
            Effect::Reply(ticket, reply) => {
                self.replies.insert(ticket, *reply);
            }
        }
        self.most_at_once = self.most_at_once.max(self.computed_now());
    }

    fn look_for_files(&mut self) {
        if let Some(missing) = self.missing.clone() {
            self.happens(Event::Removed(missing));
        }
    }

    fn running_job(&mut self, ticket: Ticket) -> &mut Running {
        self.running.get_mut(&ticket).unwrap()
    }

    fn computed_now(&self) -> usize {
        let running = self.running.values();
        running
            .filter(|running| running.asks_ns.is_some())
            .count()
    }

    fn refused(&mut self, ticket: Ticket, refusal: Refusal) {
        let now_ns = self.now_ns;
        let heard = self.heard.entry(ticket).or_default();
        assert!(heard.last.is_none(), "request {ticket} ends once");
        heard.last = Some((refusal.code, now_ns));
        heard.message = refusal.message;
    }

    fn answered(&mut self, ticket: Ticket, header: &ResponseHeader) {
        let now_ns = self.now_ns;
        let heard = self.heard.entry(ticket).or_default();
        assert!(heard.last.is_none(), "request {ticket} ends once");
        heard.last = Some((header.code, now_ns));
        heard.flags = header.flags;
        heard.age_ns = header.world_age_ns;
    }

    fn tell(&mut self, ticket: Ticket, reply: &Reply, event: Option<SceneEvent>) {
        if self.deaf.contains(&ticket) {
            return self.happens(Event::NotTold(ticket));
        }
        let heard = self.heard.entry(ticket).or_default();
        heard.told.push(reply.header.code);
        heard.flags = reply.header.flags;
        self.published.extend(event);
    }

    fn begin(&mut self, job: Box<Job>) {
        let left_ns = self.costs.get(&job.id).copied().unwrap_or(MS);
        let asks_ns = Some(self.now_ns + STEP_NS.min(left_ns));
        let running = Running {
            job,
            left_ns,
            asks_ns,
        };
        self.running.insert(running.job.id, running);
    }

    /// Time passes.
    pub fn pass(&mut self, time_ns: u64) {
        let end_ns = self.now_ns + time_ns;
        while let Some((at_ns, ticket)) = self.next(end_ns) {
            self.now_ns = at_ns;
            match ticket {
                Some(ticket) => self.step(ticket),
                None => self.happens(Event::Tick(Surroundings::default())),
            }
        }
        self.now_ns = end_ns;
    }

    /// What happens next until then: a job asks, or the service has something to do by itself.
    fn next(&self, end_ns: u64) -> Option<(u64, Option<Ticket>)> {
        let asks = self.running.iter();
        let asks = asks.filter_map(|(ticket, running)| Some((running.asks_ns?, Some(*ticket))));
        let tick_ns = self.service.next_ns().max(self.now_ns);
        asks.chain([(tick_ns, None)])
            .filter(|(at_ns, _)| *at_ns <= end_ns)
            .min()
    }

    /// A job has been computed for a while.
    fn step(&mut self, ticket: Ticket) {
        let now_ns = self.now_ns;
        let running = self.running_job(ticket);
        let computed_ns = STEP_NS.min(running.left_ns);
        running.left_ns -= computed_ns;
        running.asks_ns = Some(now_ns + STEP_NS.min(running.left_ns));
        let is_over = running.job.stop.get().is_some() || running.job.is_expired(now_ns);
        let is_done = running.left_ns == 0 || is_over;
        let client = running.job.client.id;
        let priority = running.job.priority;
        *self.computed_ns.entry(client).or_default() += computed_ns;
        if is_done {
            self.end(ticket);
        } else if self
            .pressure
            .is_felt(priority, now_ns - STEP_NS, now_ns)
        {
            self.happens(Event::MayPause(ticket));
        }
    }

    /// A job is done, or told to end.
    fn end(&mut self, ticket: Ticket) {
        let Running { job, .. } = self.running.remove(&ticket).unwrap();
        let reply = reply(&job, self.proved);
        self.happens(Event::Answered(Box::new(Answered {
            ticket,
            reply,
            way: Way::Computed(Stops::default()),
            crashed: None,
        })));
    }

    /// The core panics on a job.
    pub fn panics(&mut self, ticket: Ticket) {
        let Running { job, .. } = self.running.remove(&ticket).unwrap();
        let refusal = Refusal::new(Code::Crash, "a panic");
        self.happens(Event::Answered(Box::new(Answered {
            ticket,
            reply: translate::refused(refusal),
            way: Way::Computed(Stops::default()),
            crashed: Some(job.content()),
        })));
    }

    /// A job has a shorter path.
    pub fn improves(&mut self, ticket: Ticket) {
        let header = Box::default();
        self.happens(Event::Improved { ticket, header });
    }

    /// The journal has written all that it was given, or could not.
    pub fn keep(&mut self, failure: Option<&str>) {
        let change = self
            .journal
            .iter()
            .filter_map(|entry| match entry {
                Entry::Changed(change, ..) => Some(*change),
                Entry::End => None,
            })
            .max()
            .unwrap_or(0);
        let failure = failure.map(str::to_owned);
        self.happens(Event::Kept(KeptUpTo { change, failure }));
    }
}

fn question() -> Question {
    Question {
        settings: Arc::new(Settings::default()),
        path: Arc::new(Path::from_rows(1, vec![0.0]).unwrap()),
        timing: None,
    }
}

fn reply(job: &Job, proved: bool) -> Reply {
    let mut reply = translate::expired(&job.snapshot, &job.path);
    reply.header.code = match proved {
        true => Code::Success.into(),
        false => Code::InvalidMotionPlan.into(),
    };
    reply.header.flags = if proved { ResponseFlags::PROVED } else { 0 };
    reply.header.waypoints = 1;
    reply
}
