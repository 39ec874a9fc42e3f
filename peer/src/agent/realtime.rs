//! Real time: frames set the clock, and the process runs its agent when it is due, whether or not other
//! processes are late.

use std::ops::ControlFlow;
use std::time::Duration;

use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;
use csat_proto::control::Order;
use csat_proto::time::{SimTime, Step};

use super::AgentError;
use super::input::{AgentInput, RawFrame, RawMessage, Timer};
use super::shell::{CurrentStep, Shell};
use crate::world::report::Scope;

/// The part of a period for which the process waits for messages of the same step.
const GRACE_SHARE: f64 = 0.1;

/// A process in real time.
pub(super) struct Realtime<M: Mission> {
    shell: Shell<M>,
    /// Simulated seconds in a second.
    speed: f64,
    now: CurrentStep,
    /// Since the frame of this step came.
    since_frame: Stopwatch,
}

impl<M: Mission> Realtime<M> {
    /// The first step begins.
    pub fn start(shell: Shell<M>, first: &RawFrame, speed: f64) -> Result<Self, AgentError> {
        let (now, since_frame) = (CurrentStep::of(&first.header), Stopwatch::start());
        let mut process = Self { shell, speed, now, since_frame };
        // Only at the first step: later, messages of earlier steps may still be on their way.
        process.shell.queue.skip(&first.header.said, now.time);
        process.begin_step(first)?;
        process.shell.catch_up(first);
        Ok(process)
    }

    /// Handles inputs until the mission is over. Returns the reason that the world gives.
    pub fn run(mut self) -> Result<String, AgentError> {
        loop {
            match self.shell.port.next(self.timer()) {
                AgentInput::Frame(frame) if self.shell.port.is_outdated(frame.header.step) => {}
                AgentInput::Frame(frame) => self.begin_step(&frame)?,
                AgentInput::Order(Order::Turn { step, round, .. }) => {
                    self.shell.refuse_turn(step, round);
                }
                AgentInput::Order(Order::Close { step, full }) => {
                    self.report(step, Scope::of_step(full));
                }
                AgentInput::Order(Order::Show { step }) => self.report(step, Scope::Final),
                AgentInput::Message(message) => self.hear(message),
                AgentInput::Timeout(Timer::Due) => self.run_agent(),
                input => {
                    if let ControlFlow::Break(reason) = self.shell.handle(input, Some(&self.now))? {
                        return Ok(reason);
                    }
                }
            }
        }
    }

    /// When to run the agent: when it is due in this step, or after the grace for other messages.
    fn timer(&self) -> Option<(Timer, Duration)> {
        let CurrentStep { time, next, .. } = self.now;
        let due_s = self.due()?.max(time).seconds_since(time);
        let grace_s = GRACE_SHARE * next.seconds_since(time);
        let after = Duration::try_from_secs_f64((due_s + grace_s) / self.speed);
        Some((Timer::Due, self.since_frame.left(after.unwrap_or(Duration::MAX))))
    }

    /// When the agent is due, if that is before the next frame.
    fn due(&self) -> Option<SimTime> {
        self.shell.node.next_due().filter(|due| *due < self.now.next)
    }

    fn begin_step(&mut self, frame: &RawFrame) -> Result<(), AgentError> {
        self.since_frame = Stopwatch::start();
        self.now = CurrentStep::of(&frame.header);
        self.shell.begin_step(frame)
    }

    fn hear(&mut self, message: RawMessage) {
        if self.shell.push(message) {
            for said in self.shell.queue.take_all() {
                self.shell.node.hear(&said);
            }
        }
    }

    fn run_agent(&mut self) {
        let Some(due) = self.due() else { return };
        let at = due.max(self.now.time);
        self.shell.run(at, &self.now);
        self.shell.talk(at);
        self.shell.done(self.now.step, 1);
    }

    /// The step that is over may be one whose frame this process skipped.
    fn report(&mut self, step: Step, scope: Scope) {
        let Self { shell, now, .. } = self;
        let newest = shell.port.newest_frame().unwrap_or(now.step);
        if (now.step..=newest).contains(&step) {
            shell.report(now, 0, scope);
        } else {
            shell.refuse_end(step, now);
        }
    }
}
