//! UAVs that lie: their cameras show cars as they are not.
//!
//! A liar's agent is like any other. Its frames are those of a false scene, so that all it measures,
//! knows and says is well-formed and fits together. Buildings stay where they are.

use csat_proto::ids::AgentId;
use serde::{Deserialize, Serialize};

use crate::target::TargetTruth;

/// One of `[[faults.liar]]`: a UAV that lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Liar {
    /// Index of the UAV.
    pub agent: u16,
    /// From this time, seconds.
    #[serde(default)]
    pub from_s: f64,
    /// How.
    pub kind: LieKind,
}

/// What a liar's camera shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LieKind {
    /// No cars: bare ground where they are.
    Clear,
    /// No cars where they are, and phantoms: every car stands still where the next one, by index, was
    /// when the lie began.
    Phantom,
    /// Every car has the index of the one before it.
    Misidentify,
}

/// A liar, and what its phantoms are.
#[derive(Debug, Clone)]
pub(crate) struct Lie {
    liar: Liar,
    /// Where the cars were when the lie began; empty before that.
    at_start: Vec<TargetTruth>,
}

impl Lie {
    /// The lie of a UAV before the mission.
    pub(crate) fn new(liar: Liar) -> Self {
        Self { liar, at_start: Vec::new() }
    }

    /// Who lies.
    pub(crate) fn agent(&self) -> AgentId {
        AgentId(self.liar.agent)
    }

    /// The time is `now_s`, seconds, and the cars are where they are.
    pub(crate) fn advance(&mut self, now_s: f64, targets: &[TargetTruth]) {
        if self.has_begun(now_s) && self.at_start.is_empty() {
            self.at_start = targets.to_vec();
        }
    }

    /// Whether the UAV lies at a time, seconds.
    pub(crate) fn has_begun(&self, now_s: f64) -> bool {
        now_s >= self.liar.from_s
    }

    /// The cars as the liar's camera shows them.
    pub(crate) fn shown(&self, targets: &[TargetTruth]) -> Vec<TargetTruth> {
        match self.liar.kind {
            LieKind::Clear => Vec::new(),
            LieKind::Phantom => renamed(&self.at_start),
            LieKind::Misidentify => renamed(targets),
        }
    }
}

/// Cars by index, each where the next one is, and the last one where the first is.
fn renamed(targets: &[TargetTruth]) -> Vec<TargetTruth> {
    let next = targets.iter().cycle().skip(1);
    targets.iter().zip(next).map(|(target, next)| TargetTruth { id: target.id, ..*next }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::ids::TargetId;

    fn at(id: u16, x: f64) -> TargetTruth {
        TargetTruth { id: TargetId(id), location: [x, 0.0], heading_rad: 0.0, speed_m_s: 0.5 }
    }

    fn shown(kind: LieKind, targets: &[TargetTruth]) -> Vec<(u16, f64)> {
        let mut lie = Lie::new(Liar { agent: 1, from_s: 3.0, kind });
        lie.advance(2.5, &[at(0, 1.0), at(1, 2.0), at(2, 3.0)]);
        assert!(!lie.has_begun(2.5) && lie.has_begun(3.0));
        lie.advance(3.0, &[at(0, 10.0), at(1, 20.0), at(2, 30.0)]);
        lie.advance(3.5, targets);
        lie.shown(targets).iter().map(|target| (target.id.0, target.location[0])).collect()
    }

    #[test]
    fn each_kind_shows_another_false_world() {
        let now = [at(0, 11.0), at(1, 21.0), at(2, 31.0)];
        assert_eq!(shown(LieKind::Clear, &now), []);
        assert_eq!(shown(LieKind::Phantom, &now), [(0, 20.0), (1, 30.0), (2, 10.0)]);
        assert_eq!(shown(LieKind::Misidentify, &now), [(0, 21.0), (1, 31.0), (2, 11.0)]);
        assert_eq!(shown(LieKind::Misidentify, &[]), [], "no cars");
    }
}
