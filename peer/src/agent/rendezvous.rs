//! Until the first frame: the process sends probes, and tells the world which other processes it hears.

use std::ops::ControlFlow;
use std::time::Duration;

use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;
use csat_mission::words::named;
use csat_proto::ids::AgentId;

use super::AgentError;
use super::input::{AgentInput, RawFrame, Timer};
use super::shell::Shell;
use crate::wire::notice::WaitNotice;

/// How often the process sends a probe.
const PROBE_PERIOD: Duration = Duration::from_millis(50);

/// A process that waits for its first frame.
pub(super) struct Rendezvous<'a, M: Mission> {
    shell: &'a mut Shell<M>,
    since_start: Stopwatch,
    since_probe: Stopwatch,
    is_world_alive: bool,
    /// `None` in a spawned process, whose world names the missing ones.
    notice: Option<WaitNotice>,
    /// How many of the agents are UAVs, and how many agents there are.
    fleet: [u16; 2],
}

impl<'a, M: Mission> Rendezvous<'a, M> {
    pub fn new(shell: &'a mut Shell<M>, fleet: [u16; 2], is_spawned: bool) -> Self {
        Self {
            shell,
            since_start: Stopwatch::start(),
            since_probe: Stopwatch::start(),
            is_world_alive: false,
            notice: (!is_spawned).then(WaitNotice::start),
            fleet,
        }
    }

    /// Returns the first frame. Breaks with the reason when the mission is over before it.
    pub fn run(mut self) -> Result<ControlFlow<String, Box<RawFrame>>, AgentError> {
        loop {
            if self.since_probe.left(PROBE_PERIOD).is_zero() {
                self.announce()?;
            }
            let timer = (Timer::Probe, self.since_probe.left(PROBE_PERIOD));
            match self.shell.port.next(Some(timer)) {
                AgentInput::Frame(frame) if self.shell.port.is_outdated(frame.header.step) => {}
                AgentInput::Frame(frame) => return Ok(ControlFlow::Continue(frame)),
                AgentInput::WorldAlive => self.is_world_alive = true,
                input => {
                    if let ControlFlow::Break(reason) = self.shell.handle(input, None)? {
                        return Ok(ControlFlow::Break(reason));
                    }
                }
            }
        }
    }

    /// Sends a probe and tells the world which agents this process hears: again and again, because the
    /// world and the other agents may not have subscribed yet.
    fn announce(&mut self) -> Result<(), AgentError> {
        // Without the world's token the process would not notice the end of the world.
        if !self.is_world_alive && self.since_start.left(self.shell.patience).is_zero() {
            let (key, limit_s) = (self.shell.keys.alive_world(), self.shell.patience.as_secs());
            return Err(AgentError::NoToken { key, limit_s });
        }
        self.since_probe = Stopwatch::start();
        self.tell_who_is_missing();
        self.shell.probe(true);
        self.shell.tell_ready();
        Ok(())
    }

    fn tell_who_is_missing(&mut self) {
        let Self { shell, fleet: [uavs, all], notice: Some(notice), .. } = self else { return };
        let (id, heard) = (shell.id, &shell.heard);
        notice.tell(|| {
            let is_silent = |agent: &u16| *agent != id.0 && !heard.contains_key(&AgentId(*agent));
            let (silent, own) = (named((0..*all).filter(is_silent), *uavs), named([id.0], *uavs));
            match silent.is_empty() {
                true => format!("the world's first frame: {own} hears all others"),
                false => format!("{silent} to be heard by {own}"),
            }
        });
    }
}
