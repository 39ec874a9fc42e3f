//! The process of the world: town, cars and cameras, and the observers of the agents.

use std::sync::atomic::Ordering;
use std::time::Duration;

use csat_proto::control::{PROTOCOL, Pace, Welcome};
use csat_proto::ids::RunId;
use csat_proto::keys::Keys;
use zenoh::{Session, Wait};

use crate::flight::{self, Audience, FlightError, RunOptions};
use crate::missions::Offered;
use crate::record::{Outcome, RecordError, Recorder};
use crate::scenario::Loaded;
use crate::truth::TruthPublisher;
use csat_mission::timing::Stopwatch;
use csat_peer::arguments::PaceArguments;
use csat_peer::process_number;
use csat_peer::wire::session::WireArguments;
use csat_peer::world::{FleetError, RemoteFleet};

/// How the process of the world takes part.
#[derive(Debug, Clone, Copy)]
pub struct WorldOptions<'a> {
    /// How time passes and how long to wait.
    pub pace: &'a PaceArguments,
    /// Where to listen and connect.
    pub wire: &'a WireArguments,
    /// Whether agents' processes that end are started again.
    pub restarts: bool,
}

/// How long the process looks for another world of the same run.
const LOOK: Duration = Duration::from_secs(2);
/// How long that one may take to answer.
const ANSWER_LIMIT: Duration = Duration::from_millis(300);

/// Why a world's process ended before its mission.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// Zenoh did not do something.
    #[error("Zenoh cannot {action}")]
    Zenoh {
        /// What it was to do.
        action: &'static str,
        /// Its answer.
        source: zenoh::Error,
    },
    /// Another world flies the same run.
    #[error(
        "run {run} has a world already at these endpoints; expected another --seed, or that one to end"
    )]
    Twice {
        /// The run.
        run: RunId,
    },
    /// The agents' processes are missing.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// The flight failed.
    #[error(transparent)]
    Flight(#[from] FlightError<FleetError>),
    /// Writing it down.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Makes the error of what Zenoh was to do from its answer.
fn cannot(action: &'static str) -> impl Fn(zenoh::Error) -> WorldError {
    move |source| WorldError::Zenoh { action, source }
}

/// Waits for the agents' processes, flies the mission with them and records it.
///
/// # Errors
/// When processes are missing, or the mission cannot be flown or written down.
pub fn fly<M: Offered>(
    session: &Session,
    world: WorldOptions<'_>,
    loaded: Loaded,
    options: &RunOptions,
    recorder: &mut Recorder,
    audience: &mut dyn Audience<M>,
) -> Result<Outcome, WorldError> {
    let WorldOptions { pace, wire, restarts } = world;
    let keys = Keys(RunId(loaded.scenario.seed));
    // A world that connects nowhere meets another one only through processes that join it.
    if !wire.connect.is_empty() {
        refuse_twice(session, keys)?;
    }
    let count = usize::from(loaded.scenario.agent_count());
    let welcome = Welcome {
        protocol: PROTOCOL,
        run: keys.0,
        world: process_number(),
        name: loaded.name.clone(),
        scenario: loaded.scenario.to_toml(),
        map: loaded.map.as_ref().map(|map| map.text.clone()),
        pace: pace.realtime.map_or(Pace::Lockstep, Pace::Realtime),
    };
    let mission = M::of(&loaded.scenario);
    let mut fleet = RemoteFleet::declare(
        session,
        &mission,
        welcome,
        count,
        pace.patience,
        options.interrupted.clone(),
    )
    .map_err(cannot("declare the world's keys"))?;
    if restarts {
        fleet = fleet.with_restarts();
    }
    let mut truth = TruthPublisher::declare(session, keys, &loaded, M::LAYERS)
        .map_err(cannot("declare the world's views"))?;
    let mut audience: Vec<&mut dyn Audience<M>> = vec![&mut truth, audience];
    let is_interrupted = || options.interrupted.load(Ordering::SeqCst);
    let flown = fleet.gather(is_interrupted).map_err(WorldError::from).and_then(|()| {
        Ok(flight::run_fleet(loaded, &mut fleet, options, recorder, &mut audience)?)
    });
    fleet.end(match &flown {
        Ok(outcome) if outcome.interrupted => "ended by the user",
        Err(WorldError::Fleet(FleetError::Interrupted)) => "ended by the user",
        Ok(_) => "the mission is over",
        Err(_) => "the world cannot go on",
    });
    flown
}

/// Refuses to fly a run that another world flies: both would drive the same agents.
fn refuse_twice(session: &Session, keys: Keys) -> Result<(), WorldError> {
    let watch = Stopwatch::start();
    // A session that has just been opened may not be connected yet.
    while !watch.left(LOOK).is_zero() {
        let tokens = session.liveliness().get(keys.alive_world()).timeout(ANSWER_LIMIT).wait();
        if tokens.map_err(cannot("look for another world"))?.recv().is_ok() {
            return Err(WorldError::Twice { run: keys.0 });
        }
        std::thread::sleep(ANSWER_LIMIT);
    }
    Ok(())
}
