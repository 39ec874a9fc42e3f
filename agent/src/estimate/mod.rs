//! What one UAV knows (docs/concepts/predict-correct.md): predict, then correct with the own frame
//! and the received facts.
//!
//! | module | equations |
//! |---|---|
//! | [`state`] | the sets an agent holds |
//! | [`evidence`] | what own and received frames prove about the current step |
//! | `fuse` | (4.34)-(4.37): the knowledge of other agents |
//! | [`predict`] | (4.24)-(4.27) |
//! | `correct` | (4.28)-(4.33): what frames disprove |
//! | [`oem`] | the occupancy-elevation map |
//!
//! Every agent applies all evidence of a step at once and in the same order, so agents that received
//! the same facts have the same knowledge, to the last bit.

mod correct;
pub mod evidence;
mod fuse;
pub mod oem;
pub mod predict;
pub mod state;

use csat_proto::ids::{AgentId, TargetId};
use csat_proto::time::Step;
use tracing::info_span;

use crate::config::AgentConfig;
use crate::sense::Measured;
use evidence::{Ager, Evidence, ReceivedFact};
use predict::Predictor;
use state::Knowledge;

/// Keeps [`Knowledge`] up to date.
#[derive(Debug, Clone)]
pub struct Estimator {
    own: AgentId,
    ager: Ager,
    predictor: Predictor,
}

/// What an update changed besides the sets.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Changes {
    /// Targets that were identified for the first time.
    pub identified: Vec<TargetId>,
    /// Targets whose set became empty and was restarted: an assumption failed or a message was
    /// false.
    pub inconsistent: Vec<TargetId>,
}

impl Estimator {
    /// An estimator for the agent of `config`.
    pub fn new(config: &AgentConfig) -> Self {
        Self { own: config.id, ager: Ager::new(config), predictor: Predictor::new(config) }
    }

    /// Takes the knowledge to the step of the own frame, if there is one, and applies that frame and
    /// the facts in `heard`. No fact in `heard` may be of a later step.
    ///
    /// The knowledge of other agents is of earlier steps, so it is merged before the prediction.
    pub fn update(
        &self,
        knowledge: &mut Knowledge,
        own: Option<(Step, &Measured)>,
        mut heard: Vec<ReceivedFact>,
    ) -> Changes {
        let before: Vec<TargetId> = knowledge.targets.keys().copied().collect();
        heard.sort_by_key(|h| (h.fact.step, h.src, h.incarnation, h.fact.number, h.is_answer));
        if let Some((step, _)) = own {
            self.predictor.catch_up(knowledge, step);
        }
        info_span!("fuse").in_scope(|| {
            let known = heard.iter().filter_map(|h| h.known.as_deref());
            fuse::fuse(knowledge, known, &self.ager);
        });
        let predicted = info_span!("estimate").in_scope(|| match own {
            Some((step, _)) => self.predictor.predict(knowledge, step),
            None => self.predictor.still(knowledge),
        });
        let measured = own.map(|(_, measured)| measured);
        look(knowledge, measured, &heard);
        let evidence = info_span!("fuse").in_scope(|| self.evidence(knowledge, measured, &heard));
        info_span!("estimate").in_scope(|| correct::correct(knowledge, &predicted, &evidence));
        let inconsistent = knowledge.restart_empty_sets();
        let identified =
            knowledge.targets.keys().filter(|j| before.binary_search(j).is_err()).copied();
        Changes { identified: identified.collect(), inconsistent }
    }

    /// All evidence about the step of the knowledge, oldest first and by sender.
    fn evidence(
        &self,
        knowledge: &Knowledge,
        own: Option<&Measured>,
        heard: &[ReceivedFact],
    ) -> Vec<Evidence> {
        let now = knowledge.step;
        let known = heard.iter().filter_map(|h| h.known.as_deref());
        let margins: Vec<_> = known.map(|known| fuse::margin_news(knowledge, known)).collect();
        let fresh = own.map(|measured| ((now, self.own), Evidence::fresh(measured)));
        let aged = heard.iter().map(|h| ((h.fact.step, h.src), self.ager.evidence(&h.fact, now)));
        let mut evidence: Vec<_> = aged.chain(fresh).collect();
        evidence.sort_by_key(|(stamp, _)| *stamp);
        margins.into_iter().chain(evidence.into_iter().map(|(_, evidence)| evidence)).collect()
    }
}

/// Applies hidden ground and cells of the map. They carry no guarantee, and their order does not
/// matter.
fn look(knowledge: &mut Knowledge, own: Option<&Measured>, heard: &[ReceivedFact]) {
    let now = knowledge.step;
    if let Some(Measured { hidden, seen, oem, .. }) = own {
        knowledge.note_view(now, hidden, seen);
        oem.iter().for_each(|&delta| {
            knowledge.oem.join(delta);
        });
    }
    for fact in heard.iter().map(|h| h.fact.as_ref()) {
        knowledge.note_view(fact.step, &fact.hidden, &fact.seen);
        fact.oem.deltas().for_each(|delta| {
            knowledge.oem.join(delta);
        });
    }
}
