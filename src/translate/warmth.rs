//! How far robots and scenes are made, in words.

use crate::collision::Count;
use crate::store::{Missing, ModelStore, PreparedModel, PreparedScene, Snapshot, Step};
use crate::warning::grouped;
use taut_ipc::control::{ModelState, Refusal};
use taut_ipc::wire::Code;

/// Shortest and longest time (ms) after which a request is sent again that came too early.
const LEAST_RETRY_MS: u64 = 100;
const MOST_RETRY_MS: u64 = 5_000;

/// What is made of what is loaded: robots, then scenes, in the order of their labels.
pub fn model_states(store: &ModelStore, now_ns: u64) -> Vec<ModelState> {
    let robots = store.robots().iter();
    let robots = robots.filter_map(|(label, entry)| {
        let alone = store.alone(&entry.robot)?;
        Some(robot_state(label, alone, store, now_ns))
    });
    let scenes = store.scenes().iter();
    let scenes = scenes.filter_map(|(label, entry)| {
        let prepared = store.prepared_scene(&entry.scene)?;
        Some(scene_state(label, prepared))
    });
    robots.chain(scenes).collect()
}

fn robot_state(label: &str, alone: &PreparedModel, store: &ModelStore, now_ns: u64) -> ModelState {
    let missing = alone.missing();
    let models = store.models_of(alone.robot());
    let own_bytes: usize = models.map(|model| model.own_bytes()).sum();
    ModelState {
        label: label.to_owned(),
        is_robot: true,
        missing: missing.map_or_else(String::new, |missing| step_so_far(&missing, now_ns)),
        triangles: alone.links().triangles as u64,
        bytes: (alone.link_bytes() + own_bytes) as u64,
    }
}

fn scene_state(label: &str, prepared: &PreparedScene) -> ModelState {
    let count = prepared.count();
    let left = prepared.missing();
    let missing = match left.bodies {
        0 => String::new(),
        _ => step_words(&Step::Objects(left)),
    };
    ModelState {
        label: label.to_owned(),
        is_robot: false,
        missing,
        triangles: count.triangles as u64,
        bytes: prepared.bytes() as u64,
    }
}

/// The refusal of a request that comes before its robot and scene are made; `scene` is the scene's
/// label.
pub fn loading(snapshot: &Snapshot, scene: &str, missing: &Missing, now_ns: u64) -> Refusal {
    let what = format!("robot {} in scene {scene}", snapshot.robot.name());
    let step = step_so_far(missing, now_ns);
    let passed_ns = passed_ns(missing.begun_ns, now_ns);
    let left_ns = missing.least_left_ns(now_ns);
    still_loading(&what, &step, passed_ns.max(left_ns))
}

/// The refusal of what names a robot or scene of which this step is taken, and that may be there in
/// as long again as `passed_ns`.
pub fn still_loading(what: &str, step: &str, passed_ns: u64) -> Refusal {
    let retry_after_ms = (passed_ns / 1_000_000).clamp(LEAST_RETRY_MS, MOST_RETRY_MS) as u32;
    Refusal {
        code: Code::Loading.into(),
        message: format!("{what} is still being made: {step}; send again in {retry_after_ms} ms"),
        retry_after_ms,
    }
}

fn step_so_far(missing: &Missing, now_ns: u64) -> String {
    let step = step_words(&missing.step);
    match missing.begun_ns {
        Some(begun_ns) => so_far(&step, now_ns.saturating_sub(begun_ns)),
        None => format!("{step}, waiting for their turn"),
    }
}

/// A step, and how long it has been taking.
pub fn so_far(step: &str, passed_ns: u64) -> String {
    format!("{step}, {:.1} s so far", passed_ns as f64 * 1e-9)
}

fn passed_ns(begun_ns: Option<u64>, now_ns: u64) -> u64 {
    begun_ns.map_or(0, |begun_ns| now_ns.saturating_sub(begun_ns))
}

/// What is made in a step.
pub fn step_words(step: &Step) -> String {
    match step {
        Step::Links(count) => solids(count, "link"),
        Step::Objects(count) => solids(count, "object"),
        Step::Together(objects) => format!("pairs of links and {}", counted(*objects, "object")),
    }
}

fn solids(count: &Count, body: &str) -> String {
    let bodies = counted(count.bodies, body);
    match count.meshes {
        0 => format!("solids of {bodies}"),
        meshes => format!(
            "solids of {bodies} with {}, {} triangles",
            counted(meshes, "mesh"),
            grouped(count.triangles)
        ),
    }
}

fn counted(count: usize, what: &str) -> String {
    match (count, what) {
        (1, _) => format!("1 {what}"),
        (_, "mesh") => format!("{} meshes", grouped(count)),
        _ => format!("{} {what}s", grouped(count)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_that_comes_too_early_hears_what_is_made_and_for_how_long() {
        let count = Count {
            bodies: 3,
            meshes: 4,
            triangles: 399_616,
            mesh_bytes: 0,
        };
        let missing = Missing {
            step: Step::Links(count),
            begun_ns: Some(1_000_000_000),
        };
        assert_eq!(
            step_so_far(&missing, 4_100_000_000),
            "solids of 3 links with 4 meshes, 399 616 triangles, 3.1 s so far"
        );
        let waits = Missing {
            begun_ns: None,
            step: Step::Objects(Count {
                meshes: 0,
                bodies: 1,
                ..count
            }),
        };
        assert_eq!(
            step_so_far(&waits, 5),
            "solids of 1 object, waiting for their turn"
        );
        assert_eq!(
            step_words(&Step::Together(1000)),
            "pairs of links and 1 000 objects"
        );
    }

    #[test]
    fn the_hint_is_as_long_again_within_bounds() {
        let hint = |passed_ns| still_loading("robot r", "its files", passed_ns).retry_after_ms;
        assert_eq!([0, 300_000_000, u64::MAX].map(hint), [100, 300, 5_000]);
    }

    #[test]
    fn what_cannot_be_made_by_then_is_known_from_its_triangles() {
        let left = |triangles, begun_ns, now_ns| {
            let step = Step::Links(Count {
                triangles,
                ..Count::default()
            });
            Missing { step, begun_ns }.least_left_ns(now_ns)
        };
        assert_eq!(left(400_000, None, 7), 100_000_000);
        assert_eq!(left(400_000, Some(10), 40_000_010), 60_000_000);
        assert_eq!(left(400_000, Some(10), u64::MAX), 0);
        assert_eq!(left(0, None, 0), 0);
    }
}
