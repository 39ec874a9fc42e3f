//! Lockstep: the world announces how many messages all agents have sent, and the process takes its turn
//! once it holds all of them. The order in which Zenoh delivers them decides nothing.

use std::ops::ControlFlow;
use std::time::Duration;

use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;
use csat_proto::control::{Order, SaidSoFar};
use csat_proto::time::{SimTime, Step};

use super::AgentError;
use super::input::{AgentInput, RawFrame, Timer};
use super::shell::{CurrentStep, Shell};
use crate::world::report::Scope;

/// A process in lockstep.
pub(super) struct Lockstep<M: Mission> {
    shell: Shell<M>,
    now: CurrentStep,
    /// The turn of this step that the process has finished, 0 for the frame.
    round: u32,
    /// The turn that waits for messages.
    turn: Option<Turn>,
}

/// A turn that waits for messages.
struct Turn {
    step: Step,
    round: u32,
    at: SimTime,
    said: Vec<SaidSoFar>,
    since: Stopwatch,
}

impl<M: Mission> Lockstep<M> {
    /// The first step begins.
    pub fn start(shell: Shell<M>, first: &RawFrame) -> Result<Self, AgentError> {
        let now = CurrentStep::of(&first.header);
        let mut process = Self { shell, now, round: 0, turn: None };
        process.begin_step(first)?;
        process.shell.catch_up(first);
        Ok(process)
    }

    /// Handles inputs until the mission is over. Returns the reason that the world gives.
    pub fn run(mut self) -> Result<String, AgentError> {
        loop {
            match self.shell.port.next(self.timer()) {
                AgentInput::Frame(frame) => self.begin_step(&frame)?,
                AgentInput::Order(Order::Turn { step, round, now, said }) => {
                    let since = Stopwatch::start();
                    self.begin_turn(Turn { step, round, at: now, said, since });
                }
                AgentInput::Order(Order::Close { step, full }) => {
                    self.report(step, Scope::of_step(full));
                }
                AgentInput::Order(Order::Show { step }) => self.report(step, Scope::Final),
                AgentInput::Message(message) => {
                    self.shell.push(message);
                    self.try_turn();
                }
                AgentInput::Gone(agent) => {
                    self.shell.lose(agent);
                    self.try_turn();
                }
                AgentInput::Timeout(Timer::Patience) => self.check_turn()?,
                input => {
                    if let ControlFlow::Break(reason) = self.shell.handle(input, Some(&self.now))? {
                        return Ok(reason);
                    }
                }
            }
        }
    }

    fn timer(&self) -> Option<(Timer, Duration)> {
        let turn = self.turn.as_ref()?;
        Some((Timer::Patience, turn.since.left(self.shell.patience)))
    }

    /// A turn has waited long enough: a message that it lacks is an error.
    fn check_turn(&self) -> Result<(), AgentError> {
        let Some(turn) = &self.turn else { return Ok(()) };
        let (step, limit_s) = (turn.step, self.shell.patience.as_secs());
        match self.shell.queue.first_missing(&turn.said, self.shell.id) {
            Some((from, radio, number)) => {
                Err(AgentError::MissingMessage { limit_s, step, from, radio, number })
            }
            None => Ok(()),
        }
    }

    fn begin_step(&mut self, frame: &RawFrame) -> Result<(), AgentError> {
        self.now = CurrentStep::of(&frame.header);
        self.round = 0;
        self.shell.queue.skip(&frame.header.said, self.now.time);
        self.shell.begin_step(frame)?;
        self.try_turn();
        Ok(())
    }

    /// The world orders a turn. The first order that can be the next one counts.
    fn begin_turn(&mut self, turn: Turn) {
        let is_next = self.turn.is_none()
            && (turn.step, turn.round) == (self.now.step, self.round + 1)
            && (self.now.time..self.now.next).contains(&turn.at)
            && turn.said.iter().all(|said| said.is_possible(turn.step));
        if !is_next {
            self.shell.refuse_turn(turn.step, turn.round);
            return;
        }
        self.turn = Some(turn);
        self.try_turn();
    }

    /// Takes the turn that waits, if all messages that the world announced are here.
    fn try_turn(&mut self) {
        let Some(mut turn) = self.turn.take() else { return };
        let Self { shell, now, .. } = self;
        // A process that is gone may have died before it sent all that it announced.
        turn.said.retain(|said| !shell.gone.contains(&said.agent));
        if shell.queue.first_missing(&turn.said, shell.id).is_some() {
            self.turn = Some(turn);
            return;
        }
        for said in shell.queue.take(&turn.said, shell.id) {
            shell.node.hear(&said);
        }
        if shell.node.next_due().is_some_and(|due| due <= turn.at) {
            shell.run(turn.at, now);
        }
        shell.talk(turn.at);
        shell.done(turn.step, turn.round);
        self.round = turn.round;
    }

    fn report(&mut self, step: Step, scope: Scope) {
        let Self { shell, now, round, .. } = self;
        if step == now.step {
            shell.report(now, *round, scope);
        } else {
            shell.refuse_end(step, now);
        }
    }
}
