//! What happened to each of the last requests, for `taut why`.

use std::collections::VecDeque;
use std::fmt::{self, Display, Formatter};

use taut::store::ModelStore;
use taut_ipc::control::{Story, StoryEvent};
use taut_ipc::wire::{
    Code, Mode, RefusalReason, RequestHeader, ResponseHeader, Termination, Times,
};

/// Requests that are remembered.
const REMEMBERED: usize = 4096;
/// Events of one request that are told; of more the middle ones are left out.
const EVENTS: usize = 24;
/// Stories that are told at once.
const TOLD: usize = 20;

/// Something that happened to a request; its words are made when somebody asks.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// It was let in, and so many waited.
    LetIn(usize),
    /// Its path must keep these constraints.
    MustKeep(Vec<String>),
    /// Its robot and scene are not put together yet.
    WaitsForModel,
    /// A shorter path was found.
    Shorter(Box<ResponseHeader>),
    /// It made room for others so often.
    Paused(u32),
    /// A watched path was checked in this version of its scene.
    Checked(u64, Box<ResponseHeader>),
    /// It was answered.
    Answered(Box<ResponseHeader>),
    /// It was refused.
    Refused(String),
    /// Its client dropped it, or is gone; it was a watch.
    Dropped(bool),
}

impl Display for Step {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::LetIn(waiting) => write!(f, "let in, {waiting} wait"),
            Self::MustKeep(constraints) => write!(f, "must keep {}", constraints.join(", ")),
            Self::WaitsForModel => f.write_str("waits until robot and scene are put together"),
            Self::Shorter(header) => f.write_str(&shorter(header)),
            Self::Paused(times) => write!(f, "made room for others {times} times"),
            Self::Checked(version, header) => {
                write!(f, "watched: in version {version} {}", ending(header))
            }
            Self::Answered(header) => f.write_str(&ending(header)),
            Self::Refused(why) => write!(f, "refused: {why}"),
            Self::Dropped(true) => f.write_str("the client dropped the watch or is gone"),
            Self::Dropped(false) => f.write_str("cancelled: the client dropped it or is gone"),
        }
    }
}

/// A story so far.
struct Told {
    number: u64,
    /// All but what happened.
    story: Story,
    steps: Vec<(u64, Step)>,
}

/// The last requests, the oldest first.
#[derive(Default)]
pub(crate) struct Stories {
    stories: VecDeque<Told>,
}

impl Stories {
    /// A request of this number came.
    pub(crate) fn begin(&mut self, number: u64, story: Story) {
        if self.stories.len() == REMEMBERED {
            self.stories.pop_front();
        }
        // Of two that come at once either may be entered first.
        let index = self
            .stories
            .partition_point(|earlier| earlier.number < number);
        let steps = Vec::new();
        let told = Told {
            number,
            story,
            steps,
        };
        self.stories.insert(index, told);
    }

    /// A request was let in, with this version of its scene, and so many waited.
    pub(crate) fn let_in(&mut self, number: u64, now_ns: u64, scene_version: u64, waiting: usize) {
        if let Some(told) = self.of(number) {
            told.story.scene_version = scene_version;
            told.add(now_ns, Step::LetIn(waiting));
        }
    }

    /// Something happened to it.
    pub(crate) fn tell(&mut self, number: u64, now_ns: u64, step: Step) {
        if let Some(told) = self.of(number) {
            told.add(now_ns, step);
        }
    }

    /// It ended with this code.
    pub(crate) fn end(&mut self, number: u64, now_ns: u64, code: i32, step: Step) {
        if let Some(told) = self.of(number) {
            told.add(now_ns, step);
            told.story.code = code;
        }
    }

    fn of(&mut self, number: u64) -> Option<&mut Told> {
        let index = self
            .stories
            .binary_search_by_key(&number, |told| told.number)
            .ok()?;
        Some(&mut self.stories[index])
    }

    /// Stories of the requests whose id in hexadecimal digits is this, or starts or ends with it,
    /// the newest first. Clients choose ids: two may choose the same.
    pub(crate) fn find(&self, id: &str) -> Vec<Story> {
        let id = id.trim_start_matches("0x").to_ascii_lowercase();
        let stories = self.stories.iter().rev();
        let meant = stories.filter(|told| is_meant(&told.story, &id));
        meant.take(TOLD).map(Told::whole).collect()
    }
}

impl Told {
    /// Adds a step, for which the middle of a long story makes room.
    fn add(&mut self, now_ns: u64, step: Step) {
        if self.steps.len() == EVENTS {
            self.steps.remove(EVENTS / 2);
            self.story.left_out += 1;
        }
        let after_ns = now_ns.saturating_sub(self.story.received_ns);
        self.steps.push((after_ns, step));
    }

    fn whole(&self) -> Story {
        let event = |(after_ns, step): &(u64, Step)| StoryEvent {
            after_ns: *after_ns,
            what: step.to_string(),
        };
        Story {
            events: self.steps.iter().map(event).collect(),
            ..self.story.clone()
        }
    }
}

/// Whether a request's id starts or ends with these digits.
fn is_meant(story: &Story, id: &str) -> bool {
    let full = format!("{:016x}", story.request_id);
    full.starts_with(id) || full.ends_with(id)
}

/// The beginning: what a request's header says.
pub(crate) fn story(store: &ModelStore, header: &RequestHeader, now_ns: u64) -> Story {
    Story {
        request_id: header.request_id,
        received_ns: now_ns,
        robot: named(store, header.robot_id),
        scene: named(store, header.scene_id),
        mode: mode_named(header.mode),
        waypoints: header.waypoints,
        variables: header.variables,
        priority: header.priority,
        deadline_ns: header.deadline_ns.saturating_sub(now_ns),
        ..Story::default()
    }
}

/// The label of an id; the id where it has none.
fn named(store: &ModelStore, id: u64) -> String {
    match store.label(id) {
        Some(label) => label.to_owned(),
        None => format!("id {id:016x}"),
    }
}

fn mode_named(mode: u32) -> String {
    match Mode::try_from(mode) {
        Ok(mode) => format!("{mode:?}"),
        Err(_) => format!("mode {mode}"),
    }
}

/// On the way: what an improvement says.
fn shorter(header: &ResponseHeader) -> String {
    if header.times == u32::from(Times::Timed) {
        return "a trajectory is proved".to_owned();
    }
    format!(
        "shorter: {:.6} after {} iterations",
        header.length_after, header.iterations
    )
}

/// The end: what the final response says.
fn ending(header: &ResponseHeader) -> String {
    let code = Code::try_from(header.code).map_or("?", Code::name);
    let termination = termination_named(header.termination);
    format!(
        "{code}{}{}, ended by {termination}: {:.6} to {:.6}, waited {:.3} ms, computed {:.3} ms, {} iterations, {} tests",
        reason_named(header.refusal_reason),
        times_named(header.times),
        header.length_before,
        header.length_after,
        header.queue_ns as f64 / 1e6,
        header.compute_ns as f64 / 1e6,
        header.iterations,
        header.work,
    )
}

/// Why the path is not proved, in brackets; nothing where it is.
fn reason_named(reason: u32) -> String {
    match RefusalReason::try_from(reason) {
        Ok(RefusalReason::None) | Err(_) => String::new(),
        Ok(reason) => format!(" ({})", reason.name()),
    }
}

/// What became of the times that were asked for.
fn times_named(times: u32) -> String {
    match Times::try_from(times) {
        Ok(Times::NotAsked) | Err(_) => String::new(),
        Ok(times) => format!(", times {}", times.name()),
    }
}

fn termination_named(termination: u32) -> String {
    match Termination::try_from(termination) {
        Ok(why) => format!("{why:?}"),
        Err(_) => "?".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_stories_and_middles_of_long_ones_make_room() {
        let mut stories = Stories::default();
        for number in 0..REMEMBERED as u64 + 3 {
            stories.begin(
                number,
                Story {
                    request_id: number,
                    ..Story::default()
                },
            );
        }
        assert!(stories.find("0000000000000002").is_empty());
        for event in 0..EVENTS + 5 {
            stories.tell(3, 0, Step::LetIn(event));
        }
        let story = stories.find("0000000000000003").pop().unwrap();
        assert_eq!((story.events.len(), story.left_out), (EVENTS, 5));
        assert_eq!(
            (&*story.events[0].what, &*story.events[EVENTS - 1].what),
            ("let in, 0 wait", "let in, 28 wait")
        );
    }
}
