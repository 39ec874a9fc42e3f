//! An update in a fleet in which some agents may lie (docs/liars.md).

use std::collections::BTreeSet;

use csat_proto::ids::{AgentId, TargetId};
use tracing::info_span;

use super::evidence::ReceivedFact;
use super::origins::{Claims, Combined, Origin, Origins};
use super::predict::Predicted;
use super::sets::Sets;
use super::{Estimator, News};

/// What an update showed besides the sets.
#[derive(Debug, Clone, Default)]
pub(super) struct Verdict {
    /// The agents that it proved to have said something false.
    pub(super) liars: Vec<AgentId>,
    /// Targets of which too many claims are false.
    pub(super) inconsistent: Vec<TargetId>,
}

impl Estimator {
    /// Takes `sets`, which hold, to the step of the news, and applies these: each claim to the sets of
    /// its origin, and to `sets` what holds if no more than q agents lie.
    pub(super) fn apply_by_origin(
        &self,
        sets: &mut Sets,
        origins: &mut Origins,
        news: &News<'_>,
    ) -> Verdict {
        self.hear(&sets.without_evidence(), origins, news);
        let predicted = self.predictor.predict(sets, news.step);
        let (combined, liars) =
            info_span!("fuse").in_scope(|| self.without_liars(origins, &predicted));
        sets.targets = combined.targets;
        sets.unexplored = combined.unexplored;
        if let Some(own) = &origins.own {
            sets.margin.clone_from(&own.margin);
        }
        Verdict { liars, inconsistent: restart_empty_sets(sets, origins) }
    }

    /// Applies the own frame to the own sets, and each message to the claims of its sender. Claims of
    /// agents that said nothing before are those of `blank`.
    fn hear(&self, blank: &Sets, origins: &mut Origins, news: &News<'_>) {
        let own_claim = match &mut origins.own {
            Some(own) => {
                self.apply(own, &News { heard: &[], ..*news });
                None
            }
            // The own frames may be mistaken.
            None => news.measured.map(|_| Origin::own(self.own)),
        };
        for origin in news.heard.iter().map(Origin::of).chain(own_claim) {
            if origins.counts(origin.agent) {
                let claims = || Claims { sets: blank.clone(), seen: BTreeSet::new() };
                origins.claims.entry(origin).or_insert_with(claims);
            }
        }
        for (origin, claims) in &mut origins.claims {
            let said = news.heard.iter().filter(|h| Origin::of(h) == *origin);
            let said: Vec<ReceivedFact> = said.cloned().collect();
            let measured = news.measured.filter(|_| own_claim == Some(*origin));
            claims.note(measured, &said);
            self.apply(&mut claims.sets, &News { step: news.step, measured, heard: &said });
        }
    }

    /// The combined sets, and the agents that were proven to lie on the way: without their claims the
    /// sets are smaller and may prove more.
    fn without_liars(
        &self,
        origins: &mut Origins,
        predicted: &Predicted,
    ) -> (Combined, Vec<AgentId>) {
        let mut liars = Vec::new();
        loop {
            let left = origins.liars_left(self.liars);
            let real = origins.real(left);
            // What the own frames show is no matter of numbers.
            let by_own = match &origins.own {
                Some(own) => origins.refuted(&real, |j| own.set_of(j)),
                None => BTreeSet::new(),
            };
            let refuted = if by_own.is_empty() {
                let combined = origins.combined(predicted, left);
                let refuted = origins.refuted(&real, |j| combined.set_of(j));
                // More than may lie: it is not known which of them are wrong.
                if refuted.is_empty() || refuted.len() > left {
                    return (combined, liars);
                }
                refuted
            } else {
                by_own
            };
            origins.name(&refuted);
            liars.extend(refuted);
        }
    }
}

/// Restarts the sets that became empty, and returns their targets: more claims are false than there
/// may be, or an assumption failed.
fn restart_empty_sets(sets: &mut Sets, origins: &mut Origins) -> Vec<TargetId> {
    let empty = sets.empty();
    for &j in &empty {
        origins.restart(j);
        let own = origins.own.as_ref().map(|own| own.set_of(j).clone());
        let anywhere = sets.anywhere();
        sets.targets.insert(j, own.unwrap_or(anywhere));
    }
    empty
}
