//! Real time: frames set the clock, and what is due is done when its time has come, whoever is late.

use std::time::Duration;

use csat_proto::control::Pace;
use csat_proto::time::{SimTime, Step};

use super::{Clock, Shell};
use csat_mission::mission::Mission;

/// The part of a period for which others' messages are waited for.
const GRACE_SHARE: f64 = 0.1;

impl<M: Mission> Shell<M> {
    /// Whether a newer frame than that of a step has come already.
    pub(super) fn is_late(&self, step: Step) -> bool {
        self.pace != Pace::Lockstep && self.desk.newest_frame() > Some(step)
    }

    /// In real time: when to do what is due in this step.
    fn due_with_grace(&self, clock: &Clock) -> Option<SimTime> {
        let due = self.node.next_due().filter(|due| *due < clock.next)?;
        let grace_s = GRACE_SHARE * clock.next.seconds_since(clock.time);
        Some(due.max(clock.time).after(grace_s))
    }

    /// How long nothing has to be done if nothing comes.
    pub(super) fn left_until_due(&self, clock: &Clock, speed: f64) -> Duration {
        match self.due_with_grace(clock) {
            Some(due) => clock.watch.left(wall(due.seconds_since(clock.time), speed)),
            None => Duration::from_secs(1),
        }
    }

    /// Does what is due, if its time has come.
    pub(super) fn run_if_due(&mut self, clock: Clock, speed: f64) {
        let due = self.node.next_due().filter(|due| *due < clock.next);
        let is_over = self.due_with_grace(&clock).is_some_and(|due| {
            clock.watch.left(wall(due.seconds_since(clock.time), speed)).is_zero()
        });
        if let Some(due) = due.filter(|_| is_over) {
            let now = due.max(clock.time);
            self.node.run(now);
            self.tell();
            self.talk(now);
            self.answer(clock.step, 1);
        }
    }
}

/// Simulated seconds in real time.
fn wall(simulated_s: f64, speed: f64) -> Duration {
    Duration::try_from_secs_f64(simulated_s / speed).unwrap_or(Duration::MAX)
}
