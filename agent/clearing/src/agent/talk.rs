//! What an agent says, and when.

use super::ClearingAgent;
use super::cleaner::LINGER_S;
use super::duty::State;
use crate::exchange::message::{Beat, Formation, Mask, Message};

impl ClearingAgent {
    /// Says what is due at the present step. Agents take turns.
    pub(super) fn say(&mut self) {
        let clearing = &self.config.clearing;
        let is_due = |period_s: f64| {
            let turn = self.step.0.wrapping_add(u32::from(self.config.id.0));
            turn.is_multiple_of(self.config.steps(period_s))
        };
        let linger = self.config.steps(LINGER_S);
        let is_awaited =
            self.cleaner().is_some_and(|cleaner| cleaner.is_awaited(self.step, linger));
        let has_beat = is_due(clearing.beat_period_s);
        let has_mask = is_due(clearing.safe_period_s) || is_awaited && has_beat;
        let has_call = is_due(clearing.call_period_s);
        let stamp = self.stamp();
        if has_beat || has_mask {
            let message = self.near_message(has_mask);
            self.outbox.send(&self.config, self.config.hbsr, &stamp, &message);
        }
        if has_call {
            let message = Message { beat: self.beat(), formation: None, safe: None };
            self.outbox.send(&self.config, self.config.lblr, &stamp, &message);
        }
    }

    fn near_message(&self, has_mask: bool) -> Message {
        let beat = self.beat();
        let State::Cleaner(cleaner) = &self.state else {
            return Message { beat, formation: None, safe: None };
        };
        let formation = Formation {
            heading: cleaner.heading,
            wings: cleaner.roster.wings,
            tails: cleaner.roster.tails.clone(),
            parent: cleaner.parent,
            requests: cleaner.requests.clone(),
        };
        let safe = || Mask::new(&cleaner.masks.safe(&self.sight), self.config.clearing.coding);
        Message { beat, formation: Some(formation), safe: has_mask.then(safe) }
    }

    fn beat(&self) -> Beat {
        let (followers, has_frontier, is_waiting) = match &self.state {
            State::Cleaner(cleaner) => (
                u16::try_from(cleaner.roster.len()).unwrap_or(u16::MAX),
                !cleaner.masks.frontier().is_empty(),
                cleaner.waits_since.is_some(),
            ),
            _ => (0, false, false),
        };
        Beat {
            duty: self.state.duty(),
            leader: self.state.leader(),
            followers,
            has_frontier,
            is_waiting,
            has_lost: self.fleet.has_lost(),
        }
    }
}
