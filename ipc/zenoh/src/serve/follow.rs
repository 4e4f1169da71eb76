//! Copies of another daemon's scenes, with its version numbers.
//!
//! An event or a status of the home that differs from what is here has a thread look: what is
//! missed is fetched as the difference from the version here, or as a whole. Nothing depends on
//! every event coming through.

use super::copies::Copies;
use super::gate::Gate;
use crate::caller::{Caller, Client};
use crate::live::locked;
use crate::names;
use crate::network::{NetworkError, declared};
use crate::stop::Stop;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use taut_ipc::ClientError;
use taut_ipc::control::{ControlReply, ControlRequest, Files, Listing, SceneSummary, SceneText};
use taut_ipc::wire::{SceneEntry, SceneEvent, StatusRecord};
use zenoh::Wait;
use zenoh::sample::Sample;

/// How long what is here may differ from the home before it is looked at again without a word.
const LOOK_UP: Duration = Duration::from_secs(1);
/// How long a copy waits for the daemon here.
const PATIENCE: Duration = Duration::from_secs(60);

/// Follows a daemon until the gateway ends.
pub(super) fn start(gate: &Arc<Gate>, home: &str, stop: &Stop) -> Result<(), NetworkError> {
    let caller = Caller::over(gate.session.clone(), &[home.to_owned()])?;
    let client = caller.client(format!("{} (follows {home})", gate.name()))?;
    let follower = Follower {
        gate: gate.clone(),
        caller,
        client: Arc::new(client),
        here: Mutex::default(),
        home: home.to_owned(),
    };
    let stop = stop.clone();
    let work = move |thread: std::thread::Thread| {
        follower
            .wake_by_events(thread)
            .map(|()| follower)
    };
    let builder = std::thread::Builder::new().name("taut-follow".into());
    let started = builder.spawn(move || match work(std::thread::current()) {
        Ok(follower) => follower.run(&stop),
        Err(error) => tracing::error!("{error}"),
    });
    declared("a thread that follows", started.map(drop))
}

/// Whether what a home published differs from what is here.
type IsNews = fn(&Copies, &Sample) -> bool;

struct Follower {
    gate: Arc<Gate>,
    caller: Arc<Caller>,
    client: Arc<Client>,
    /// A port of the daemon here, opened once.
    here: Mutex<Option<taut_ipc::Client>>,
    home: String,
}

impl Follower {
    /// Has the thread unparked when the home tells of what is not here.
    fn wake_by_events(&self, thread: std::thread::Thread) -> Result<(), NetworkError> {
        let for_live = thread.clone();
        self.caller
            .live
            .wakes(move || for_live.unpark());
        let takes: [(String, IsNews); 2] = [
            (names::scene_events(&self.home), is_event_news),
            (names::status(&self.home), is_status_news),
        ];
        for (key, is_news) in takes {
            let gate = self.gate.clone();
            let thread = thread.clone();
            let subscriber = self
                .gate
                .session
                .declare_subscriber(key)
                .callback(move |sample| {
                    if is_news(gate.copies(), &sample) {
                        thread.unpark();
                    }
                })
                .background()
                .wait();
            declared("a subscriber", subscriber)?;
        }
        Ok(())
    }

    fn run(&self, stop: &Stop) {
        let mut told = None;
        while !stop.is_asked() {
            let failure = self.look().err();
            // Once: it is tried again and again.
            if let Some(reason) = &failure
                && told != failure
            {
                let home = &*self.home;
                tracing::warn!(home, "not followed: {reason}");
            }
            told = failure;
            std::thread::park_timeout(LOOK_UP);
        }
    }

    /// Makes the scenes here what they are at home, where that is there.
    fn look(&self) -> Result<(), String> {
        let here = scenes(self.tell_here(&ControlRequest::List)?)?;
        self.gate.copies().suppose(&here);
        if self.caller.best().is_none() {
            return Ok(());
        }
        let there = scenes(self.ask(&ControlRequest::List)?)?;
        let here: BTreeMap<_, _> = here
            .into_iter()
            .map(|scene| (scene.scene_id, scene))
            .collect();
        for scene in &there {
            let own = here.get(&scene.scene_id);
            if let Err(reason) = self.bring(scene, own) {
                let home = &*self.home;
                tracing::warn!(home, "scene {} is not copied: {reason}", scene.label);
            }
        }
        self.gate.copies().reached(&self.home);
        for copy in self.gate.copies().take_gone(&self.home, &there) {
            let label = copy.label;
            self.tell_here(&ControlRequest::UnloadScene { label })?;
        }
        Ok(())
    }

    fn bring(&self, there: &SceneSummary, here: Option<&SceneSummary>) -> Result<(), String> {
        let is_equal = here.is_some_and(|here| {
            (here.version, here.scene_hash) == (there.version, there.scene_hash)
        });
        if is_equal {
            self.gate.copies().note(&self.home, there);
            return Ok(());
        }
        if let Some(here) = here.filter(|here| here.version > there.version) {
            self.gate.copies().note_astray(here, there);
            return Err(format!(
                "its home has version {} of it, and here is version {}: one of them began anew, or the scene here is none of its; start the daemon here without its state, or give one another label",
                there.version, here.version
            ));
        }
        // Only what is a copy already has the home's numbers.
        let base = match self.gate.copies().of(there.scene_id) {
            Some(_) => here.map_or(0, |here| here.version),
            None => 0,
        };
        let text = match self.show(&there.label, base) {
            Err(_) if base > 0 => self.show(&there.label, 0)?,
            text => text?,
        };
        let message = copied(text, base);
        match self.tell_here(&message)? {
            ControlReply::Scene(scene) => {
                self.gate.copies().note(&self.home, &scene);
                Ok(())
            }
            other => Err(of_reply(other)),
        }
    }

    fn show(&self, label: &str, base_version: u64) -> Result<SceneText, String> {
        let label = label.to_owned();
        match self.ask(&ControlRequest::ShowScene {
            label,
            version: 0,
            base_version,
        })? {
            ControlReply::SceneText(text) => Ok(text),
            other => Err(of_reply(other)),
        }
    }

    /// At home.
    fn ask(&self, message: &ControlRequest) -> Result<ControlReply, String> {
        Ok(self.caller.control(&self.client, message))
    }

    fn tell_here(&self, message: &ControlRequest) -> Result<ControlReply, String> {
        let client = self.here().map_err(|error| error.to_string())?;
        client
            .control(message, PATIENCE)
            .map_err(|error| error.to_string())
    }

    fn here(&self) -> Result<taut_ipc::Client, ClientError> {
        let mut here = locked(&self.here);
        let client = match here.take() {
            Some(client) => client,
            None => taut_ipc::Client::connect(&self.gate.instance)?,
        };
        Ok(here.insert(client).clone())
    }
}

/// What makes a copy: of a difference from `base`, or of a whole scene.
fn copied(text: SceneText, base: u64) -> ControlRequest {
    let SceneText {
        label,
        version,
        json,
        base_version,
        ..
    } = text;
    let files = Some(Files::new());
    let version = Some(version);
    match base_version {
        0 => ControlRequest::LoadScene {
            label,
            json,
            base_dir: None,
            replace: true,
            files,
            version,
        },
        _ => ControlRequest::DiffScene {
            label,
            json,
            base_dir: None,
            base_version: base,
            files,
            version,
        },
    }
}

fn scenes(reply: ControlReply) -> Result<Vec<SceneSummary>, String> {
    match reply {
        ControlReply::Listing(Listing { scenes, .. }) => Ok(scenes),
        other => Err(of_reply(other)),
    }
}

fn of_reply(reply: ControlReply) -> String {
    match reply {
        ControlReply::Refused(refusal) => refusal.message,
        _ => "an odd reply; use the same release on both sides".to_owned(),
    }
}

fn is_event_news(copies: &Copies, sample: &Sample) -> bool {
    let bytes = sample.payload().to_bytes();
    if bytes.len() != size_of::<SceneEvent>() {
        return false;
    }
    let event: SceneEvent = bytemuck::pod_read_unaligned(&bytes);
    !copies.is_as(event.scene_id, event.scene_version, event.scene_hash)
}

fn is_status_news(copies: &Copies, sample: &Sample) -> bool {
    let bytes = sample.payload().to_bytes();
    if bytes.len() != size_of::<StatusRecord>() {
        return false;
    }
    let status: StatusRecord = bytemuck::pod_read_unaligned(&bytes);
    let mut listed = status
        .scene
        .iter()
        .filter(|entry| entry.id != 0);
    listed.any(|SceneEntry { id, hash, version }| !copies.is_as(*id, *version, *hash))
}
