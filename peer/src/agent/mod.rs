//! The process of one agent: its node, driven by what comes over Zenoh.
//!
//! | module | what it does |
//! |---|---|
//! | `join` | asks for a world |
//! | `rendezvous` | sends probes until the first frame |
//! | `lockstep` | the loop of a process that waits for all messages that the world announces |
//! | `realtime` | the loop of a process that runs its agent by the clock |
//! | `shell` | what both loops share: it passes inputs to the node, and sends what the node returns |
//! | `peers` | which other processes this one hears |
//! | `reporting` | answers to the world, to other agents and to spectators |
//! | `input` | the queue of inputs, and why a process wakes without one |
//! | `port` | the agent's Zenoh keys |
//! | `frame_gate` | refuses frames that cannot be the next one |
//! | `queue` | puts messages in order |
//! | `views` | documents for people |

use csat_mission::mission::Mission;
use csat_netem::link::Links;
use csat_proto::control::{Pace, Welcome};
use csat_world::world::WorldErrors;
use std::ops::ControlFlow;
use zenoh::Session;

use crate::arguments::AgentArguments;
use crate::parent_death;
use crate::wire::session::{self, Role};

mod error;
mod frame_gate;
pub(crate) mod input;
mod join;
mod lockstep;
mod peers;
mod port;
pub(crate) mod queue;
mod realtime;
mod rendezvous;
mod reporting;
mod shell;
mod views;

pub use error::{AgentError, EndedBy, WelcomeError};
use input::{AgentInput, Inlet};
use lockstep::Lockstep;
use realtime::Realtime;
use rendezvous::Rendezvous;
use shell::Shell;

/// The mission of an agent's process, as it reads it from the world's welcome.
pub struct Setup<M: Mission> {
    /// The mission.
    pub mission: M,
    /// T, seconds.
    pub period_s: f64,
    /// How many radios the agent has.
    pub channels: usize,
    /// How many of the agents are UAVs.
    pub uavs: u16,
    /// How many agents there are.
    pub agents: u16,
    /// Makes the links to the agent. This may take long: the process calls it once it holds its token.
    pub links: Box<dyn FnOnce() -> Result<Links, WorldErrors>>,
}

/// A process that the world has welcomed.
pub struct Welcomed<'a> {
    /// What the world said.
    pub welcome: Welcome,
    session: &'a Session,
    arguments: &'a AgentArguments,
    process: u64,
    inlet: Inlet,
}

impl Welcomed<'_> {
    /// Drives the agent until the mission is over. Returns the reason that the world gives.
    ///
    /// # Errors
    /// When the process cannot take part, or not go on.
    pub fn fly<M: Mission>(self, setup: Setup<M>) -> Result<String, AgentError> {
        let (pace, is_spawned) = (self.welcome.pace, self.arguments.end_with_parent);
        let fleet = [setup.uavs, setup.agents];
        let mut shell = Shell::new(self, setup)?;
        let first = match Rendezvous::new(&mut shell, fleet, is_spawned).run()? {
            ControlFlow::Continue(frame) => frame,
            ControlFlow::Break(reason) => return Ok(reason),
        };
        match pace {
            Pace::Lockstep => Lockstep::start(shell, &first)?.run(),
            Pace::Realtime(speed) => Realtime::start(shell, &first, speed)?.run(),
        }
    }
}

/// Joins the world that answers and calls `fly` with its welcome. `why_no_world` explains that none does.
///
/// # Errors
/// When the process cannot take part, or not go on.
pub fn join(
    arguments: &AgentArguments,
    why_no_world: impl Fn(&Session) -> String,
    fly: impl FnOnce(Welcomed<'_>) -> Result<String, AgentError>,
) -> Result<String, AgentError> {
    let inlet = Inlet::default();
    // Before all else: the parent process may end before there is a world.
    watch_for_the_end(&inlet, arguments.end_with_parent);
    let session = session::open(&arguments.wire, Role::Agent(arguments.id))?;
    let process = crate::process_number();
    let welcome = join::join(&session, arguments, process, &inlet, why_no_world);
    let result = welcome.and_then(|welcome| {
        fly(Welcomed { welcome, session: &session, arguments, process, inlet })
    });
    session::close(session);
    result
}

/// Ctrl-C and SIGTERM end the process, and so does the end of its parent if `end_with_parent`.
fn watch_for_the_end(inlet: &Inlet, end_with_parent: bool) {
    let sender = inlet.sender();
    let signal = sender.clone();
    let installed = ctrlc::set_handler(move || {
        if signal.try_send(AgentInput::End(EndedBy::Signal)).is_err() {
            std::process::exit(130);
        }
    });
    if let Err(error) = installed {
        tracing::warn!(%error, "cannot listen to Ctrl-C");
    }
    if end_with_parent {
        parent_death::on_parent_death(move || {
            let _ = sender.send(AgentInput::End(EndedBy::Parent));
        });
    }
}
