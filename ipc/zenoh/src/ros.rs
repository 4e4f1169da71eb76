//! ROS 2 nodes as callers: `/taut/shorten`, `/taut/check` and `/taut/apply_planning_scene` as rmw_zenoh's
//! nodes call services, and MoveIt's scene followed. No ROS is needed on this side.

mod answer;
mod ask;
mod follow;
mod node;
mod options;
mod refusal;
mod scenes;
mod start;
mod unused;

use crate::network::{Network, NetworkError};
use crate::stop::Stop;
pub use options::Options;

use ask::Kind;
use node::Ros;
use refusal::Refusal;
use scenes::Scenes;
use std::sync::Arc;
use std::time::{Duration, Instant};
use taut_ipc::Instance;
use taut_ipc::planner::{Planner, PlannerError};
use taut_ros::messages::moveit_msgs::{
    ApplyPlanningScene, ApplyPlanningSceneResponse, GetMotionPlan, GetMotionPlanRequest,
    GetMotionPlanResponse, MotionPlanResponse,
};

/// How often the program looks whether it is to stop, and whether its daemon is there.
const TICK: Duration = Duration::from_millis(50);
/// How long a request without a deadline may take: as long as rmw_zenoh's clients wait.
const PATIENCE: Duration = Duration::from_secs(600);
/// What an answer may need after its deadline.
const GRACE: Duration = Duration::from_secs(5);

/// Serves nodes until it is to stop.
///
/// # Errors
/// [`NetworkError`]: a session that cannot be opened. A daemon that is not there is waited for.
pub fn serve(network: &Network, options: &Options, stop: &Stop) -> Result<(), NetworkError> {
    let ros = Arc::new(Ros::open(network, options.domain)?);
    let Some(planner) = connected(&options.instance, stop) else {
        return Ok(());
    };
    let scenes = Arc::new(Scenes::new(planner.clone(), &options.scene));
    let following = options
        .follows
        .then(|| follow::start(&ros, &scenes, stop))
        .transpose()?;
    let answering = Arc::new(Answering {
        planner,
        scenes: scenes.clone(),
        options: options.clone(),
    });
    for kind in [Kind::Shorten, Kind::Check] {
        let answering = answering.clone();
        ros.serve::<GetMotionPlan>(kind.service(), move |request| {
            answering.answer(kind, request)
        })?;
    }
    ros.serve::<ApplyPlanningScene>("/taut/apply_planning_scene", move |request| {
        let changed = request.and_then(|request| scenes.take(&request.scene));
        let success = changed
            .inspect_err(|refusal| tracing::warn!("the scene stays as it is: {refusal}"))
            .is_ok();
        ApplyPlanningSceneResponse { success }
    })?;
    println!(
        "ready: {} as node {} of domain {}",
        options.instance.root().display(),
        node::NAME,
        options.domain
    );
    while !stop.is_asked() {
        stop.wait(TICK);
    }
    following.into_iter().for_each(|thread| {
        let _ = thread.join();
    });
    Ok(())
}

/// `None` where it is to stop before the daemon is there.
fn connected(instance: &Instance, stop: &Stop) -> Option<Planner> {
    let mut told = false;
    while !stop.is_asked() {
        match Planner::connect(instance) {
            Ok(planner) => return Some(planner),
            Err(error) if !told => {
                told = true;
                tracing::warn!("waits for the daemon: {error}");
            }
            Err(_) => {}
        }
        stop.wait(TICK);
    }
    None
}

/// What answers requests about paths.
struct Answering {
    planner: Planner,
    scenes: Arc<Scenes>,
    options: Options,
}

impl Answering {
    fn answer(
        &self,
        kind: Kind,
        request: Result<GetMotionPlanRequest, Refusal>,
    ) -> GetMotionPlanResponse {
        let start = Instant::now();
        let mut response = request
            .and_then(|request| self.planned(kind, &request))
            .unwrap_or_else(|refusal| {
                tracing::info!("{}: {refusal}", kind.service());
                answer::refused(&refusal)
            });
        response.planning_time = start.elapsed().as_secs_f64();
        GetMotionPlanResponse {
            motion_plan_response: response,
        }
    }

    fn planned(
        &self,
        kind: Kind,
        message: &GetMotionPlanRequest,
    ) -> Result<MotionPlanResponse, Refusal> {
        let message = &message.motion_plan_request;
        let robot = self.planner.robot(&self.options.robot)?;
        let mut asked = ask::asked(message, kind, &self.options, &robot)?;
        // What was not followed before is said of an answer that may have been computed before.
        let behind = self.scenes.behind();
        let patience = asked
            .request
            .deadline
            .map_or(PATIENCE, |deadline| deadline.saturating_add(GRACE));
        let answers = self.planner.ask(&asked.request, &asked.path)?;
        let result: Result<_, PlannerError> = answers.result(patience);
        asked.notes.extend(behind.clone());
        let best = result.map_err(|error| Refusal::from(error).with(behind))?;
        answer::planned(&asked, &best)
    }
}
