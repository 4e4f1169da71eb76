//! Models on their way to gateways that do not have them.

use super::models::{Bringing, Model};
use super::shared::{Caller, Client};
use crate::call::{Gateway, Lack, Nanos};
use std::sync::Arc;
use std::time::{Duration, Instant};
use taut_ipc::content::Parcel;
use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::monotonic_ns;
use taut_ipc::planner::EMPTY_SCENE;
use taut_ipc::wire::{Code, RequestHeader, label_id};

/// How long whoever loads a model waits for the gateways besides the best; it comes there later too.
const OTHERS: Duration = Duration::from_secs(10);
/// How long whoever asks about a robot waits for it where it is brought.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often is looked whether it is there.
const TICK: Duration = Duration::from_millis(5);

impl Caller {
    /// A message was done at the best gateway; where it loaded a robot, or the scene with nothing in
    /// it, the others get that too. Scenes that change have one home.
    pub(super) fn loaded(
        self: &Arc<Self>,
        client: &Arc<Client>,
        best: &Gateway,
        id: u64,
        parcel: Parcel,
    ) {
        let base = match parcel.message() {
            ControlRequest::LoadRobot { .. } => None,
            ControlRequest::LoadScene { label, .. } if label == EMPTY_SCENE => None,
            ControlRequest::SelectVariables { label, .. } => Some(label_id(label)),
            _ => return,
        };
        let model = self.models.note(id, base, parcel);
        model.end(best, monotonic_ns());
        let mut others = self.live.now();
        others.retain(|gateway| gateway != best);
        for gateway in &others {
            self.bring(client, gateway, &model);
        }
        wait_for(&model, &others, OTHERS);
    }

    /// What a gateway says that it lacks, where it may get it or others may have it.
    pub(super) fn lack(
        self: &Arc<Self>,
        client: &Arc<Client>,
        (gateway, asked): &(Gateway, Nanos),
        request: &RequestHeader,
        code: i32,
    ) -> Option<Lack> {
        let code = Code::try_from(code).ok()?;
        let find = |id| self.models.find(id);
        let model = match code {
            Code::UnknownRobot => find(request.robot_id)?,
            Code::UnknownScene => match find(request.scene_id) {
                Some(scene) => scene,
                None => {
                    return self
                        .is_elsewhere(request)
                        .then_some(Lack::Elsewhere);
                }
            },
            Code::Loading => {
                let models = [request.robot_id, request.scene_id].map(find);
                let is_coming = models
                    .iter()
                    .flatten()
                    .any(|model| model.at(gateway) == Some(Bringing::UnderWay));
                return is_coming.then_some(Lack::Coming);
            }
            _ => return None,
        };
        self.is_coming(client, gateway, *asked, &model)
            .then_some(Lack::Coming)
    }

    /// Whether others had the scene. With a hash, another content is unknown too.
    fn is_elsewhere(&self, request: &RequestHeader) -> bool {
        request.scene_hash == 0 && self.seen.newest(request.scene_id).0 > 0
    }

    /// Whether a model that was not there when it was `asked` for comes there.
    fn is_coming(
        self: &Arc<Self>,
        client: &Arc<Client>,
        gateway: &Gateway,
        asked: Nanos,
        model: &Arc<Model>,
    ) -> bool {
        self.bring(client, gateway, model);
        match model.at(gateway) {
            Some(Bringing::Done(since)) => asked <= since,
            _ => true,
        }
    }

    /// Whether a refusal was of a robot that is there now.
    pub(super) fn has_brought(
        self: &Arc<Self>,
        client: &Arc<Client>,
        gateway: &Gateway,
        message: &ControlRequest,
        reply: &ControlReply,
    ) -> bool {
        let unknown = i32::from(Code::UnknownRobot);
        let (ControlRequest::Describe { label } | ControlRequest::SelectVariables { label, .. }) =
            message
        else {
            return false;
        };
        let is_unknown =
            matches!(reply, ControlReply::Refused(Refusal { code, .. }) if *code == unknown);
        let robot = self
            .models
            .find(label_id(label))
            .filter(|_| is_unknown);
        robot.is_some_and(|robot| {
            let is_new = !matches!(robot.at(gateway), Some(Bringing::Done(_)));
            self.bring(client, gateway, &robot);
            wait_for(&robot, std::slice::from_ref(gateway), PATIENCE);
            is_new
        })
    }

    /// Has a thread bring it there, once.
    fn bring(self: &Arc<Self>, client: &Arc<Client>, gateway: &Gateway, model: &Arc<Model>) {
        if !model.begin(gateway, &self.live.now()) {
            return;
        }
        let [for_thread, for_failure] = [model, model].map(Arc::clone);
        let (caller, client, to) = (self.clone(), client.clone(), gateway.clone());
        let work = move || {
            let daemon = &*to.name;
            match caller.bring_now(&client, &to, &for_thread) {
                Ok(()) => tracing::info!(daemon, "model {:016x} is there", for_thread.id),
                Err(reason) => tracing::warn!(daemon, "a model is not brought there: {reason}"),
            }
            for_thread.end(&to, monotonic_ns());
        };
        let builder = std::thread::Builder::new().name("taut-model".into());
        if let Err(error) = builder.spawn(work) {
            tracing::error!("no thread for a model: {error}");
            for_failure.end(gateway, monotonic_ns());
        }
    }

    fn bring_now(&self, client: &Client, to: &Gateway, model: &Model) -> Result<(), String> {
        if let Some(base) = model.base.and_then(|id| self.models.find(id)) {
            self.bring_now(client, to, &base)?;
        }
        match self.converse(client, to, &mut model.parcel.clone()) {
            Ok(ControlReply::Refused(refusal)) => Err(refusal.message),
            Ok(_) => Ok(()),
            Err(_) => Err("no reply from there".to_owned()),
        }
    }
}

/// Waits until a model is at all of these, or could not be brought there.
fn wait_for(model: &Model, gateways: &[Gateway], patience: Duration) {
    let end = Instant::now() + patience;
    let is_under_way = |gateway: &Gateway| model.at(gateway) == Some(Bringing::UnderWay);
    while gateways.iter().any(is_under_way) && Instant::now() < end {
        std::thread::sleep(TICK);
    }
}
