//! Robots on their way to gateways that do not have them.

use super::robots::{Bringing, Robot};
use super::shared::{Caller, Client};
use crate::call::{Gateway, Lack, Nanos};
use std::sync::Arc;
use std::time::{Duration, Instant};
use taut_ipc::content::Parcel;
use taut_ipc::control::{ControlReply, ControlRequest, Refusal};
use taut_ipc::monotonic_ns;
use taut_ipc::wire::{Code, RequestHeader, label_id};

/// How long whoever loads a robot waits for the gateways besides the best; it comes there later too.
const OTHERS: Duration = Duration::from_secs(10);
/// How long whoever asks about a robot waits for it where it is brought.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often is looked whether it is there.
const TICK: Duration = Duration::from_millis(5);

impl Caller {
    /// A message was done at the best gateway; where it loaded a robot, the others get it too.
    pub(super) fn loaded(
        self: &Arc<Self>,
        client: &Arc<Client>,
        best: &Gateway,
        id: u64,
        parcel: Parcel,
    ) {
        let base = match parcel.message() {
            ControlRequest::LoadRobot { .. } => None,
            ControlRequest::SelectVariables { label, .. } => Some(label_id(label)),
            _ => return,
        };
        let robot = self.robots.note(id, base, parcel);
        robot.end(best, monotonic_ns());
        let mut others = self.live.now();
        others.retain(|gateway| gateway != best);
        for gateway in &others {
            self.bring(client, gateway, &robot);
        }
        wait_for(&robot, &others, OTHERS);
    }

    /// What a gateway says that it lacks, where it may get it or others may have it.
    pub(super) fn lack(
        self: &Arc<Self>,
        client: &Arc<Client>,
        (gateway, asked): &(Gateway, Nanos),
        request: &RequestHeader,
        code: i32,
    ) -> Option<Lack> {
        let robot = || self.robots.find(request.robot_id);
        let is_coming = match Code::try_from(code).ok()? {
            Code::UnknownRobot => self.is_coming(client, gateway, *asked, &*robot()?),
            Code::Loading => robot()?.at(gateway) == Some(Bringing::UnderWay),
            Code::UnknownScene => {
                let was_there = self.seen.newest(request.scene_id).0 > 0;
                // With a hash, another content is unknown too.
                return (was_there && request.scene_hash == 0).then_some(Lack::Elsewhere);
            }
            _ => false,
        };
        is_coming.then_some(Lack::Coming)
    }

    /// Whether a robot that was not there when it was `asked` for comes there.
    fn is_coming(
        self: &Arc<Self>,
        client: &Arc<Client>,
        gateway: &Gateway,
        asked: Nanos,
        robot: &Arc<Robot>,
    ) -> bool {
        self.bring(client, gateway, robot);
        match robot.at(gateway) {
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
        let robot = self.robots.find(label_id(label)).filter(|_| is_unknown);
        robot.is_some_and(|robot| {
            let is_new = !matches!(robot.at(gateway), Some(Bringing::Done(_)));
            self.bring(client, gateway, &robot);
            wait_for(&robot, std::slice::from_ref(gateway), PATIENCE);
            is_new
        })
    }

    /// Has a thread bring it there, once.
    fn bring(self: &Arc<Self>, client: &Arc<Client>, gateway: &Gateway, robot: &Arc<Robot>) {
        if !robot.begin(gateway, &self.live.now()) {
            return;
        }
        let [for_thread, for_failure] = [robot, robot].map(Arc::clone);
        let (caller, client, to) = (self.clone(), client.clone(), gateway.clone());
        let work = move || {
            let daemon = &*to.name;
            match caller.bring_now(&client, &to, &for_thread) {
                Ok(()) => tracing::info!(daemon, "robot {:016x} is there", for_thread.id),
                Err(reason) => tracing::warn!(daemon, "a robot is not brought there: {reason}"),
            }
            for_thread.end(&to, monotonic_ns());
        };
        let builder = std::thread::Builder::new().name("taut-robot".into());
        if let Err(error) = builder.spawn(work) {
            tracing::error!("no thread for a robot: {error}");
            for_failure.end(gateway, monotonic_ns());
        }
    }

    fn bring_now(&self, client: &Client, to: &Gateway, robot: &Robot) -> Result<(), String> {
        if let Some(base) = robot.base.and_then(|id| self.robots.find(id)) {
            self.bring_now(client, to, &base)?;
        }
        match self.converse(client, to, &mut robot.parcel.clone()) {
            Ok(ControlReply::Refused(refusal)) => Err(refusal.message),
            Ok(_) => Ok(()),
            Err(_) => Err("no reply from there".to_owned()),
        }
    }
}

/// Waits until a robot is at all of these, or could not be brought there.
fn wait_for(robot: &Robot, gateways: &[Gateway], patience: Duration) {
    let end = Instant::now() + patience;
    let is_under_way = |gateway: &Gateway| robot.at(gateway) == Some(Bringing::UnderWay);
    while gateways.iter().any(is_under_way) && Instant::now() < end {
        std::thread::sleep(TICK);
    }
}
