//! The rules in simulated time.

use super::*;

const MS: Nanos = 1_000_000;

fn gateway(name: &str, boot: u64) -> Gateway {
    Gateway {
        name: name.into(),
        boot,
    }
}

fn pair() -> Vec<Gateway> {
    vec![gateway("a", 1), gateway("b", 2)]
}

fn call(deadline: Option<Nanos>) -> Call {
    let header = RequestHeader {
        deadline_ns: deadline.unwrap_or(0),
        ..RequestHeader::default()
    };
    Call::new(&header, 0)
}

fn send(gateway: &Gateway, query: u32, left: Option<Nanos>) -> Action {
    let gateway = gateway.clone();
    Action::Send {
        gateway,
        query,
        left,
    }
}

fn again(gateway: &Gateway, query: u32) -> Action {
    let gateway = gateway.clone();
    Action::Again { gateway, query }
}

const FINAL: Answer = Answer {
    is_final: true,
    length: 1.0,
    lack: None,
};

fn progress(length: f64) -> Answer {
    Answer {
        is_final: false,
        length,
        lack: None,
    }
}

fn lacking(lack: Lack) -> Answer {
    Answer {
        lack: Some(lack),
        ..FINAL
    }
}

#[test]
fn what_a_gateway_lacks_is_asked_of_another_before_it_is_the_answer() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    let lacks = lacking(Lack::Elsewhere);
    assert!(
        call.handle(Event::Answered(0, lacks), MS, &live)
            .is_empty()
    );
    let sent = call.handle(Event::Look, 21 * MS, &live);
    assert_eq!(sent, [send(&live[1], 1, None)]);
    assert!(
        call.handle(Event::Answered(1, lacks), 22 * MS, &live)
            .is_empty()
    );
    // Back to the first: its daemon may have been started again.
    let due = call.next_look().unwrap();
    let sent = call.handle(Event::Look, due, &live);
    assert_eq!(sent, [send(&live[0], 2, None)]);
    let told = call.handle(Event::Answered(2, lacks), MS + ALONE, &live);
    let cancelled = Action::Cancel(live[1].clone());
    assert_eq!(told, [Action::Deliver, cancelled]);
    assert!(call.is_ended());
}

#[test]
fn what_is_lacking_is_told_before_the_deadline() {
    let live = pair();
    let mut call = call(Some(100 * MS));
    let mut now = 0;
    for query in 0..2 {
        call.handle(Event::Look, now, &live);
        let lacks = Event::Answered(query, lacking(Lack::Elsewhere));
        assert!(call.handle(lacks, now, &live).is_empty());
        now = call.next_look().unwrap();
    }
    call.handle(Event::Look, now, &live);
    let lacks = Event::Answered(2, lacking(Lack::Elsewhere));
    let told = call.handle(lacks, now, &live);
    assert_eq!(told[0], Action::Deliver);
    assert!(call.is_ended() && now < 100 * MS);
}

#[test]
fn what_is_being_brought_to_a_gateway_is_waited_for() {
    let live = pair();
    let mut call = call(None);
    let mut now = 0;
    for query in 0..100 {
        let sent = call.handle(Event::Look, now, &live);
        assert_eq!(sent, [send(&live[0], query, None)]);
        let lacks = lacking(Lack::Coming);
        assert!(
            call.handle(Event::Answered(query, lacks), now, &live)
                .is_empty()
        );
        now = call.next_look().unwrap();
    }
    assert!(now > 10 * ALONE);
    call.handle(Event::Look, now, &live);
    let ended = call.handle(Event::Answered(100, FINAL), now, &live);
    assert_eq!(ended, [Action::Deliver]);
}

#[test]
fn a_request_goes_to_the_best_gateway_and_ends_with_its_final_answer() {
    let live = pair();
    let mut call = call(Some(100 * MS));
    let sent = call.handle(Event::Look, MS, &live);
    assert_eq!(sent, [send(&live[0], 0, Some(99 * MS))]);
    let told = call.handle(Event::Answered(0, progress(2.0)), 2 * MS, &live);
    assert_eq!(told, [Action::Deliver]);
    let ended = call.handle(Event::Answered(0, FINAL), 3 * MS, &live);
    assert_eq!(ended, [Action::Deliver]);
    assert!(call.is_ended() && call.next_look().is_none());
}

#[test]
fn the_end_of_replies_is_no_answer_and_who_forgot_gets_it_again() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    let asked = call.handle(Event::Ended(0), MS, &live);
    assert_eq!(asked, [again(&live[0], 1)]);
    assert!(
        call.handle(Event::Ended(0), MS, &live)
            .is_empty()
    );
    let sent = call.handle(Event::Unknown(1), 2 * MS, &live);
    assert_eq!(sent, [send(&live[0], 2, None)]);
    // Forgotten twice: something is wrong there, so slower.
    call.handle(Event::Ended(2), 3 * MS, &live);
    assert!(
        call.handle(Event::Unknown(3), 4 * MS, &live)
            .is_empty()
    );
    assert_eq!(call.next_look(), Some(24 * MS));
    let sent = call.handle(Event::Look, 24 * MS, &live);
    assert_eq!(sent, [send(&live[0], 4, None)]);
}

#[test]
fn whoever_does_not_reply_twice_is_left_for_the_next_gateway() {
    let live = pair();
    let mut call = call(Some(1000 * MS));
    call.handle(Event::Look, 0, &live);
    call.handle(Event::Ended(0), MS, &live);
    assert!(
        call.handle(Event::Ended(1), 2 * MS, &live)
            .is_empty()
    );
    assert!(
        call.handle(Event::Look, 21 * MS, &live)
            .is_empty()
    );
    let sent = call.handle(Event::Look, 22 * MS, &live);
    assert_eq!(sent, [send(&live[1], 2, Some(978 * MS))]);
}

#[test]
fn a_gateway_that_is_gone_is_left_at_once_and_told_when_it_is_back() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    let sent = call.handle(Event::Look, MS, &live[1..]);
    assert_eq!(sent, [send(&live[1], 1, None)]);
    let ended = call.handle(Event::Answered(1, FINAL), 2 * MS, &live);
    assert_eq!(ended, [Action::Deliver, Action::Cancel(live[0].clone())]);
}

#[test]
fn a_daemon_that_was_restarted_is_another() {
    let mut call = call(None);
    call.handle(Event::Look, 0, &[gateway("a", 1)]);
    let restarted = gateway("a", 7);
    let sent = call.handle(Event::Look, MS, std::slice::from_ref(&restarted));
    assert_eq!(sent, [send(&restarted, 1, None)]);
}

#[test]
fn final_answers_after_the_first_are_counted_and_dropped() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    call.handle(Event::Look, MS, &live[1..]);
    let ended = call.handle(Event::Answered(0, FINAL), 2 * MS, &live);
    assert_eq!(ended, [Action::Deliver, Action::Cancel(live[1].clone())]);
    assert!(
        call.handle(Event::Answered(1, FINAL), 3 * MS, &live)
            .is_empty()
    );
    assert_eq!(call.late(), 1);
}

#[test]
fn what_is_not_shorter_than_what_was_told_is_not_told() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    for (length, is_told) in [(3.0, true), (3.0, false), (4.0, false), (2.5, true)] {
        let told = call.handle(Event::Answered(0, progress(length)), MS, &live);
        assert_eq!(!told.is_empty(), is_told, "{length}");
    }
}

#[test]
fn verdicts_of_a_watch_are_all_told() {
    let live = pair();
    let header = RequestHeader {
        flags: RequestFlags::WATCH,
        ..RequestHeader::default()
    };
    let mut call = Call::new(&header, 0);
    call.handle(Event::Look, 0, &live);
    for _ in 0..3 {
        let told = call.handle(Event::Answered(0, progress(3.0)), MS, &live);
        assert_eq!(told, [Action::Deliver]);
    }
}

#[test]
fn an_answer_that_was_lost_is_asked_for_after_the_deadline_and_then_made_here() {
    let live = pair();
    let mut call = call(Some(100 * MS));
    call.handle(Event::Look, 0, &live);
    assert_eq!(call.next_look(), Some(350 * MS));
    let asked = call.handle(Event::Look, 350 * MS, &live);
    assert_eq!(asked, [again(&live[0], 1)]);
    assert_eq!(call.next_look(), Some(1100 * MS));
    let failed = call.handle(Event::Look, 1100 * MS, &live);
    let cancelled = Action::Cancel(live[0].clone());
    assert_eq!(failed, [Action::Fail(Failure::TimedOut), cancelled]);
}

#[test]
fn where_all_gateways_are_gone_the_request_is_lost() {
    let mut call = call(None);
    assert!(call.handle(Event::Look, 0, &[]).is_empty());
    assert_eq!(call.next_look(), Some(1300 * MS));
    let failed = call.handle(Event::Look, 1300 * MS, &[]);
    assert_eq!(failed, [Action::Fail(Failure::Lost)]);
}

#[test]
fn silence_is_asked_about_ever_less_often() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    let mut waits = Vec::new();
    let mut now = 0;
    for _ in 0..4 {
        let due = call.next_look().unwrap();
        waits.push((due - now) / MS);
        now = due;
        assert_eq!(call.handle(Event::Look, now, &live).len(), 1);
    }
    assert_eq!(waits, [2000, 4000, 8000, 10_000]);
}

#[test]
fn the_wish_for_the_best_so_far_goes_along() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    let asked = call.handle(Event::Finish, MS, &live);
    assert_eq!(asked, [Action::Finish(live[0].clone())]);
    let sent = call.handle(Event::Look, 2 * MS, &live[1..]);
    let finish = Action::Finish(live[1].clone());
    assert_eq!(sent, [send(&live[1], 1, None), finish]);
}

#[test]
fn a_cancelled_request_is_cancelled_wherever_it_was_sent() {
    let live = pair();
    let mut call = call(None);
    call.handle(Event::Look, 0, &live);
    call.handle(Event::Look, MS, &live[1..]);
    let cancelled = call.handle(Event::Cancel, 2 * MS, &live);
    let all = live.iter().cloned().map(Action::Cancel);
    assert_eq!(cancelled, all.collect::<Vec<_>>());
    assert!(
        call.handle(Event::Answered(1, progress(1.0)), 3 * MS, &live)
            .is_empty()
    );
}

#[test]
fn a_request_that_kills_daemons_is_not_sent_for_ever() {
    let mut call = call(None);
    let mut sent = 0;
    for boot in 0..100 {
        let actions = call.handle(Event::Look, boot * MS, &[gateway("a", boot)]);
        sent += actions
            .iter()
            .filter(|action| matches!(action, Action::Send { .. }))
            .count();
    }
    assert_eq!(sent as u32, MOST_LOSSES);
    assert!(call.is_ended());
}

/// A network that loses, doubles and delays what it likes.
struct Storm {
    state: u64,
    now: Nanos,
    live: Vec<Gateway>,
    /// What comes, and when.
    coming: Vec<(Nanos, Event)>,
}

impl Storm {
    fn below(&mut self, limit: u64) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state % limit
    }

    fn later(&mut self, event: Event) {
        for _ in 0..[0, 1, 1, 1, 2][self.below(5) as usize] {
            let due = self.now + self.below(400) * MS;
            self.coming.push((due, event));
        }
    }

    fn change(&mut self) {
        let name = ["a", "b", "c"][self.below(3) as usize];
        let gone = self
            .live
            .iter()
            .position(|gateway| &*gateway.name == name);
        match gone {
            Some(index) => drop(self.live.remove(index)),
            None => {
                let boot = self.below(1000);
                self.live.push(gateway(name, boot));
            }
        }
    }

    fn query(&mut self, query: u32, is_again: bool) {
        if is_again && self.below(2) == 0 {
            self.later(Event::Unknown(query));
        }
        for _ in 0..self.below(4) {
            let length = self.below(100) as f64;
            self.later(Event::Answered(query, progress(length)));
        }
        match self.below(9) {
            0..3 => {}
            3 => self.later(Event::Answered(query, lacking(Lack::Coming))),
            4 => self.later(Event::Answered(query, lacking(Lack::Elsewhere))),
            _ => self.later(Event::Answered(query, FINAL)),
        }
        self.later(Event::Ended(query));
    }

    /// The next event, and its time.
    fn next(&mut self, call: &Call) -> Event {
        let due = self
            .coming
            .iter()
            .enumerate()
            .min_by_key(|(_, (due, _))| *due);
        let look = call.next_look();
        match (due.map(|(index, (due, _))| (index, *due)), look) {
            (Some((index, due)), Some(look)) if due < look => {
                self.now = self.now.max(due);
                self.coming.swap_remove(index).1
            }
            (Some((index, due)), None) => {
                self.now = self.now.max(due);
                self.coming.swap_remove(index).1
            }
            (_, look) => {
                self.now = self.now.max(look.unwrap_or(self.now));
                Event::Look
            }
        }
    }
}

#[test]
fn whatever_the_network_does_there_is_one_final_answer_in_time() {
    for seed in 1..3000 {
        let mut storm = Storm {
            state: seed * 0x9e37_79b9_7f4a_7c15,
            now: 0,
            live: Vec::new(),
            coming: Vec::new(),
        };
        let deadline = (seed % 2 == 0).then_some(500 * MS);
        let mut call = call(deadline);
        let mut finals = 0;
        let mut shortest = f64::INFINITY;
        let mut event = Event::Look;
        for _ in 0..10_000 {
            let actions = call.handle(event, storm.now, &storm.live.clone());
            for action in actions {
                match action {
                    Action::Send { query, .. } => storm.query(query, false),
                    Action::Again { query, .. } => storm.query(query, true),
                    Action::Fail(_) => finals += 1,
                    Action::Deliver => match event {
                        Event::Answered(_, answer) if answer.is_final => finals += 1,
                        Event::Answered(_, answer) => {
                            assert!(answer.length < shortest, "seed {seed}");
                            shortest = answer.length;
                        }
                        other => panic!("seed {seed}: {other:?} delivered"),
                    },
                    Action::Cancel(_) | Action::Finish(_) => {}
                }
            }
            if call.is_ended() && storm.coming.is_empty() {
                break;
            }
            if storm.below(4) == 0 {
                storm.change();
            }
            event = storm.next(&call);
            if let (Some(deadline), false) = (deadline, call.is_ended()) {
                assert!(storm.now <= deadline + GRACE, "seed {seed}");
            }
        }
        assert_eq!(finals, 1, "seed {seed}");
    }
}
