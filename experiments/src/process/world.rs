//! The world's process: town, cars and cameras, and everybody's observer.

use crate::cli::RunArguments;
use clap::Args;
use csat_peer::arguments::PaceArguments;
use csat_peer::wire::session::WireArguments;
use std::path::PathBuf;
use std::time::Duration;

use csat_proto::control::{PROTOCOL, Pace, Welcome};
use csat_proto::ids::RunId;
use csat_proto::keys::Keys;
use zenoh::{Session, Wait};

use super::truth::Showcase;
use crate::flight::{self, Audience, FlightError, RunOptions};
use crate::missions::Offered;
use crate::record::{Outcome, RecordError, Recorder};
use crate::scenario::Loaded;
use csat_mission::timing::Stopwatch;
use csat_peer::process_number;
use csat_peer::world::port::Port;
use csat_peer::world::roster::Roster;
use csat_peer::world::{FleetError, RemoteFleet};

/// `csat world`.
#[derive(Debug, Clone, Args)]
pub struct WorldArguments {
    /// What to fly and where to write it down.
    #[command(flatten)]
    pub run: RunArguments,
    /// How time passes and how long to wait.
    #[command(flatten)]
    pub pace: PaceArguments,
    /// Where to listen and connect.
    #[command(flatten)]
    pub wire: WireArguments,
    /// End when standard input ends: whoever spawned this process is gone
    #[arg(long, hide = true)]
    pub leashed: bool,
    /// Agents' processes that end are started again: wait for one when none is left
    #[arg(long, hide = true)]
    pub restarts: bool,
    /// A folder with the agents' logs, to be moved into the run folder at the end
    #[arg(long, hide = true, value_name = "DIR")]
    pub logs: Option<PathBuf>,
}

/// How long others are looked for that may fly the run already.
const LOOK: Duration = Duration::from_secs(2);
/// How long they may take to answer.
const ANSWER_LIMIT: Duration = Duration::from_millis(300);

/// Why a world's process ended before its mission.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// Something of Zenoh.
    #[error("Zenoh: {0}")]
    Zenoh(String),
    /// The same run is flown already.
    #[error(
        "run {run} has a world already at these endpoints; expected another --seed, or that one to end"
    )]
    Twice {
        /// The run.
        run: RunId,
    },
    /// The agents' processes.
    #[error(transparent)]
    Fleet(#[from] FleetError),
    /// The flight.
    #[error(transparent)]
    Flight(#[from] FlightError<FleetError>),
    /// Writing it down.
    #[error(transparent)]
    Record(#[from] RecordError),
}

fn zenoh_error(error: zenoh::Error) -> WorldError {
    WorldError::Zenoh(error.to_string())
}

/// Waits for the agents' processes, flies the mission with them and records it.
///
/// # Errors
/// When processes are missing, or the mission cannot be flown or written down.
pub fn fly<M: Offered>(
    session: &Session,
    arguments: &WorldArguments,
    loaded: Loaded,
    options: &RunOptions,
    recorder: &mut Recorder,
    audience: &mut dyn Audience<M>,
) -> Result<Outcome, WorldError> {
    let WorldArguments { pace, wire, restarts, .. } = arguments;
    let keys = Keys(RunId(loaded.scenario.seed));
    // Who connects to nobody hears of another world only from those who join it.
    if !wire.connect.is_empty() {
        refuse_twice(session, keys)?;
    }
    let count = usize::from(loaded.scenario.agent_count());
    let speed = pace.realtime.map_or(Pace::Lockstep, Pace::Realtime);
    let welcome = Welcome {
        protocol: PROTOCOL,
        run: keys.0,
        world: process_number(),
        name: loaded.name.clone(),
        scenario: loaded.scenario.to_toml(),
        map: loaded.map.as_ref().map(|map| map.text.clone()),
        pace: speed,
    };
    let port = Port::declare(session, &welcome, count).map_err(zenoh_error)?;
    let mission = M::of(&loaded.scenario);
    let roster = Roster::new(welcome, count);
    let mut fleet = RemoteFleet::new(&mission, port, roster, speed, pace.patience);
    if *restarts {
        fleet = fleet.with_restarts(options.interrupted.clone());
    }
    let mut showcase = Showcase::declare(session, keys, &loaded, M::LAYERS).map_err(zenoh_error)?;
    let mut audience: Vec<&mut dyn Audience<M>> = vec![&mut showcase, audience];
    let is_over = || options.interrupted.load(std::sync::atomic::Ordering::SeqCst);
    let flown = fleet.gather(pace.patience, is_over).map_err(WorldError::from).and_then(|()| {
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

/// Two worlds of one run would drive the same agents.
fn refuse_twice(session: &Session, keys: Keys) -> Result<(), WorldError> {
    let watch = Stopwatch::start();
    // A session is open before it is connected.
    while !watch.left(LOOK).is_zero() {
        let tokens = session.liveliness().get(keys.alive_world()).timeout(ANSWER_LIMIT).wait();
        if tokens.map_err(zenoh_error)?.recv().is_ok() {
            return Err(WorldError::Twice { run: keys.0 });
        }
        std::thread::sleep(ANSWER_LIMIT);
    }
    Ok(())
}
