//! The first split, encounter and merge of a mission (figure 9). The mission is flown again: what is drawn of them is
//! in no file of a run.

use csat_mission::engine::Engine;
use csat_proto::ids::AgentId;

use crate::clearing::Clearing;
use crate::clearing::report::{Counters, Report};
use crate::scenario::Loaded;

/// When something happened for the first time.
pub struct Phase {
    /// What: `split`, `encounter` or `merge`.
    pub name: &'static str,
    /// What that is, in words: what follows `UAV 3`.
    pub meaning: &'static str,
    /// To whom.
    pub agent: AgentId,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// What each UAV knew then, in full.
    pub reports: Vec<Report>,
}

/// What may happen, its meaning, and how often it happened to an agent.
type Kind = (&'static str, &'static str, fn(&Counters) -> u32);

const KINDS: [Kind; 3] = [
    ("split", "took over a sub-frontier and became a cleaner", |counters| counters.splits),
    ("encounter", "dropped frontier, as another one had cleared the road beyond", |counters| {
        counters.encounters
    }),
    ("merge", "joined a formation as a helper", |counters| counters.merges),
];

/// Flies a mission until a split, a merge and an encounter have happened, or to its end. The phases are in the order
/// of time.
pub fn fly(mission: Clearing, loaded: Loaded) -> Vec<Phase> {
    let Loaded { scenario, world, .. } = loaded;
    let uavs = usize::from(scenario.agents.count);
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    let mut phases: Vec<Phase> = Vec::new();
    for step in 0..=scenario.steps() {
        if phases.len() == KINDS.len() {
            break;
        }
        let trace = engine.step();
        let reports: Vec<&Report> =
            trace.flown.iter().take(uavs).filter_map(|flown| flown.report.as_ref()).collect();
        for (name, meaning, count) in KINDS {
            let Some(report) = reports.iter().find(|report| count(&report.counters) > 0) else {
                continue;
            };
            if phases.iter().any(|phase| phase.name == name) {
                continue;
            }
            let reports = engine.show().into_iter().take(uavs).flatten().collect();
            let time_s = f64::from(step) * scenario.run.period_s;
            phases.push(Phase { name, meaning, agent: report.agent, time_s, reports });
        }
    }
    phases
}
