//! How far the world is: what an answer must be of to be believed.
//!
//! Answers bear the number of their process, which is no secret: whoever listens knows it. So what
//! decides is what was asked for, and the first answer that fits counts.

use csat_proto::control::{Done, Pace, SaidSoFar};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use super::account::{Asked, Head};

/// What is flown now.
#[derive(Debug)]
pub struct Now {
    /// How time passes.
    pub pace: Pace,
    /// k.
    pub step: Step,
    /// Lockstep: the turn that is taken, 0 for the frame.
    pub round: u32,
    /// What agents were asked for last in this step.
    pub asked: Option<Asked>,
    /// The life of each agent, by index.
    pub lives: Vec<Option<Incarnation>>,
}

impl Now {
    /// Before anything is asked.
    pub fn new(pace: Pace) -> Self {
        Self { pace, step: Step(0), round: 0, asked: None, lives: Vec::new() }
    }

    /// A step begins, with these lives.
    pub fn begin(&mut self, step: Step, lives: &[Option<Incarnation>]) {
        *self = Self { step, lives: lives.to_vec(), ..Self::new(self.pace) };
    }

    /// Checks an answer of an agent that answered `last` before and had said `before` by then.
    ///
    /// # Errors
    /// Why it cannot be one, in words.
    pub fn check_done(
        &self,
        agent: AgentId,
        last: Option<(Step, u32)>,
        before: Option<&SaidSoFar>,
        done: &Done,
    ) -> Result<(), String> {
        let (step, round, got) = (self.step, self.round, (done.step, done.round));
        let is_asked_for = match self.pace {
            Pace::Lockstep => got == (step, round) && last != Some(got),
            Pace::Realtime(_) => done.step <= step,
        };
        if !is_asked_for {
            return Err(format!("turn {} of step {}, at {round} of {step}", got.1, got.0));
        }
        let Some(said) = &done.said else { return Ok(()) };
        let before = before.filter(|before| before.incarnation == said.incarnation);
        let goes_on = before.is_none_or(|before| {
            said.next.iter().zip(&before.next).all(|(next, before)| next >= before)
        });
        // In real time it may not know yet that it is another life.
        let life = self.lives.get(usize::from(agent.0));
        let is_own = self.pace != Pace::Lockstep || life == Some(&Some(said.incarnation));
        if said.agent == agent && is_own && goes_on && said.is_possible(step) {
            return Ok(());
        }
        let SaidSoFar { agent, incarnation, next } = said;
        Err(format!("UAV {agent} cannot have said {next:?} in life {incarnation}"))
    }

    /// Checks a report. In lockstep it is of the state after the last turn and of what was asked for, so
    /// that one that a stranger asked for is never taken for it.
    ///
    /// # Errors
    /// Why it cannot be one, in words.
    pub fn check_report(&self, head: &Head) -> Result<(), String> {
        let (step, round) = (self.step, self.round);
        let is_expected = match self.pace {
            Pace::Lockstep => {
                (head.step, head.round, Some(head.asked)) == (step, round, self.asked)
            }
            Pace::Realtime(_) => head.step <= step,
        };
        if is_expected {
            return Ok(());
        }
        Err(format!("of turn {} of step {}, at {round} of {step}", head.round, head.step))
    }

    /// Whether a report is all that was asked for: in real time one may be late.
    pub fn is_all(&self, head: &Head) -> bool {
        self.asked != Some(Asked::All) || head.asked == Asked::All
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn now(pace: Pace) -> Now {
        let mut now = Now::new(pace);
        now.begin(Step(7), &[None, Some(Incarnation(2))]);
        now.round = 3;
        now
    }

    fn done(step: u32, round: u32, life: u32, next: u64) -> Done {
        let (agent, incarnation) = (AgentId(1), Incarnation(life));
        let said = Some(SaidSoFar { agent, incarnation, next: vec![next] });
        Done { process: 1, step: Step(step), round, said, due: None, commands: Vec::new() }
    }

    #[test]
    fn the_first_answer_to_what_was_asked_counts() {
        let now = now(Pace::Lockstep);
        let check = |last, before: Option<&Done>, done: &Done| {
            let before = before.and_then(|done| done.said.as_ref());
            now.check_done(AgentId(1), last, before, done)
        };
        let (right, before) = (done(7, 3, 2, 9), done(7, 2, 2, 8));
        assert_eq!(check(Some((Step(7), 2)), Some(&before), &right), Ok(()));
        assert!(check(Some((Step(7), 3)), Some(&before), &right).is_err(), "twice");
        for wrong in [
            done(8, 3, 2, 9),
            done(7, 4, 2, 9),
            done(6, 3, 2, 9),
            done(7, 3, 1, 9),
            done(7, 3, 2, 7),
            done(7, 3, 2, u64::MAX),
        ] {
            assert!(check(None, Some(&before), &wrong).is_err(), "{wrong:?}");
        }
        assert!(now.check_done(AgentId(0), None, None, &right).is_err(), "another's");
    }

    #[test]
    fn in_real_time_answers_are_late_but_never_early() {
        let now = now(Pace::Realtime(1.0));
        for (step, is_right) in [(3, true), (7, true), (8, false)] {
            let checked = now.check_done(AgentId(1), None, None, &done(step, 0, 2, 9));
            assert_eq!(checked.is_ok(), is_right, "{step}");
        }
    }

    #[test]
    fn a_report_is_of_what_was_asked_for() {
        let head = |step, round, asked| Head {
            process: 1,
            step: Step(step),
            round,
            asked,
            looked: 0,
            refused: BTreeMap::new(),
        };
        let mut now = now(Pace::Lockstep);
        assert!(now.check_report(&head(7, 3, Asked::Brief)).is_err(), "nothing was");
        now.asked = Some(Asked::Full);
        assert!(now.check_report(&head(7, 3, Asked::Full)).is_ok());
        for wrong in [head(7, 3, Asked::Brief), head(7, 2, Asked::Full), head(6, 3, Asked::Full)] {
            assert!(now.check_report(&wrong).is_err(), "{wrong:?}");
        }
        (now.pace, now.asked) = (Pace::Realtime(1.0), Some(Asked::All));
        let late = head(5, 0, Asked::Brief);
        assert!(now.check_report(&late).is_ok() && !now.is_all(&late));
        assert!(now.check_report(&head(8, 0, Asked::All)).is_err());
    }
}
