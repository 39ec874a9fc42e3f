//! One process, virtual time: the world, the agents and the links, step by step.

use std::sync::Arc;

use csat_netem::config::{NetemConfig, OutageConfig};
use csat_netem::counters::Counters;
use csat_netem::fate::{Fate, Sent};
use csat_netem::link::{Arrival, Links};
use csat_netem::propagation::Obstruction;
use csat_proto::agent::Agent;
use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::time::{SimTime, Step};
use csat_world::radio::Buildings;
use csat_world::scene::Scene;
use csat_world::truth::{Knowledge, MessageCounts, Monitor, Violation};
use csat_world::world::World;
use rayon::prelude::*;
use serde::Serialize;
use xxhash_rust::xxh3::Xxh3Default;

use crate::plug::Mission;
use crate::seat::Seat;

/// What became of a message on its way to one receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// The message.
    pub sent: Sent,
    /// The encoded envelope.
    pub bytes: Arc<[u8]>,
    /// Its fate.
    pub fate: Fate,
}

/// An agent's process ended or began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum LifeEvent {
    /// It crashed.
    Crashed {
        /// At the start of this step.
        step: Step,
        /// Which life ended.
        incarnation: Incarnation,
    },
    /// It was started again.
    Restarted {
        /// At the start of this step.
        step: Step,
        /// Which life began.
        incarnation: Incarnation,
    },
}

/// What the links did in one step.
#[derive(Debug, Default)]
struct Settled {
    passages: Vec<Passage>,
    arrivals: Vec<Arrival>,
}

/// What happened in one step.
pub struct StepTrace<E> {
    /// k.
    pub step: Step,
    /// Who crashed or was restarted.
    pub lives: Vec<(AgentId, LifeEvent)>,
    /// What the agents reported, by agent.
    pub events: Vec<(AgentId, E)>,
    /// What the links did, in the order of sending.
    pub passages: Vec<Passage>,
    /// What arrived, in the order of arrival.
    pub arrivals: Vec<Arrival>,
    /// What the monitor found.
    pub violations: Vec<Violation>,
}

/// A running mission.
pub struct Engine<M: Mission> {
    mission: M,
    world: World,
    seats: Vec<Seat<M::Agent>>,
    links: Links,
    crashes: Vec<OutageConfig>,
    monitor: Monitor,
    seed: u64,
    period_s: f64,
    digest: Xxh3Default,
    started: bool,
}

/// Whether an outage lasts at a time.
fn is_on(outage: &OutageConfig, now: SimTime) -> bool {
    (outage.from_s..outage.until_s).contains(&now.seconds())
}

impl<M: Mission> Engine<M> {
    /// A mission about to begin in `world`.
    pub fn new(mission: M, world: World, netem: &NetemConfig, seed: u64) -> Self {
        let seat = |index: usize| {
            let agent = mission.agent(AgentId(index as u16), Incarnation(0));
            Seat::new(agent, mission.camera())
        };
        let period_s = world.config().period_s;
        let is_needed = netem.all_channels().any(|(_, channel)| channel.propagation.is_some());
        let buildings = || Arc::new(Buildings::new(world.obstacles())) as Arc<dyn Obstruction>;
        let obstruction = is_needed.then(buildings);
        Self {
            seats: (0..world.poses().len()).map(seat).collect(),
            monitor: world.monitor(),
            links: Links::new(netem, seed, obstruction),
            crashes: netem.crashes().cloned().collect(),
            mission,
            world,
            seed,
            period_s,
            digest: Xxh3Default::new(),
            started: false,
        }
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The agents, by index.
    pub fn seats(&self) -> &[Seat<M::Agent>] {
        &self.seats
    }

    /// The agents, by index, for measurements that need their scratch memory.
    pub fn seats_mut(&mut self) -> &mut [Seat<M::Agent>] {
        &mut self.seats
    }

    /// The links.
    pub fn links(&self) -> &Links {
        &self.links
    }

    /// What the links do from now on; what is under way stays under way.
    pub fn reconfigure_links(&mut self, netem: &NetemConfig) {
        self.links.reconfigure(netem);
        self.crashes = netem.crashes().cloned().collect();
    }

    /// What the links did so far.
    pub fn counters(&self) -> &Counters {
        self.links.counters()
    }

    /// The monitor.
    pub fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// Hash of every agent's state at every step so far.
    pub fn digest(&self) -> u64 {
        self.digest.digest()
    }

    /// Flies one step: the first call is step 0, at the start.
    pub fn step(&mut self) -> StepTrace<<M::Agent as Agent>::Event> {
        if self.started {
            self.world.advance();
        }
        self.started = true;
        let step = self.world.step();
        let at = |step: Step| SimTime::from_seconds(f64::from(step.0) * self.period_s);
        let (now, next) = (at(step), at(Step(step.0 + 1)));
        let lives = self.crash_and_restart(now);
        self.look(now);
        let Settled { passages, arrivals } = self.settle(now, next);
        self.obey();
        for seat in &self.seats {
            let digest = if seat.is_alive() { seat.agent.digest() } else { 0 };
            self.digest.update(&digest.to_le_bytes());
        }
        let violations = self.watch(step);
        StepTrace { step, lives, events: self.collect_events(), passages, arrivals, violations }
    }

    /// Ends and begins the lives of agents by the schedule of crashes, at the steps that follow.
    fn crash_and_restart(&mut self, now: SimTime) -> Vec<(AgentId, LifeEvent)> {
        let step = self.world.step();
        let mut lives = Vec::new();
        for (index, seat) in self.seats.iter_mut().enumerate() {
            let id = AgentId(index as u16);
            let is_down = self.crashes.iter().any(|crash| crash.agent == id.0 && is_on(crash, now));
            match (seat.is_alive(), is_down) {
                (true, true) => {
                    let incarnation = seat.incarnation();
                    seat.crash();
                    lives.push((id, LifeEvent::Crashed { step, incarnation }));
                }
                (false, false) => {
                    seat.restart(|incarnation| self.mission.agent(id, incarnation));
                    let incarnation = seat.incarnation();
                    lives.push((id, LifeEvent::Restarted { step, incarnation }));
                }
                (true, false) | (false, true) => {}
            }
        }
        lives
    }

    /// Renders every frame and hands it to its agent.
    fn look(&mut self, now: SimTime) {
        let scene: Scene = self.world.scene();
        let (poses, step, seed) = (self.world.poses(), self.world.step(), self.seed);
        let seats = self.seats.par_iter_mut().zip(&poses).enumerate();
        seats.filter(|(_, (seat, _))| seat.is_alive()).for_each(|(index, (seat, pose))| {
            let id = AgentId(index as u16);
            seat.look(now, |renderer| renderer.frame(&scene, pose, step, seed, id));
        });
    }

    /// Lets messages and timeouts take their turns until nothing is left before `next`.
    fn settle(&mut self, now: SimTime, next: SimTime) -> Settled {
        let mut settled = Settled::default();
        let mut now = now;
        loop {
            self.send_all(now, &mut settled.passages);
            let timeouts = self.seats.iter().filter_map(|seat| seat.poll_timeout());
            let Some(due) = timeouts.chain(self.links.next_arrival()).min() else { break };
            if due >= next {
                break;
            }
            now = now.max(due);
            while let Some(arrival) = self.links.receive(now) {
                self.seats[usize::from(arrival.dst.0)].receive(arrival.bytes.clone());
                settled.arrivals.push(arrival);
            }
            self.seats.par_iter_mut().for_each(|seat| seat.run(now));
        }
        settled
    }

    /// Hands everything the agents want to say to the links.
    fn send_all(&mut self, now: SimTime, passages: &mut Vec<Passage>) {
        let positions: Vec<[f64; 3]> = self.world.poses().iter().map(|pose| pose.p_world).collect();
        for src in 0..self.seats.len() {
            self.seats[src].poll();
            for transmit in std::mem::take(&mut self.seats[src].outbox) {
                self.seats[src].bytes_sent += transmit.bytes.len() as u64;
                let bytes: Arc<[u8]> = transmit.bytes.into();
                for dst in (0..positions.len()).filter(|&dst| dst != src) {
                    let sent = Sent {
                        src: AgentId(src as u16),
                        dst: AgentId(dst as u16),
                        incarnation: self.seats[src].incarnation(),
                        channel: transmit.channel,
                        sequence: transmit.sequence,
                        time: now,
                        bytes: bytes.len(),
                        src_p_world: positions[src],
                        dst_p_world: positions[dst],
                    };
                    let fate = self.links.send(&sent, bytes.clone());
                    passages.push(Passage { sent, bytes: bytes.clone(), fate });
                }
            }
        }
    }

    /// Passes the agents' commands to their vehicles; they take effect from this step on.
    fn obey(&mut self) {
        for (index, seat) in self.seats.iter_mut().enumerate() {
            for command in seat.commands.drain(..) {
                if let Err(error) = self.world.command(AgentId(index as u16), command) {
                    tracing::error!(%error, "command refused");
                }
            }
        }
    }

    fn watch(&mut self, step: Step) -> Vec<Violation> {
        struct Asked<'a, M: Mission>(&'a M, &'a Seat<M::Agent>);
        impl<M: Mission> Knowledge for Asked<'_, M> {
            fn admits(&self, target: TargetId, location: [f64; 2], tolerance_m: f64) -> bool {
                // Who does not run claims nothing.
                !self.1.is_alive() || self.0.admits(&self.1.agent, target, location, tolerance_m)
            }
        }
        let asked: Vec<Asked<'_, M>> =
            self.seats.iter().map(|seat| Asked(&self.mission, seat)).collect();
        let agents: Vec<&dyn Knowledge> = asked.iter().map(|a| a as &dyn Knowledge).collect();
        let mut found = self.monitor.check(step, &agents, self.world.targets());
        let counters = self.links.counters();
        let counts = MessageCounts {
            sent: counters.sent,
            duplicated: counters.duplicated,
            delivered: counters.delivered,
            dropped: counters.dropped.values().sum(),
            in_flight: counters.in_flight,
        };
        found.extend(self.monitor.check_messages(step, counts));
        found
    }

    fn collect_events(&mut self) -> Vec<(AgentId, <M::Agent as Agent>::Event)> {
        let by_agent = self.seats.iter_mut().enumerate();
        by_agent
            .flat_map(|(i, seat)| seat.events.drain(..).map(move |e| (AgentId(i as u16), e)))
            .collect()
    }
}
