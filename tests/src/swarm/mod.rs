//! The soundness swarm: from one seed a small world, a fleet, links with any mixture of faults,
//! crashes and restarts; at every step all laws are checked. Then the links within a core of the
//! fleet become perfect, all others stay broken, and the core has to agree within a bound.
//!
//! | module | what it does |
//! |---|---|
//! | [`draw`] | from a seed to a scenario |
//! | `laws` | the laws that hold at every step |
//! | `claims` | agents claim to hold only facts that they received |
//! | `merge` | the laws of merging, on the knowledge and messages of the mission |
//! | `converge` | the agreement of the core in the end |

mod claims;
mod converge;
pub mod draw;
mod laws;
mod merge;

use csat_experiments::set_membership::SetMembership;
use csat_mission::engine::Engine;

use crate::faulty::Faulty;
use crate::missions::world_of;
use crate::replay::caught;
use converge::Settling;
use draw::Draw;
use laws::Laws;

/// Steps in which messages in flight may arrive after the core was healed.
const DRAIN_STEPS: u32 = 40;

/// The mission of the swarm.
pub(crate) type Handicapped = Faulty<SetMembership>;

/// A running mission of the swarm.
pub(crate) type Swarm = Engine<Handicapped>;

/// What a seed exercised, to check that the swarm tests enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exercise {
    /// Missions flown.
    pub missions: u64,
    /// Messages delivered.
    pub delivered: u64,
    /// Messages lost.
    pub dropped: u64,
    /// Messages damaged on the way.
    pub corrupted: u64,
    /// Copies that links made.
    pub duplicated: u64,
    /// Messages that arrived later than the step they were sent in.
    pub late: u64,
    /// Incarnations that ended.
    pub crashes: u64,
    /// Targets identified, summed over agents.
    pub identified: u64,
    /// Messages of incarnations that were over.
    pub stale: u64,
    /// Pairs of messages merged in both orders.
    pub merged: u64,
    /// Cores that had to agree, and did.
    pub converged: u64,
    /// Those of them that sent snapshots, so that their sets had to agree as well.
    pub precise: u64,
    /// Frames that agents missed.
    pub missed: u64,
    /// Missions in which clocks differed.
    pub skewed: u64,
    /// Missions in which the cars evaded.
    pub evasive: u64,
    /// Missions with ground stations.
    pub stationed: u64,
    /// Missions with poses that are known to boxes.
    pub uncertain: u64,
    /// Missions among buildings higher than the flights.
    pub walled: u64,
    /// Missions in which agents lied.
    pub lying: u64,
    /// Messages in which agents passed on plans.
    pub relayed: u64,
    /// How often an agent named a liar.
    pub named: u64,
}

impl Exercise {
    /// What two seeds exercised together.
    pub fn with(self, other: Self) -> Self {
        Self {
            missions: self.missions + other.missions,
            delivered: self.delivered + other.delivered,
            dropped: self.dropped + other.dropped,
            corrupted: self.corrupted + other.corrupted,
            duplicated: self.duplicated + other.duplicated,
            late: self.late + other.late,
            crashes: self.crashes + other.crashes,
            identified: self.identified + other.identified,
            stale: self.stale + other.stale,
            merged: self.merged + other.merged,
            converged: self.converged + other.converged,
            precise: self.precise + other.precise,
            missed: self.missed + other.missed,
            skewed: self.skewed + other.skewed,
            evasive: self.evasive + other.evasive,
            stationed: self.stationed + other.stationed,
            uncertain: self.uncertain + other.uncertain,
            walled: self.walled + other.walled,
            lying: self.lying + other.lying,
            relayed: self.relayed + other.relayed,
            named: self.named + other.named,
        }
    }
}

/// Flies the mission of a seed.
///
/// # Errors
/// The first law that did not hold, with the step and the values; a panic of an agent is an error as
/// well.
pub fn fly(seed: u64) -> Result<Exercise, String> {
    let draw = Draw::new(seed);
    caught(|| fly_drawn(&draw))
}

/// The same with exact poses and without liars.
///
/// # Errors
/// As [`fly`].
pub fn fly_plain(seed: u64) -> Result<Exercise, String> {
    let draw = Draw::plain(seed);
    caught(|| fly_drawn(&draw))
}

fn fly_drawn(draw: &Draw) -> Result<Exercise, String> {
    let world = world_of(&draw.scenario).map_err(|e| format!("no world: {e}"))?;
    let mut engine = Engine::new(draw.mission(), world, &draw.scenario.netem, draw.scenario.seed);
    let mut laws = Laws::new(draw);
    let mut fly = |engine: &mut Swarm| {
        let trace = engine.step();
        laws.check(engine, &trace).map_err(|law| format!("step {}: {law}", trace.step))?;
        Ok::<_, String>(trace)
    };
    for _ in 0..draw.steps {
        fly(&mut engine)?;
    }
    engine.reconfigure_links(&draw.healed);
    // Earlier messages may still arrive and be new to an agent of the core.
    let mut drained = 0..DRAIN_STEPS;
    while engine.counters().in_flight > 0 && drained.next().is_some() {
        fly(&mut engine)?;
    }
    let is_quiet = engine.counters().in_flight == 0;
    let must_converge = draw.must_converge() && is_quiet;
    let mut settling = Settling::new(draw);
    for _ in 0..draw.settle_steps {
        let trace = fly(&mut engine)?;
        if must_converge {
            settling.watch(&engine, &trace);
        }
    }
    let mut exercise = draw.exercise().with(laws.exercise(&engine));
    if must_converge {
        exercise.precise = settling.check(&engine)?.into();
        exercise.converged = 1;
    }
    Ok(exercise)
}
