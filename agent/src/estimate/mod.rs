//! What one UAV knows (docs/concepts/predict-correct.md): predict, then correct with the own frame
//! and the received facts.
//!
//! | module | equations |
//! |---|---|
//! | [`state`] | what an agent knows |
//! | [`sets`] | the sets that carry the guarantee |
//! | [`evidence`] | what own and received frames prove about the current step |
//! | `fuse` | (4.34)-(4.37): the knowledge of other agents |
//! | [`predict`] | (4.24)-(4.27) |
//! | `correct` | (4.28)-(4.33): what frames disprove |
//! | [`oem`] | the occupancy-elevation map |
//! | `views` | hidden ground (5.43), (5.44) |
//! | [`origins`] | which agent claims what, where some may lie |
//! | `believe` | an update where some may lie |
//!
//! Every agent applies all evidence of a step at once and in the same order, so agents that received
//! the same facts have the same knowledge, to the last bit.

mod believe;
mod correct;
pub mod evidence;
mod fuse;
pub mod oem;
pub mod origins;
pub mod predict;
pub mod sets;
pub mod state;
mod views;

use std::sync::Arc;

use csat_proto::ids::{AgentId, TargetId};
use csat_proto::message::Known;
use csat_proto::time::Step;
use tracing::info_span;

use crate::config::AgentConfig;
use crate::region::Memo;
use crate::sense::Measured;
use believe::Verdict;
use evidence::{Ager, Evidence, ReceivedFact};
use predict::Predictor;
use sets::Sets;
use state::Knowledge;

/// Keeps [`Knowledge`] up to date.
#[derive(Debug, Clone)]
pub struct Estimator {
    own: AgentId,
    /// q: how many other agents may lie.
    liars: usize,
    ager: Ager,
    predictor: Predictor,
    memo: Arc<Memo>,
}

/// What an update changed besides the sets.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Changes {
    /// Targets that were identified for the first time.
    pub identified: Vec<TargetId>,
    /// Targets whose set became empty and was restarted: an assumption failed or a message was
    /// false.
    pub inconsistent: Vec<TargetId>,
    /// Agents that were proven to have said something false.
    pub liars: Vec<AgentId>,
}

impl Estimator {
    /// An estimator for the agent of `config`.
    pub fn new(config: &AgentConfig) -> Self {
        Self::with_memo(config, Arc::default())
    }

    /// One that looks up what others with the same `memo` computed.
    pub fn with_memo(config: &AgentConfig, memo: Arc<Memo>) -> Self {
        Self {
            own: config.id,
            liars: config.exchange.liars.into(),
            ager: Ager::new(config),
            predictor: Predictor::with_memo(config, Arc::clone(&memo)),
            memo,
        }
    }

    /// Takes the knowledge to the step of the own frame, if there is one, and applies that frame and
    /// the facts in `heard`. No fact in `heard` may be of a later step.
    pub fn update(
        &self,
        knowledge: &mut Knowledge,
        own: Option<(Step, &Measured)>,
        mut heard: Vec<ReceivedFact>,
    ) -> Changes {
        let before: Vec<TargetId> = knowledge.targets.keys().copied().collect();
        heard.sort_by_key(|h| (h.fact.step, h.src, h.incarnation, h.fact.number, h.is_answer));
        let (step, measured) = (own.map(|(step, _)| step), own.map(|(_, measured)| measured));
        let news = News { step, measured, heard: &heard };
        let Knowledge { sets, origins, .. } = knowledge;
        let Verdict { liars, inconsistent } = match origins {
            Some(origins) => self.apply_by_origin(sets, origins, &news),
            None => {
                self.apply(sets, &news);
                Verdict { liars: Vec::new(), inconsistent: sets.restart_empty_sets() }
            }
        };
        if let Some(step) = step {
            knowledge.forget_views_before(self.predictor.views_from(step));
        }
        look(knowledge, measured, &heard);
        let identified =
            knowledge.targets.keys().filter(|j| before.binary_search(j).is_err()).copied();
        Changes { identified: identified.collect(), inconsistent, liars }
    }

    /// Takes sets to the step of the news, and applies these.
    ///
    /// The knowledge of other agents is of earlier steps, so it is merged before the prediction.
    fn apply(&self, sets: &mut Sets, news: &News<'_>) {
        if let Some(step) = news.step {
            self.predictor.catch_up(sets, step);
        }
        info_span!("fuse").in_scope(|| fuse::fuse(sets, news.known(), &self.ager, &self.memo));
        let predicted = info_span!("estimate").in_scope(|| self.predictor.predict(sets, news.step));
        let evidence = info_span!("fuse").in_scope(|| self.evidence(sets, news));
        info_span!("estimate")
            .in_scope(|| correct::correct(sets, &predicted, &evidence, &self.memo));
    }

    /// All evidence about the step of the sets, oldest first and by sender.
    fn evidence(&self, sets: &Sets, news: &News<'_>) -> Vec<Evidence> {
        let now = sets.step;
        let margins: Vec<_> = news.known().map(|known| fuse::margin_news(sets, known)).collect();
        let fresh = news.measured.map(|measured| ((now, self.own), Evidence::fresh(measured)));
        let heard = news.heard.iter();
        let aged = heard.map(|h| ((h.fact.step, h.src), self.ager.evidence(&h.fact, now)));
        let mut evidence: Vec<_> = aged.chain(fresh).collect();
        evidence.sort_by_key(|(stamp, _)| *stamp);
        margins.into_iter().chain(evidence.into_iter().map(|(_, evidence)| evidence)).collect()
    }
}

/// What is new.
#[derive(Debug, Clone, Copy)]
struct News<'a> {
    /// The step of the own frame, if there is one.
    step: Option<Step>,
    /// What that frame proved; `None` where that does not count.
    measured: Option<&'a Measured>,
    /// The messages, in the order of their steps.
    heard: &'a [ReceivedFact],
}

impl<'a> News<'a> {
    /// The knowledge in the messages.
    fn known(&self) -> impl Iterator<Item = &'a Known> + use<'a> {
        self.heard.iter().filter_map(|h| h.known.as_deref())
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
