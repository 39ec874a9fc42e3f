//! `str5`: ground that another UAV sees counts from when this UAV hears of it.
//!
//! Under `str4` ground that another UAV plans to see counts as seen at once. With a radio of limited range it stays
//! unexplored to this UAV until the two are in contact. So `str5` predicts of each other UAV, by its last plan, where it
//! is and the X^Δ that it would have itself. A candidate that is in contact with it at the end of a block goes on with
//! the intersection of both X^Δ. Contact is worth the ground of which it tells, and a UAV flies out of reach where it sees
//! more than it would hear.
//!
//! Messages are passed on. So the members of a connected component of the others, a group, know the same, and who is in
//! contact with one of them hears of what all have seen. What this UAV tells a group is left out, because a group tells it
//! nothing that it knows already.

use std::collections::BTreeMap;

use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use csat_proto::raster::Raster;

use super::PlannerInput;
use super::rollout::ViewOverlap;
use super::schedule::RECENT_DECISIONS;
use crate::config::{AgentConfig, Schedule};

/// What other UAVs would tell, and whom.
#[derive(Debug, Clone)]
pub(super) struct Connectivity {
    id: AgentId,
    /// Up to this distance UAVs are in contact, metres.
    range_m: f64,
    /// Nobody waits for plans of the same decision.
    is_asynchronous: bool,
    overlap: ViewOverlap,
    /// The other UAVs as the last decision predicted them for the next one.
    expected: BTreeMap<AgentId, Expected>,
    /// Per block, the groups of the others.
    groups: Vec<Vec<Group>>,
}

/// Another UAV at the end of the first block of a decision.
#[derive(Debug, Clone)]
struct Expected {
    /// `world`, metres.
    position: [f64; 3],
    /// Its X^Δ.
    unexplored: Raster,
}

/// Another UAV as it is predicted.
struct Other {
    id: AgentId,
    /// Its poses at the ends of the blocks, as far as its plan reaches: at least one.
    poses: Vec<Pose>,
    /// Its X^Δ.
    unexplored: Raster,
}

/// UAVs that pass on each other's messages at the end of a block.
#[derive(Debug, Clone)]
struct Group {
    /// `world`, metres.
    positions: Vec<[f64; 3]>,
    /// The X^Δ of each of them, once they have told each other.
    unexplored: Raster,
}

impl Other {
    /// What to expect of it at the next decision, after the first block.
    fn expected(&self) -> (AgentId, Expected) {
        let position = self.poses[0].p_world;
        (self.id, Expected { position, unexplored: self.unexplored.clone() })
    }
}

impl Connectivity {
    /// The contact that `str5` predicts; `None` where contact does not matter ([`AgentConfig::predicts_contact`]).
    pub(super) fn new(config: &AgentConfig) -> Option<Self> {
        config.predicts_contact().then(|| Self {
            id: config.id,
            range_m: config.radio_range_m,
            is_asynchronous: config.guidance.schedule == Schedule::Asynchronous,
            overlap: ViewOverlap::new(config),
            expected: BTreeMap::new(),
            groups: Vec::new(),
        })
    }

    /// Begins a decision at the pose `own` with X^Δ in `wanted`, given the poses of the other UAVs at the ends of all
    /// blocks. `pass_block` advances an X^Δ by the block of this number, at whose end its UAV sees from this pose.
    pub(super) fn load(
        &mut self,
        input: &PlannerInput<'_>,
        own: &Pose,
        plans: &[Vec<Pose>],
        wanted: &Raster,
        mut pass_block: impl FnMut(usize, Option<&Pose>, &mut Raster),
    ) {
        let blocks = plans.iter().map(Vec::len).max().unwrap_or(0);
        let mut others = self.others(input, own, plans, wanted);
        self.expected.clear();
        self.groups = (0..blocks)
            .map(|block| {
                for other in &mut others {
                    pass_block(block, other.poses.get(block), &mut other.unexplored);
                }
                let groups = self.meet(&mut others, block);
                if block == 0 {
                    self.expected = others.iter().map(Other::expected).collect();
                }
                groups
            })
            .collect();
    }

    /// The other UAVs that may matter, now.
    fn others(
        &self,
        input: &PlannerInput<'_>,
        own: &Pose,
        plans: &[Vec<Pose>],
        wanted: &Raster,
    ) -> Vec<Other> {
        debug_assert_eq!([input.neighbours.len(), input.plan_ages.len()], [plans.len(); 2]);
        let mut others = Vec::new();
        // A plan that is not recent counts for as long as its UAV should be out of reach by it.
        for ((plan, &id), &age) in plans.iter().zip(input.neighbours).zip(input.plan_ages) {
            let left = plan.len().saturating_sub(age as usize);
            let poses = plan[..left].to_vec();
            let expected = self.expected.get(&id);
            let is_out_of_reach =
                |other: &Expected| !self.is_in_range(&[other.position], own.p_world);
            if !poses.iter().any(|pose| self.overlap.may_see_the_same(own, pose))
                || age > RECENT_DECISIONS && !expected.is_some_and(is_out_of_reach)
            {
                continue;
            }
            // In contact now, it knows what this UAV knows. A UAV that is not waited for has only told its last plan yet.
            let is_in_contact = age <= u32::from(id > self.id || self.is_asynchronous);
            let expected = expected.filter(|_| !is_in_contact);
            let unexplored = expected.map_or(wanted, |other| &other.unexplored).clone();
            others.push(Other { id, poses, unexplored });
        }
        others
    }

    /// The groups at the end of a block, whose members have told each other what they know.
    fn meet(&self, others: &mut [Other], block: usize) -> Vec<Group> {
        let mut groups: Vec<(Vec<usize>, Group)> = Vec::new();
        for (index, other) in others.iter().enumerate() {
            let Some(position) = other.poses.get(block).map(|pose| pose.p_world) else { continue };
            let is_near = |group: &Group| self.is_in_range(&group.positions, position);
            let (near, apart): (Vec<_>, Vec<_>) =
                groups.into_iter().partition(|(_, group)| is_near(group));
            let mut joined =
                Group { positions: vec![position], unexplored: other.unexplored.clone() };
            let mut members = vec![index];
            for (indices, group) in near {
                members.extend(indices);
                joined.positions.extend(group.positions);
                joined.unexplored.intersect_with(&group.unexplored);
            }
            groups = apart;
            groups.push((members, joined));
        }
        for (members, group) in &groups {
            members.iter().for_each(|&i| others[i].unexplored.clone_from(&group.unexplored));
        }
        groups.into_iter().map(|(_, group)| group).collect()
    }

    /// Ends a decision.
    pub(super) fn unload(&mut self) {
        self.groups.clear();
    }

    /// The groups that a UAV at this position at the end of a block hears, by their place among the groups of the block.
    pub(super) fn heard(&self, block: usize, position: [f64; 3]) -> Vec<usize> {
        let is_heard = |group: &Group| self.is_in_range(&group.positions, position);
        let groups = self.groups.get(block).into_iter().flatten().enumerate();
        groups.filter(|(_, group)| is_heard(group)).map(|(index, _)| index).collect()
    }

    /// Whether a position is within range of one of a group.
    fn is_in_range(&self, group: &[[f64; 3]], [x, y, z]: [f64; 3]) -> bool {
        let square =
            |at: &[f64; 3]| (at[0] - x).powi(2) + (at[1] - y).powi(2) + (at[2] - z).powi(2);
        group.iter().any(|at| square(at).sqrt() <= self.range_m)
    }

    /// Takes from X^Δ at the end of a block what these groups have seen.
    pub(super) fn tell(&self, block: usize, heard: &[usize], unexplored: &mut Raster) {
        for &index in heard {
            unexplored.intersect_with(&self.groups[block][index].unexplored);
        }
    }
}

#[cfg(test)]
#[path = "connectivity_tests.rs"]
mod tests;
