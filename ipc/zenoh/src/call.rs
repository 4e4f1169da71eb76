//! The rules of a client whose request may be lost, answered twice or answered by another gateway.
//!
//! A [`Call`] is one request until its one final answer. It has no clock, thread or network: events
//! go in with the time and the gateways that are there, what is to be done comes out. Everything
//! that the network does not promise is made up for here, and nowhere else: the end of a stream of
//! replies means nothing, a query may run twice, a reply may come twice or late.

mod rules;
#[cfg(test)]
mod tests;

pub use rules::Nanos;
use rules::*;
use std::sync::Arc;
use taut_ipc::wire::{RequestFlags, RequestHeader, ResponseHeader, Status};

/// A start of a gateway's daemon.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Gateway {
    /// The daemon's name on the network.
    pub name: Arc<str>,
    /// Changes with every start of the daemon.
    pub boot: u64,
}

/// A gateway's daemon does not have what a request names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lack {
    /// It is being brought there.
    Coming,
    /// Others had it, and nobody can bring it.
    Elsewhere,
}

/// What an answer says to the rules.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Whether it is the last.
    pub is_final: bool,
    /// Length of its path.
    pub length: f64,
    /// Why it is none, where the same gateway later, or another, may give one.
    pub lack: Option<Lack>,
}

impl Answer {
    /// Of a response's header.
    pub fn of(header: &ResponseHeader) -> Self {
        Self {
            is_final: header.status == u32::from(Status::Final),
            length: header.length_after,
            lack: None,
        }
    }
}

/// What happens to a call. Queries are counted from 0.
#[derive(Clone, Copy, Debug)]
pub enum Event {
    /// Time passed, or gateways came or went.
    Look,
    /// An answer came to a query.
    Answered(u32, Answer),
    /// The gateway asked again does not know the request.
    Unknown(u32),
    /// No more replies come to a query.
    Ended(u32),
    /// The caller wants the best so far, now.
    Finish,
    /// The caller does not want it any more.
    Cancel,
}

/// What is to be done, in order.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Send the request.
    Send {
        /// Where.
        gateway: Gateway,
        /// Number of the query.
        query: u32,
        /// Time left to the deadline, at least 1.
        left: Option<Nanos>,
    },
    /// Ask for the answers to the request that was sent.
    Again {
        /// Where.
        gateway: Gateway,
        /// Number of the query.
        query: u32,
    },
    /// Have a gateway drop the request.
    Cancel(Gateway),
    /// Have a gateway answer with the best so far.
    Finish(Gateway),
    /// Give the answer in hand to the caller.
    Deliver,
    /// The final answer is made here.
    Fail(Failure),
}

/// Why the final answer is none of a daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The deadline passed, and nothing came for a while after it.
    TimedOut,
    /// No gateway is there, or those that are do not answer.
    Lost,
}

#[derive(Clone, Debug)]
enum State {
    /// For a gateway.
    Waits,
    /// Before it is sent again.
    Rests {
        until: Nanos,
    },
    /// A query is out.
    Asks {
        gateway: Gateway,
        is_again: bool,
    },
    Ended,
}

/// One request.
#[derive(Debug)]
pub struct Call {
    deadline: Option<Nanos>,
    is_watch: bool,
    state: State,
    /// Whom each query went to, and when.
    queries: Vec<(Gateway, Nanos)>,
    /// Whom not to ask next, if there is another.
    failed: Option<Gateway>,
    shortest: f64,
    pause: Nanos,
    losses: u32,
    /// Since when no gateway is there.
    alone_since: Option<Nanos>,
    /// Since when nobody has replied.
    unserved_since: Option<Nanos>,
    /// Since when those that are there lack what others had.
    lacking_since: Option<Nanos>,
    /// When something last came or was sent.
    heard: Nanos,
    silence: Nanos,
    is_asked_late: bool,
    wants_best: bool,
    late: u32,
}

impl Call {
    /// Of a request whose deadline is absolute, on the clock of `now`.
    pub fn new(header: &RequestHeader, now: Nanos) -> Self {
        Self {
            deadline: Some(header.deadline_ns).filter(|deadline| *deadline > 0),
            is_watch: header.flags & RequestFlags::WATCH != 0,
            state: State::Waits,
            queries: Vec::new(),
            failed: None,
            shortest: f64::INFINITY,
            pause: FIRST_PAUSE,
            losses: 0,
            alone_since: None,
            unserved_since: None,
            lacking_since: None,
            heard: now,
            silence: FIRST_SILENCE,
            is_asked_late: false,
            wants_best: false,
            late: 0,
        }
    }

    /// Takes an event; `live` are the gateways that are there, best first.
    pub fn handle(&mut self, event: Event, now: Nanos, live: &[Gateway]) -> Vec<Action> {
        let mut actions = Vec::new();
        match event {
            Event::Answered(query, answer) => self.answered(query, answer, now, live, &mut actions),
            _ if self.is_ended() => {}
            Event::Look => self.look(now, live, &mut actions),
            Event::Unknown(query) => self.unknown(query, now, live, &mut actions),
            Event::Ended(query) => self.ended(query, now, live, &mut actions),
            Event::Finish => self.finish(&mut actions),
            Event::Cancel => self.end(None, live, &mut actions),
        }
        actions
    }

    /// Whether it has had its final answer, or was cancelled.
    pub fn is_ended(&self) -> bool {
        matches!(self.state, State::Ended)
    }

    /// Final answers that came after its own.
    pub fn late(&self) -> u32 {
        self.late
    }

    /// Whom a query went to, and when.
    pub fn asked(&self, query: u32) -> Option<&(Gateway, Nanos)> {
        self.queries.get(query as usize)
    }

    /// How often the request was sent or asked for before.
    pub fn attempts(&self) -> u32 {
        self.queries.len().saturating_sub(1) as u32
    }

    /// When [`Event::Look`] is due at the latest.
    pub fn next_look(&self) -> Option<Nanos> {
        let own = match &self.state {
            State::Ended => return None,
            State::Waits => self.alone_since.map(|since| since + ALONE),
            State::Rests { until } => Some(*until),
            State::Asks { .. } => Some(self.heard + self.silence),
        };
        own.into_iter().chain(self.late_look()).min()
    }

    fn late_look(&self) -> Option<Nanos> {
        let wait = match self.state {
            State::Asks { .. } if !self.is_asked_late => LATE,
            _ => GRACE,
        };
        self.deadline
            .map(|deadline| deadline.saturating_add(wait))
    }

    fn look(&mut self, now: Nanos, live: &[Gateway], actions: &mut Vec<Action>) {
        if self.is_past(now, GRACE) {
            return self.fail(Failure::TimedOut, live, actions);
        }
        match self.state.clone() {
            State::Ended => {}
            State::Waits => self.send(now, live, actions),
            State::Rests { until } if now < until => {}
            State::Rests { .. } => self.send(now, live, actions),
            State::Asks { gateway, .. } if !live.contains(&gateway) => {
                self.lost(gateway, now, live, actions);
            }
            State::Asks { gateway, .. } => self.wait_for(gateway, now, actions),
        }
    }

    /// Nothing came for long, or after the deadline: what was sent may have been lost.
    fn wait_for(&mut self, gateway: Gateway, now: Nanos, actions: &mut Vec<Action>) {
        let is_late = !self.is_asked_late && self.is_past(now, LATE);
        if is_late || now >= self.heard + self.silence {
            self.is_asked_late |= is_late;
            self.silence = (self.silence * 2).min(LONGEST_SILENCE);
            self.ask_again(gateway, now, actions);
        }
    }

    fn is_past(&self, now: Nanos, wait: Nanos) -> bool {
        self.deadline
            .is_some_and(|deadline| now >= deadline.saturating_add(wait))
    }

    fn answered(
        &mut self,
        query: u32,
        answer: Answer,
        now: Nanos,
        live: &[Gateway],
        actions: &mut Vec<Action>,
    ) {
        if self.is_ended() {
            self.late += u32::from(answer.is_final);
            return;
        }
        self.hear(now);
        if let Some(lack) = answer.lack
            && !self.has_waited(lack, now)
        {
            return self.lacking(query, lack, now);
        }
        if answer.is_final {
            actions.push(Action::Deliver);
            return self.end(Some(query), live, actions);
        }
        if self.is_watch || answer.length < self.shortest {
            self.shortest = answer.length;
            actions.push(Action::Deliver);
        }
    }

    /// Whether a final answer that says what is lacking is the answer: nothing came for long, or would
    /// before the deadline.
    fn has_waited(&mut self, lack: Lack, now: Nanos) -> bool {
        if lack == Lack::Coming {
            return false;
        }
        let since = *self.lacking_since.get_or_insert(now);
        let next = now + self.pause;
        now >= since + ALONE
            || self
                .deadline
                .is_some_and(|deadline| next >= deadline)
    }

    /// The run has ended for nothing: another gateway may have what is lacking, or this one soon.
    fn lacking(&mut self, query: u32, lack: Lack, now: Nanos) {
        if !self.is_current(query) {
            return;
        }
        if lack == Lack::Elsewhere {
            self.failed = self
                .asked(query)
                .map(|(gateway, _)| gateway.clone());
        }
        self.rest(now);
    }

    fn hear(&mut self, now: Nanos) {
        self.heard = now;
        self.silence = FIRST_SILENCE;
        self.unserved_since = None;
    }

    fn unknown(&mut self, query: u32, now: Nanos, live: &[Gateway], actions: &mut Vec<Action>) {
        if !self.is_current(query) {
            return;
        }
        self.hear(now);
        self.losses += 1;
        self.failed = None;
        match self.losses {
            1 => self.send(now, live, actions),
            _ => self.rest(now),
        }
    }

    fn ended(&mut self, query: u32, now: Nanos, live: &[Gateway], actions: &mut Vec<Action>) {
        if !self.is_current(query) {
            return;
        }
        let State::Asks { gateway, is_again } = self.state.clone() else {
            return;
        };
        if !live.contains(&gateway) {
            return self.lost(gateway, now, live, actions);
        }
        if !is_again {
            return self.ask_again(gateway, now, actions);
        }
        let since = *self.unserved_since.get_or_insert(now);
        if now >= since + UNSERVED {
            return self.fail(Failure::Lost, live, actions);
        }
        self.failed = Some(gateway);
        self.rest(now);
    }

    fn is_current(&self, query: u32) -> bool {
        matches!(self.state, State::Asks { .. }) && query as usize + 1 == self.queries.len()
    }

    /// The gateway that was asked is not there any more.
    fn lost(&mut self, gateway: Gateway, now: Nanos, live: &[Gateway], actions: &mut Vec<Action>) {
        self.losses += 1;
        self.failed = Some(gateway);
        self.send(now, live, actions);
    }

    fn rest(&mut self, now: Nanos) {
        let until = now + self.pause;
        self.pause = (self.pause * 2).min(LONGEST_PAUSE);
        self.state = State::Rests { until };
    }

    fn send(&mut self, now: Nanos, live: &[Gateway], actions: &mut Vec<Action>) {
        if self.losses >= MOST_LOSSES {
            return self.fail(Failure::Lost, live, actions);
        }
        let Some(gateway) = self.choice(live) else {
            return self.wait_for_any(now, live, actions);
        };
        self.alone_since = None;
        let left = self
            .deadline
            .map(|deadline| deadline.saturating_sub(now).max(1));
        let query = self.asks(&gateway, false, now);
        actions.push(Action::Send {
            gateway: gateway.clone(),
            query,
            left,
        });
        if self.wants_best {
            actions.push(Action::Finish(gateway));
        }
    }

    /// The best that has not just failed.
    fn choice(&self, live: &[Gateway]) -> Option<Gateway> {
        let others = live
            .iter()
            .find(|gateway| Some(*gateway) != self.failed.as_ref());
        others.or(live.first()).cloned()
    }

    fn wait_for_any(&mut self, now: Nanos, live: &[Gateway], actions: &mut Vec<Action>) {
        self.state = State::Waits;
        let since = *self.alone_since.get_or_insert(now);
        if now >= since + ALONE {
            self.fail(Failure::Lost, live, actions);
        }
    }

    fn ask_again(&mut self, gateway: Gateway, now: Nanos, actions: &mut Vec<Action>) {
        let query = self.asks(&gateway, true, now);
        actions.push(Action::Again { gateway, query });
    }

    /// Notes a query; gives its number.
    fn asks(&mut self, gateway: &Gateway, is_again: bool, now: Nanos) -> u32 {
        self.heard = now;
        self.queries.push((gateway.clone(), now));
        self.state = State::Asks {
            gateway: gateway.clone(),
            is_again,
        };
        self.attempts()
    }

    fn finish(&mut self, actions: &mut Vec<Action>) {
        self.wants_best = true;
        if let State::Asks { gateway, .. } = &self.state {
            actions.push(Action::Finish(gateway.clone()));
        }
    }

    fn fail(&mut self, failure: Failure, live: &[Gateway], actions: &mut Vec<Action>) {
        actions.push(Action::Fail(failure));
        self.end(None, live, actions);
    }

    /// Nothing more is wanted: of those that were asked, whoever has not given the final answer may
    /// still be at it.
    fn end(&mut self, by: Option<u32>, live: &[Gateway], actions: &mut Vec<Action>) {
        let asked: Vec<&Gateway> = self
            .queries
            .iter()
            .map(|(gateway, _)| gateway)
            .collect();
        let answerer = by.and_then(|query| asked.get(query as usize));
        let others = live
            .iter()
            .filter(|gateway| asked.contains(gateway) && Some(gateway) != answerer);
        actions.extend(others.cloned().map(Action::Cancel));
        self.state = State::Ended;
    }
}
