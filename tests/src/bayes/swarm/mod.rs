//! The swarm of the Bayesian search: from one seed a short mission, links with any mixture of faults, crashes,
//! restarts and missed frames; at every step all laws are checked. For the last third the links are perfect and no
//! frame is missed, and in the end all agents have to hold the same factors.
//!
//! | module | what it does |
//! |---|---|
//! | [`draw`] | from a seed to a scenario |
//! | `factors` | agents hold what was stated and what they were told, nothing else and nothing less |
//! | `laws` | the laws that hold at every step, and in the end |

pub mod draw;
mod factors;
mod laws;

use csat_flight::bayes::Bayes;
use csat_flight::scenario::missions::Offered;
use csat_mission::engine::Engine;
use csat_netem::config::NetemConfig;

use crate::faulty::Faulty;
use crate::missions::world_of;
use crate::replay::caught;
use draw::Draw;
use laws::Laws;

/// The mission of the swarm.
pub(crate) type Handicapped = Faulty<Bayes>;

/// A running mission of the swarm.
pub(crate) type Swarm = Engine<Handicapped>;

/// What seeds exercised, to check that the swarm tests enough.
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
    /// Messages of incarnations that were over.
    pub stale: u64,
    /// Messages that were too old.
    pub old: u64,
    /// Frames that agents missed.
    pub missed: u64,
    /// Messages of steps that their receivers had not come to.
    pub ahead: u64,
    /// Factors that arrived again.
    pub repeated: u64,
    /// Factors that their source did not send itself.
    pub relayed: u64,
    /// Factors with a sighting.
    pub sightings: u64,
    /// Values of beliefs compared with the product of factors.
    pub products: u64,
    /// Steps at which all agents had to hold the same.
    pub equal: u64,
    /// Steps at which all beliefs had to be equal bit for bit.
    pub identical: u64,
    /// Missions in which all had to hold the same in the end although links had been bad.
    pub converged: u64,
    /// Missions with a budget that was too small at some step.
    pub tight: u64,
    /// Missions with ground stations.
    pub stationed: u64,
    /// Missions with a target that moves.
    pub moving: u64,
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
            stale: self.stale + other.stale,
            old: self.old + other.old,
            missed: self.missed + other.missed,
            ahead: self.ahead + other.ahead,
            repeated: self.repeated + other.repeated,
            relayed: self.relayed + other.relayed,
            sightings: self.sightings + other.sightings,
            products: self.products + other.products,
            equal: self.equal + other.equal,
            identical: self.identical + other.identical,
            converged: self.converged + other.converged,
            tight: self.tight + other.tight,
            stationed: self.stationed + other.stationed,
            moving: self.moving + other.moving,
        }
    }
}

/// Flies the mission of a seed.
///
/// # Errors
/// The first law that did not hold, with the step and the values; a panic of an agent is an error as well.
pub fn fly(seed: u64) -> Result<Exercise, String> {
    let draw = Draw::new(seed);
    caught(|| fly_drawn(&draw))
}

fn fly_drawn(draw: &Draw) -> Result<Exercise, String> {
    let Draw { scenario, heal_at, .. } = draw;
    let world = world_of(scenario).map_err(|e| format!("no world: {e}"))?;
    let mission =
        Handicapped::new(Bayes::of(scenario), scenario.run.period_s, draw.handicaps.clone());
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    let mut laws = Laws::new(draw);
    for step in 0..=scenario.steps() {
        if step == *heal_at {
            engine.reconfigure_links(&NetemConfig::default());
            laws.heal();
        }
        let trace = engine.step();
        laws.check(&engine, &trace).map_err(|law| format!("step {}: {law}", trace.step))?;
    }
    laws.finish(&engine)
}
