//! Lockstep: the world announces what everybody said, and the process takes its turn once it holds all of it.

use csat_proto::control::{Pace, SaidSoFar};
use csat_proto::time::{SimTime, Step};

use super::{AgentError, Shell};
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;

/// A turn that waits for messages.
pub(super) struct Turn {
    pub(super) step: Step,
    pub(super) round: u32,
    pub(super) now: SimTime,
    pub(super) said: Vec<SaidSoFar>,
    pub(super) waiting: Stopwatch,
}

impl<M: Mission> Shell<M> {
    pub(super) fn check_patience(&self) -> Result<(), AgentError> {
        let Some(turn) = &self.turn else { return Ok(()) };
        let is_over = turn.waiting.left(self.patience).is_zero();
        match self.queue.lacks(&turn.said, self.id) {
            Some((from, radio, number)) if is_over => Err(AgentError::Silence {
                limit_s: self.patience.as_secs(),
                step: turn.step,
                from,
                radio,
                number,
            }),
            _ => Ok(()),
        }
    }

    /// Lockstep: the world says that a turn is to be taken. The first one that can be next counts.
    pub(super) fn begin_turn(&mut self, turn: Turn) {
        // Who does not fly yet hears the orders to those that do.
        let Some(clock) = self.clock else { return };
        let is_expected = self.pace == Pace::Lockstep && self.turn.is_none();
        let is_next = is_expected && (turn.step, turn.round) == (clock.step, self.round + 1);
        let is_in_step = (clock.time..clock.next).contains(&turn.now);
        if !(is_next && is_in_step && turn.said.iter().all(|said| said.is_possible(turn.step))) {
            let reason = format!("turn {} of step {} cannot be next", turn.round, turn.step);
            self.desk.refusals().count("order", &reason);
            return;
        }
        self.turn = Some(turn);
        self.try_turn();
    }

    /// Lockstep: takes the turn once all that was announced is here.
    pub(super) fn try_turn(&mut self) {
        let Some(mut turn) = self.turn.take() else { return };
        // Those who are gone may have left something unsaid.
        let lost = &self.lost;
        turn.said.retain(|said| !lost.contains(&said.agent));
        if self.queue.lacks(&turn.said, self.id).is_some() {
            self.turn = Some(turn);
            return;
        }
        for said in self.queue.hear(&turn.said, self.id) {
            self.node.hear(&said);
        }
        if self.node.next_due().is_some_and(|due| due <= turn.now) {
            self.node.run(turn.now);
            self.tell();
        }
        self.talk(turn.now);
        self.round = turn.round;
        self.answer(turn.step, turn.round);
    }
}
