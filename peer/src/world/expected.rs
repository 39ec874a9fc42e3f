//! What the world waits for: it believes an answer or a report only if it is of that.
//!
//! An answer carries the number of its process, which is no secret: every process that subscribes reads
//! it. So the world checks what it asked for, and the first answer that fits counts.

use csat_proto::control::{Done, Pace, SaidSoFar};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use super::report::{ReportHeader, Scope};

/// What the world waits for in the present step.
#[derive(Debug)]
pub struct Expected {
    /// How time passes.
    pub pace: Pace,
    /// k.
    pub step: Step,
    /// Lockstep: the present turn, 0 for the frame.
    pub round: u32,
    /// The last request for a report in this step.
    pub scope: Option<Scope>,
    /// The life of each agent, by index.
    pub lives: Vec<Option<Incarnation>>,
}

/// Why the world refuses an answer or a report.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Unexpected {
    /// Another process than the agent's.
    #[error("process {0} does not fly it")]
    Process(u64),
    /// An answer to what the world did not ask.
    #[error("turn {} of step {}, at {} of {}", got.1, got.0, now.1, now.0)]
    Turn {
        /// The answer's step and turn.
        got: (Step, u32),
        /// The present step and turn.
        now: (Step, u32),
    },
    /// A report that the world did not ask for.
    #[error("of turn {} of step {}, at {} of {}", got.1, got.0, now.1, now.0)]
    Report {
        /// The report's step and turn.
        got: (Step, u32),
        /// The present step and turn.
        now: (Step, u32),
    },
    /// More or fewer messages than the agent can have sent.
    #[error("UAV {} cannot have said {:?} in life {}", .0.agent, .0.next, .0.incarnation)]
    Said(SaidSoFar),
    /// A report of another form.
    #[error(transparent)]
    Form(#[from] postcard::Error),
}

impl Expected {
    /// Before the first step.
    pub fn new(pace: Pace) -> Self {
        Self { pace, step: Step(0), round: 0, scope: None, lives: Vec::new() }
    }

    /// A step begins, with these lives.
    pub fn begin(&mut self, step: Step, lives: &[Option<Incarnation>]) {
        *self = Self { step, lives: lives.to_vec(), ..Self::new(self.pace) };
    }

    /// Checks an answer of an agent. `last` is the step and turn of its answer before, `before` how many
    /// messages it had sent by then.
    ///
    /// # Errors
    /// When the answer cannot be the agent's next one.
    pub fn check_done(
        &self,
        agent: AgentId,
        last: Option<(Step, u32)>,
        before: Option<&SaidSoFar>,
        done: &Done,
    ) -> Result<(), Unexpected> {
        let (now, got) = ((self.step, self.round), (done.step, done.round));
        let is_asked_for = match self.pace {
            Pace::Lockstep => got == now && last != Some(got),
            Pace::Realtime(_) => done.step <= self.step,
        };
        if !is_asked_for {
            return Err(Unexpected::Turn { got, now });
        }
        let Some(said) = &done.said else { return Ok(()) };
        let before = before.filter(|before| before.incarnation == said.incarnation);
        let goes_on = before.is_none_or(|before| {
            said.next.iter().zip(&before.next).all(|(next, before)| next >= before)
        });
        // In real time the agent's process may not know yet that another life has begun.
        let life = self.lives.get(usize::from(agent.0));
        let is_own = self.pace != Pace::Lockstep || life == Some(&Some(said.incarnation));
        if said.agent == agent && is_own && goes_on && said.is_possible(self.step) {
            return Ok(());
        }
        Err(Unexpected::Said(said.clone()))
    }

    /// Checks a report. In lockstep it is of the state after the last turn and of the scope that this
    /// world asked for, so that a report that another process asked for is never taken for it.
    ///
    /// # Errors
    /// When the report cannot be the one that the world asked for.
    pub fn check_report(&self, header: &ReportHeader) -> Result<(), Unexpected> {
        let (now, got) = ((self.step, self.round), (header.step, header.round));
        let is_expected = match self.pace {
            Pace::Lockstep => got == now && Some(header.scope) == self.scope,
            Pace::Realtime(_) => header.step <= self.step,
        };
        if is_expected { Ok(()) } else { Err(Unexpected::Report { got, now }) }
    }

    /// Whether a report has the scope of the last request: in real time it may answer an earlier one.
    pub fn is_in_full(&self, header: &ReportHeader) -> bool {
        self.scope != Some(Scope::Final) || header.scope == Scope::Final
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn expected(pace: Pace) -> Expected {
        let mut expected = Expected::new(pace);
        expected.begin(Step(7), &[None, Some(Incarnation(2))]);
        expected.round = 3;
        expected
    }

    fn done(step: u32, round: u32, life: u32, next: u64) -> Done {
        let (agent, incarnation) = (AgentId(1), Incarnation(life));
        let said = Some(SaidSoFar { agent, incarnation, next: vec![next] });
        Done { process: 1, step: Step(step), round, said, due: None, commands: Vec::new() }
    }

    #[test]
    fn the_first_answer_to_what_was_asked_counts() {
        let expected = expected(Pace::Lockstep);
        let check = |last, before: Option<&Done>, done: &Done| {
            let before = before.and_then(|done| done.said.as_ref());
            expected.check_done(AgentId(1), last, before, done)
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
        assert!(expected.check_done(AgentId(0), None, None, &right).is_err(), "another's");
    }

    #[test]
    fn in_real_time_answers_are_late_but_never_early() {
        let expected = expected(Pace::Realtime(1.0));
        for (step, is_right) in [(3, true), (7, true), (8, false)] {
            let checked = expected.check_done(AgentId(1), None, None, &done(step, 0, 2, 9));
            assert_eq!(checked.is_ok(), is_right, "{step}");
        }
    }

    #[test]
    fn a_report_is_of_what_was_asked_for() {
        let header = |step, round, scope| ReportHeader {
            process: 1,
            step: Step(step),
            round,
            scope,
            frames: 0,
            refused: BTreeMap::new(),
        };
        let mut expected = expected(Pace::Lockstep);
        assert!(
            expected.check_report(&header(7, 3, Scope::Brief)).is_err(),
            "the world asked for none"
        );
        expected.scope = Some(Scope::Full);
        assert!(expected.check_report(&header(7, 3, Scope::Full)).is_ok());
        for wrong in
            [header(7, 3, Scope::Brief), header(7, 2, Scope::Full), header(6, 3, Scope::Full)]
        {
            assert!(expected.check_report(&wrong).is_err(), "{wrong:?}");
        }
        (expected.pace, expected.scope) = (Pace::Realtime(1.0), Some(Scope::Final));
        let late = header(5, 0, Scope::Brief);
        assert!(expected.check_report(&late).is_ok() && !expected.is_in_full(&late));
        assert!(expected.check_report(&header(8, 0, Scope::Final)).is_err());
    }
}
