//! The swarm of road clearing: a short mission in a small network, with any mixture of noise and faults of links. The
//! judge checks every step; here is what it has to have found.

use csat_flight::clearing::Clearing;
use csat_flight::scenario::missions::Offered;
use csat_mission::engine::Engine;
use csat_mission::judge::Judge;

use super::draw::Draw;
use crate::missions::world_of;
use crate::replay::caught;

/// What seeds exercised, to check that the swarm tests enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exercise {
    /// Missions flown.
    pub missions: u64,
    /// Missions that cleared their network.
    pub cleared: u64,
    /// Sub-frontiers that wings took over.
    pub splits: u64,
    /// Times that a frontier shrank because another cleaner had cleared the road beyond.
    pub encounters: u64,
    /// Helpers that joined a formation.
    pub merges: u64,
    /// Missions in which a cleaner said that it could not move on.
    pub stalled: u64,
    /// Missions in which a loss was told.
    pub lost: u64,
    /// Losses of a frontier that had to be told, and were.
    pub told: u64,
    /// Messages lost.
    pub dropped: u64,
    /// Messages that agents did not believe.
    pub rejected: u64,
    /// Cells that were held against the contamination, over all steps.
    pub checks: u64,
}

impl Exercise {
    /// What two seeds exercised together.
    pub fn with(self, other: Self) -> Self {
        Self {
            missions: self.missions + other.missions,
            cleared: self.cleared + other.cleared,
            splits: self.splits + other.splits,
            encounters: self.encounters + other.encounters,
            merges: self.merges + other.merges,
            stalled: self.stalled + other.stalled,
            lost: self.lost + other.lost,
            told: self.told + other.told,
            dropped: self.dropped + other.dropped,
            rejected: self.rejected + other.rejected,
            checks: self.checks + other.checks,
        }
    }
}

/// Flies the mission of a seed.
///
/// # Errors
/// The first promise that was broken, with the step; a panic of an agent is an error as well.
pub fn fly(seed: u64) -> Result<Exercise, String> {
    let draw = Draw::new(seed);
    caught(|| fly_drawn(&draw))
}

fn fly_drawn(Draw { scenario, .. }: &Draw) -> Result<Exercise, String> {
    let world = world_of(scenario).map_err(|e| format!("no world: {e}"))?;
    let mission = Clearing::of(scenario);
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    let mut exercise = Exercise { missions: 1, ..Exercise::default() };
    let (mut is_stalled, mut is_lost) = (false, false);
    for _ in 0..=scenario.steps() {
        let trace = engine.step();
        if let Some(violation) = trace.violations.first() {
            return Err(format!("step {}: {violation:?}", trace.step));
        }
        let reports = trace.flown.iter().filter_map(|flown| flown.report.as_ref());
        for report in reports {
            is_stalled |= report.is_stalled;
            is_lost |= report.is_lost;
        }
    }
    let of_fleet = engine.judge().fleet();
    let is_cleared = of_fleet.contains(&("is_cleared", Some(1.0)));
    let checked = engine.checked();
    let checks = |promise: &str| checked.of(promise).checks;
    for report in engine.show().into_iter().flatten() {
        exercise.splits += u64::from(report.counters.splits);
        exercise.encounters += u64::from(report.counters.encounters);
        exercise.merges += u64::from(report.counters.merges);
    }
    Ok(Exercise {
        cleared: is_cleared.into(),
        stalled: is_stalled.into(),
        lost: is_lost.into(),
        told: checks("told"),
        dropped: engine.counters().dropped.values().sum(),
        rejected: engine.tally().rejected.values().sum(),
        checks: checks("cleared"),
        ..exercise
    })
}
