//! Which frames an agent's process takes for its world's next ones.
//!
//! Zenoh does not tell who sent a sample. Frames and orders carry the number of their world, which
//! excludes those of another world of the same run, or of an earlier one; and the step of a frame must be
//! possible now, so that no single frame moves the agent out of its fleet's time.

use csat_proto::control::{Pace, Welcome};
use csat_proto::time::Step;

use csat_mission::timing::Stopwatch;

/// In real time, how late the first frame may have come: later ones may seem that early, seconds.
const MAX_LATE_S: f64 = 10.0;

/// Admits frames of one world, or refuses them.
#[derive(Debug)]
pub struct FrameGate {
    world: u64,
    /// In real time, how many steps there are in a second.
    steps_per_s: Option<f64>,
    first: Option<(Step, Stopwatch)>,
    newest: Option<Step>,
}

/// Why a frame, or an order, is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FrameGateError {
    /// Another world sent it.
    #[error("it is of world {got}, expected {expected}")]
    World {
        /// The world of the sample.
        got: u64,
        /// The world of this process.
        expected: u64,
    },
    /// Its step is not after that of the frame before.
    #[error("step {step} after step {last}: steps increase")]
    Backwards {
        /// k.
        step: Step,
        /// That of the frame before.
        last: Step,
    },
    /// Its step has not begun yet.
    #[error("step {step} after step {last}, expected {furthest} at most")]
    Early {
        /// k.
        step: Step,
        /// That of the frame before.
        last: Step,
        /// The last step that can have begun.
        furthest: u32,
    },
}

impl FrameGate {
    /// A gate for frames of the world of `welcome`, in a mission of this period.
    pub fn new(welcome: &Welcome, period_s: f64) -> Self {
        let steps_per_s = match welcome.pace {
            Pace::Lockstep => None,
            Pace::Realtime(speed) => Some(speed / period_s),
        };
        Self { world: welcome.world, steps_per_s, first: None, newest: None }
    }

    /// Admits a frame that can be the next one. In lockstep no step is left out; in real time some frames
    /// get lost, but none comes before its time.
    ///
    /// # Errors
    /// When it cannot be the next one.
    pub fn admit(&mut self, world: u64, step: Step) -> Result<(), FrameGateError> {
        let elapsed_s = self.first.map_or(0.0, |(_, since)| since.elapsed_s());
        self.admit_after(world, step, elapsed_s)
    }

    fn admit_after(
        &mut self,
        world: u64,
        step: Step,
        elapsed_s: f64,
    ) -> Result<(), FrameGateError> {
        self.check_world(world)?;
        if let (Some(last), Some((first, _))) = (self.newest, self.first) {
            if step <= last {
                return Err(FrameGateError::Backwards { step, last });
            }
            let furthest = match self.steps_per_s {
                None => last.0.saturating_add(1),
                Some(steps_per_s) => {
                    let steps = (elapsed_s + MAX_LATE_S) * steps_per_s;
                    first.0.saturating_add(1).saturating_add(steps as u32)
                }
            };
            if step.0 > furthest {
                return Err(FrameGateError::Early { step, last, furthest });
            }
        }
        self.first.get_or_insert_with(|| (step, Stopwatch::start()));
        self.newest = Some(step);
        Ok(())
    }

    /// Checks that a sample is of the world of this process.
    ///
    /// # Errors
    /// When it is not.
    pub fn check_world(&self, got: u64) -> Result<(), FrameGateError> {
        let expected = self.world;
        if got == expected { Ok(()) } else { Err(FrameGateError::World { got, expected }) }
    }

    /// The step of the newest frame that was admitted.
    pub fn newest(&self) -> Option<Step> {
        self.newest
    }

    /// The same in lockstep; `None` in real time, where other agents may be far ahead of a slow process.
    pub fn newest_in_lockstep(&self) -> Option<Step> {
        self.newest.filter(|_| self.steps_per_s.is_none())
    }

    /// Whether a newer frame than that of `step` makes it useless: in real time no agent waits for a slow
    /// one, which looks at its newest frame only.
    pub fn is_outdated(&self, step: Step) -> bool {
        self.steps_per_s.is_some() && self.newest > Some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::control::PROTOCOL;
    use csat_proto::ids::RunId;

    fn gate(pace: Pace) -> FrameGate {
        let (name, scenario) = (String::new(), String::new());
        let (protocol, run) = (PROTOCOL, RunId(1));
        FrameGate::new(&Welcome { protocol, run, world: 9, name, scenario, map: None, pace }, 0.5)
    }

    #[test]
    fn in_lockstep_each_step_comes_once_and_none_is_left_out() {
        let mut gate = gate(Pace::Lockstep);
        // A process that joins late begins in the middle.
        assert_eq!(gate.admit(9, Step(40)), Ok(()));
        assert_eq!(gate.admit(9, Step(41)), Ok(()));
        let error = gate.admit(9, Step(43)).unwrap_err();
        assert_eq!(error.to_string(), "step 43 after step 41, expected 42 at most");
        let error = gate.admit(9, Step(41)).unwrap_err();
        assert_eq!(error.to_string(), "step 41 after step 41: steps increase");
        let error = gate.admit(8, Step(42)).unwrap_err();
        assert_eq!(error.to_string(), "it is of world 8, expected 9");
        assert!(gate.admit(9, Step(u32::MAX)).is_err());
        assert_eq!(gate.admit(9, Step(42)), Ok(()));
        assert_eq!(gate.newest_in_lockstep(), Some(Step(42)));
        assert!(!gate.is_outdated(Step(41)));
    }

    #[test]
    fn in_real_time_frames_get_lost_but_none_is_early() {
        // Eight steps in a second, and 80 within the ten that the first one may be late.
        let mut gate = gate(Pace::Realtime(4.0));
        assert_eq!(gate.admit_after(9, Step(3), 0.0), Ok(()));
        assert_eq!(gate.admit_after(9, Step(20), 1.0), Ok(()));
        assert!(gate.admit_after(9, Step(93), 1.0).is_err());
        assert!(gate.admit_after(9, Step(u32::MAX), 1e9).is_ok(), "after a hundred years");
        assert!(gate.is_outdated(Step(20)) && gate.newest_in_lockstep().is_none());
    }
}
