//! What happened to each of the last requests, for `taut why`.

use std::collections::VecDeque;

use taut::store::ModelStore;
use taut_ipc::control::{Story, StoryEvent};
use taut_ipc::wire::{Code, Mode, RequestHeader, ResponseHeader, Termination};

/// Requests that are remembered.
const REMEMBERED: usize = 4096;
/// Events of one request that are told; of more the middle ones are left out.
const EVENTS: usize = 24;
/// Stories that are told at once.
const TOLD: usize = 20;

/// The last requests, the oldest first.
#[derive(Default)]
pub(crate) struct Stories {
    stories: VecDeque<(u64, Story)>,
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
            .partition_point(|(earlier, _)| *earlier < number);
        self.stories.insert(index, (number, story));
    }

    /// Something happened to it.
    pub(crate) fn tell(&mut self, number: u64, now_ns: u64, what: impl FnOnce() -> String) {
        let Some(story) = self.of(number) else { return };
        let event = StoryEvent {
            after_ns: now_ns.saturating_sub(story.received_ns),
            what: what(),
        };
        add(story, event);
    }

    /// It ended with this code.
    pub(crate) fn end(
        &mut self,
        number: u64,
        now_ns: u64,
        code: i32,
        what: impl FnOnce() -> String,
    ) {
        self.tell(number, now_ns, what);
        if let Some(story) = self.of(number) {
            story.code = code;
        }
    }

    /// Its story, to enter facts.
    pub(crate) fn of(&mut self, number: u64) -> Option<&mut Story> {
        // Numbers grow.
        let index = self
            .stories
            .binary_search_by_key(&number, |(number, _)| *number)
            .ok()?;
        Some(&mut self.stories[index].1)
    }

    /// Stories of the requests whose id in hexadecimal digits is this, or starts or ends with it,
    /// the newest first. Clients choose ids: two may choose the same.
    pub(crate) fn find(&self, id: &str) -> Vec<Story> {
        let id = id.trim_start_matches("0x").to_ascii_lowercase();
        let stories = self
            .stories
            .iter()
            .rev()
            .map(|(_, story)| story);
        let meant = stories.filter(|story| is_meant(story, &id));
        meant.take(TOLD).cloned().collect()
    }
}

/// Whether a request's id starts or ends with these digits.
fn is_meant(story: &Story, id: &str) -> bool {
    let full = format!("{:016x}", story.request_id);
    full.starts_with(id) || full.ends_with(id)
}

/// Adds an event, for which the middle of a long story makes room.
fn add(story: &mut Story, event: StoryEvent) {
    if story.events.len() == EVENTS {
        story.events.remove(EVENTS / 2);
        story.left_out += 1;
    }
    story.events.push(event);
}

/// The beginning: what a request's header says.
pub(crate) fn story(store: &ModelStore, header: &RequestHeader, pid: u32, now_ns: u64) -> Story {
    Story {
        request_id: header.request_id,
        pid,
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
pub(crate) fn shorter(header: &ResponseHeader) -> String {
    format!(
        "shorter: {:.6} after {} iterations",
        header.length_after, header.iterations
    )
}

/// The end: what the final response says.
pub(crate) fn ending(header: &ResponseHeader) -> String {
    let code = Code::try_from(header.code).map_or("?", Code::name);
    let termination = termination_named(header.termination);
    format!(
        "{code}, ended by {termination}: {:.6} to {:.6}, waited {:.3} ms, computed {:.3} ms, {} iterations, {} tests",
        header.length_before,
        header.length_after,
        header.queue_ns as f64 / 1e6,
        header.compute_ns as f64 / 1e6,
        header.iterations,
        header.work,
    )
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
            stories.tell(3, 0, || event.to_string());
        }
        let story = stories.find("0000000000000003").pop().unwrap();
        assert_eq!((story.events.len(), story.left_out), (EVENTS, 5));
        assert_eq!(
            (&*story.events[0].what, &*story.events[EVENTS - 1].what),
            ("0", "28")
        );
    }
}
