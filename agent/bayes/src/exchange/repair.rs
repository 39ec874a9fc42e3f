//! Anti-entropy: which factors other agents are missing, and which agent sends them again.
//!
//! Messages tell which factors their sender holds. A factor that is not among them although it had the time to
//! arrive is sent again by whoever holds it. All agents hear the same, so those that were heard of late take turns
//! by index: what one of them sends the others need not send any more.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use super::factor_set::FactorSet;
use super::held::{Held, Missing};
use crate::config::AgentConfig;
use crate::factor::FactorId;
use crate::mutant::{Mutant, is_on};

/// Steps that a turn takes: so long that what was sent is heard before the next one begins.
const TURN_STEPS: u32 = 2;
/// Steps that are remembered in addition to two rounds of a factor and its repair.
const MORE_STEPS: u32 = 16;
/// A factor of which a neighbour does not tell whether it holds it, because there is too much to tell, is sent
/// again after this time, seconds.
const UNTOLD_S: f64 = 60.0;
/// The most factors of which it is remembered when they were last under way. For those that were forgotten an
/// agent answers too early at worst.
const MAX_TRAVELLED: usize = 1 << 14;

/// What the other agents are missing.
#[derive(Debug, Clone)]
pub struct Repair {
    own: AgentId,
    agents: u16,
    /// Steps that a factor may be under way.
    delay: u32,
    /// Steps between two messages with factors that others are missing.
    period: u32,
    /// `UNTOLD_S` in steps.
    untold: u32,
    neighbours: BTreeMap<AgentId, Neighbour>,
    /// The step at which a factor was last sent or received.
    travelled: BTreeMap<FactorId, Step>,
}

/// What is known of another agent.
#[derive(Debug, Clone)]
struct Neighbour {
    /// Its newest incarnation.
    incarnation: Incarnation,
    /// The receiver's step when this incarnation was heard first.
    since: Step,
    /// The receiver's step when it was last heard.
    heard: Step,
    /// What it held at which of its steps.
    told: Option<(Step, Held)>,
}

impl Repair {
    /// The state before the first message.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            own: config.id,
            agents: config.agents(),
            delay: config.steps(config.exchange.repair_delay_s).max(1),
            period: config.steps(config.exchange.repair_period_s).max(1),
            untold: config.steps(UNTOLD_S).max(1),
            neighbours: BTreeMap::new(),
            travelled: BTreeMap::new(),
        }
    }

    /// The newest incarnation of an agent that was heard.
    pub fn incarnation(&self, from: AgentId) -> Option<Incarnation> {
        self.neighbours.get(&from).map(|neighbour| neighbour.incarnation)
    }

    /// A message of step `then` of an agent arrived at step `now`, with what it holds.
    pub fn hear(
        &mut self,
        now: Step,
        from: AgentId,
        incarnation: Incarnation,
        then: Step,
        held: Option<Held>,
    ) {
        let fresh = Neighbour { incarnation, since: now, heard: now, told: None };
        let neighbour = self.neighbours.entry(from).or_insert_with(|| fresh.clone());
        if incarnation < neighbour.incarnation {
            return;
        }
        if incarnation > neighbour.incarnation {
            *neighbour = fresh;
        }
        neighbour.heard = neighbour.heard.max(now);
        let is_newest = neighbour.told.as_ref().is_none_or(|(newest, _)| *newest <= then);
        if let Some(held) = held
            && is_newest
        {
            neighbour.told = Some((then, held));
        }
    }

    /// Factors were received or sent first at step `now`: they may be under way to others.
    pub fn note(&mut self, now: Step, factors: impl Iterator<Item = FactorId>) {
        self.forget(now);
        for id in factors {
            if self.travelled.len() < MAX_TRAVELLED || self.travelled.contains_key(&id) {
                let step = self.travelled.entry(id).or_insert(now);
                *step = now.max(*step);
            }
        }
    }

    /// Factors that others were missing were sent at step `now`.
    pub fn note_again(&mut self, now: Step, factors: impl Iterator<Item = FactorId>) {
        self.note(now.after(self.period), factors);
    }

    /// The factors of `set` to send again at step `now`.
    pub fn due(&self, now: Step, set: &FactorSet) -> BTreeSet<FactorId> {
        let mut due = BTreeSet::new();
        if is_on(Mutant::NeverRepairs) {
            return due;
        }
        for (from, neighbour) in &self.neighbours {
            let Some((then, held)) = &neighbour.told else { continue };
            let is_old = then.after(self.memory()) < now;
            // What travelled later than this may not have arrived when the neighbour told what it held.
            let Some(latest) = then.0.checked_sub(self.delay).map(Step) else { continue };
            if is_old || !self.is_turn(now, *from) {
                continue;
            }
            for ((source, incarnation), ours) in set.numbers() {
                if is_on(Mutant::RelaysNothing) && source != self.own {
                    continue;
                }
                // What an agent states itself it is not missing.
                if source == *from && incarnation >= neighbour.incarnation {
                    continue;
                }
                let Missing { told, untold } = held.lacks(source, incarnation, ours);
                let id = |number| FactorId { source, incarnation, number };
                let travelled = |id: &FactorId| {
                    let stated = set.get(*id).map(|factor| factor.step);
                    stated.max(self.travelled.get(id).copied())
                };
                let is_due = |id: &FactorId| travelled(id) <= Some(latest);
                due.extend(told.numbers().map(id).filter(is_due));
                let is_untold_due = |id: &FactorId| {
                    let is_past =
                        |step: Step| step < neighbour.since || step.after(self.untold) <= now;
                    is_due(id) && travelled(id).is_some_and(is_past)
                };
                due.extend(untold.numbers().map(id).filter(is_untold_due));
            }
        }
        due
    }

    /// Steps for which what was told is of use.
    fn memory(&self) -> u32 {
        let round = self.delay.saturating_add(self.period);
        round.saturating_mul(2).saturating_add(MORE_STEPS)
    }

    fn forget(&mut self, now: Step) {
        let memory = self.memory().max(self.untold);
        if self.travelled.len() >= MAX_TRAVELLED / 16 {
            self.travelled.retain(|_, step| step.after(memory) >= now);
        }
    }

    /// Whether it is the turn of this agent, among all that were heard of late, to answer `from`.
    fn is_turn(&self, now: Step, from: AgentId) -> bool {
        let agents = u32::from(self.agents.max(1));
        let place = |id: AgentId| (u32::from(id.0) + 2 * agents - u32::from(from.0) - 1) % agents;
        let round = self.delay.saturating_add(self.period);
        let is_present = |(id, neighbour): &(&AgentId, &Neighbour)| {
            **id != from && neighbour.heard.after(round) >= now
        };
        let others = self.neighbours.iter().filter(is_present).map(|(id, _)| place(*id));
        let (mut all, mut before) = (1, 0);
        for other in others {
            all += 1;
            before += u32::from(other < place(self.own));
        }
        now.0 / TURN_STEPS % all == before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::fixture::{config, factor};

    /// Agent 2 of four, which holds the first `count` factors of agent 0; a second is two steps.
    fn helper(count: u32) -> (Repair, FactorSet) {
        let mut set = FactorSet::new();
        (0..count).for_each(|number| assert!(set.insert(factor(0, 0, number))));
        (Repair::new(&config(2)), set)
    }

    fn held(count: u32) -> Option<Held> {
        Some(helper(count).1.held())
    }

    fn due(repair: &Repair, now: u32, set: &FactorSet) -> Vec<u32> {
        repair.due(Step(now), set).iter().map(|id| id.number).collect()
    }

    #[test]
    fn what_may_be_under_way_is_not_due() {
        let (mut repair, set) = helper(20);
        repair.hear(Step(20), AgentId(1), Incarnation(0), Step(20), held(17));
        assert_eq!(due(&repair, 20, &set), [17, 18]);
        repair.note(Step(20), [factor(0, 0, 17).id].into_iter());
        assert_eq!(due(&repair, 20, &set), [18]);
        repair.note_again(Step(20), [factor(0, 0, 18).id].into_iter());
        for then in 21..=26 {
            repair.hear(Step(then), AgentId(1), Incarnation(0), Step(then), held(17));
            let expected: &[u32] = match then {
                21 => &[19],
                22 | 23 => &[17, 19],
                _ => &[17, 18, 19],
            };
            assert_eq!(due(&repair, then, &set), expected, "at {then}");
        }
        repair.hear(Step(27), AgentId(1), Incarnation(0), Step(27), held(20));
        repair.hear(Step(27), AgentId(1), Incarnation(0), Step(26), held(0));
        assert_eq!(due(&repair, 27, &set), [], "the late message tells nothing");
        repair.hear(Step(28), AgentId(1), Incarnation(0), Step(28), held(0));
        assert_eq!(due(&repair, 1000, &set), [], "an agent that is gone needs nothing");
    }

    #[test]
    fn an_agent_is_not_missing_its_own_but_those_of_its_earlier_incarnations() {
        let (mut repair, set) = helper(5);
        repair.hear(Step(20), AgentId(0), Incarnation(0), Step(20), held(0));
        assert_eq!(due(&repair, 20, &set), []);
        repair.hear(Step(21), AgentId(0), Incarnation(1), Step(21), held(1));
        assert_eq!(due(&repair, 21, &set), [1, 2, 3, 4]);
        assert_eq!(repair.incarnation(AgentId(0)), Some(Incarnation(1)));
        repair.hear(Step(22), AgentId(0), Incarnation(0), Step(22), held(0));
        assert_eq!(due(&repair, 22, &set), [1, 2, 3, 4], "the earlier incarnation is over");
    }

    #[test]
    fn agents_that_were_heard_of_late_take_turns() {
        let (mut repair, set) = helper(20);
        let turns = |repair: &Repair| {
            let is_due = |now: &u32| {
                let mut repair = repair.clone();
                repair.hear(Step(*now), AgentId(3), Incarnation(0), Step(*now), held(0));
                !due(&repair, *now, &set).is_empty()
            };
            (24..36).filter(is_due).collect::<Vec<u32>>()
        };
        assert_eq!(turns(&repair), (24..36).collect::<Vec<u32>>(), "nobody else was heard");
        for other in [0, 1] {
            repair.hear(Step(36), AgentId(other), Incarnation(0), Step(20), held(20));
        }
        assert_eq!(turns(&repair), [28, 29, 34, 35], "after agents 0 and 1");
        repair.neighbours.get_mut(&AgentId(0)).unwrap().heard = Step(10);
        assert_eq!(turns(&repair), [26, 27, 30, 31, 34, 35], "agent 0 is gone");
    }
}
