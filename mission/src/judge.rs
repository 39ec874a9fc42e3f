//! What a mission promises, and who checks it: a judge that sees the truth and what agents report.

use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use csat_proto::time::Step;
use csat_world::target::TargetTruth;
use csat_world::truth::Violation as WorldViolation;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::measures::Values;
use crate::picture::properties;

/// A promise that a mission makes of each report.
#[derive(Debug, Clone, Copy)]
pub struct Promise {
    /// Its key below `checked` of the summary, in snake case.
    pub key: &'static str,
    /// What happens when it is broken, in words: `a target outside the set of an agent`.
    pub broken: &'static str,
}

/// What a judge found in one report.
#[derive(Debug, Clone, Default)]
pub struct Judged {
    /// How many checks it made, by promise.
    pub checks: Vec<(&'static str, u64)>,
    /// The checks that found a promise broken.
    pub faults: Vec<Broken>,
}

/// A promise that did not hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Broken {
    /// The key of the [`Promise`].
    pub promise: &'static str,
    /// Whose report broke it.
    pub agent: AgentId,
    /// What else there is to say, as members of a JSON object.
    pub detail: Map<String, Value>,
}

impl Broken {
    /// A promise that `agent` broke, with the members of the JSON object `detail`.
    pub fn new(promise: &'static str, agent: AgentId, detail: Value) -> Self {
        Self { promise, agent, detail: properties(detail) }
    }
}

impl Serialize for Broken {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("kind", &self.promise.replace('_', "-"))?;
        map.serialize_entry("agent", &self.agent)?;
        self.detail.iter().try_for_each(|(key, value)| map.serialize_entry(key, value))?;
        map.end()
    }
}

/// What is true at a step.
#[derive(Debug, Clone, Copy)]
pub struct Truth<'a> {
    /// k.
    pub step: Step,
    /// Every target, by index.
    pub targets: &'a [TargetTruth],
    /// Where every agent is, by index: the UAVs, then the ground stations.
    pub poses: &'a [Pose],
    /// Whether what each agent has seen so far was false, by index: it lied, or took a target for
    /// another one.
    pub is_false: &'a [bool],
}

impl Truth<'_> {
    /// Whether what an agent has seen so far was false.
    pub fn is_false(&self, agent: AgentId) -> bool {
        self.is_false.get(usize::from(agent.0)).copied().unwrap_or_default()
    }
}

/// Judges one run. It may keep state from report to report.
pub trait Judge<R>: Send + Sync {
    /// Holds what an agent reported against the truth at the step of its report.
    fn judge(&mut self, agent: AgentId, report: &R, truth: &Truth<'_>) -> Judged;

    /// The world's step is over: what there was of reports has been judged. `is_alive` says by index which agents
    /// run. For promises of all agents together.
    fn close(&mut self, _: &Truth<'_>, _is_alive: &[bool]) -> Judged {
        Judged::default()
    }

    /// The values of columns of the fleet that only a judge knows, after the last [`Self::close`].
    fn fleet(&self) -> Values {
        Values::new()
    }

    /// The same of one agent.
    fn agent(&self, _: AgentId) -> Values {
        Values::new()
    }
}

/// Something that must never happen did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violation {
    /// k.
    pub step: Step,
    /// What happened.
    pub fault: Fault,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Fault {
    /// In the world, or in the links.
    World(csat_world::truth::Fault),
    /// A promise of the mission was broken.
    Mission(Broken),
}

impl From<WorldViolation> for Violation {
    fn from(WorldViolation { step, fault }: WorldViolation) -> Self {
        Self { step, fault: Fault::World(fault) }
    }
}
