//! One process, virtual time: the world, the agents and the links, step by step.

use std::sync::Arc;

use csat_netem::config::NetemConfig;
use csat_netem::fate::Sent;
use csat_netem::link::{Counters, Links};
use csat_netem::rule::{Fate, Reason};
use csat_proto::agent::{Agent, Transmit};
use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::time::{SimTime, Step};
use csat_world::camera::Renderer;
use csat_world::scene::Scene;
use csat_world::truth::{Knowledge, MessageCounts, Monitor, Violation};
use csat_world::world::World;
use rayon::prelude::*;
use tracing::info_span;
use xxhash_rust::xxh3::Xxh3Default;

use crate::plug::Mission;
use crate::stages;
use crate::timing::StageTimes;

/// One agent and what surrounds it.
pub struct Seat<A: Agent> {
    /// The agent.
    pub agent: A,
    /// What the stages took since the start of the step.
    pub times: StageTimes,
    /// Bytes the agent sent in this step.
    pub bytes_sent: u64,
    renderer: Renderer,
    inbox: Vec<Arc<[u8]>>,
    outbox: Vec<Transmit>,
    events: Vec<A::Event>,
    commands: Vec<A::Command>,
}

/// A message that was lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drop {
    /// The message.
    pub sent: Sent,
    /// Why.
    pub reason: Reason,
}

/// What happened in one step.
pub struct StepTrace<E> {
    /// k.
    pub step: Step,
    /// What the agents reported, by agent.
    pub events: Vec<(AgentId, E)>,
    /// What the links lost.
    pub drops: Vec<Drop>,
    /// What the monitor found.
    pub violations: Vec<Violation>,
}

/// A running mission.
pub struct Engine<M: Mission> {
    mission: M,
    world: World,
    seats: Vec<Seat<M::Agent>>,
    links: Links,
    monitor: Monitor,
    seed: u64,
    period_s: f64,
    digest: Xxh3Default,
    started: bool,
}

impl<M: Mission> Engine<M> {
    /// A mission about to begin in `world`.
    pub fn new(mission: M, world: World, netem: &NetemConfig, seed: u64) -> Self {
        let seat = |index: usize| Seat {
            agent: mission.agent(AgentId(index as u16)),
            times: StageTimes::default(),
            bytes_sent: 0,
            renderer: Renderer::new(mission.camera()),
            inbox: Vec::new(),
            outbox: Vec::new(),
            events: Vec::new(),
            commands: Vec::new(),
        };
        let period_s = world.config().period_s;
        Self {
            seats: (0..world.poses().len()).map(seat).collect(),
            monitor: world.monitor(),
            links: Links::new(netem, seed),
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
        self.look(now);
        let drops = self.settle(now, next);
        self.obey();
        for seat in &self.seats {
            self.digest.update(&seat.agent.digest().to_le_bytes());
        }
        let violations = self.watch(step);
        StepTrace { step, events: self.collect_events(), drops, violations }
    }

    /// Renders every frame and hands it to its agent.
    fn look(&mut self, now: SimTime) {
        let scene: Scene = self.world.scene();
        let (poses, step, seed) = (self.world.poses(), self.world.step(), self.seed);
        self.seats.par_iter_mut().zip(&poses).enumerate().for_each(|(index, (seat, pose))| {
            let id = AgentId(index as u16);
            let Seat { renderer, agent, .. } = seat;
            let ((), times) = stages::collect(|| {
                let frame =
                    info_span!("render").in_scope(|| renderer.frame(&scene, pose, step, seed, id));
                agent.handle_frame(now, &frame);
            });
            seat.times = times;
            seat.bytes_sent = 0;
        });
    }

    /// Lets messages and timeouts take their turns until nothing is left before `next`.
    fn settle(&mut self, now: SimTime, next: SimTime) -> Vec<Drop> {
        let mut drops = Vec::new();
        let mut now = now;
        loop {
            self.send_all(now, &mut drops);
            let timeouts = self.seats.iter().filter_map(|seat| seat.agent.poll_timeout());
            let Some(due) = timeouts.chain(self.links.next_arrival()).min() else { break };
            if due >= next {
                break;
            }
            now = now.max(due);
            while let Some(arrival) = self.links.receive(now) {
                self.seats[usize::from(arrival.dst.0)].inbox.push(arrival.bytes);
            }
            self.seats.par_iter_mut().for_each(|seat| seat.run(now));
        }
        drops
    }

    /// Hands everything the agents want to say to the links.
    fn send_all(&mut self, now: SimTime, drops: &mut Vec<Drop>) {
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
                        incarnation: Incarnation(0),
                        channel: transmit.channel,
                        sequence: transmit.sequence,
                        time: now,
                        bytes: bytes.len(),
                        src_p_world: positions[src],
                        dst_p_world: positions[dst],
                    };
                    if let Fate::Lost(reason) = self.links.send(&sent, bytes.clone()) {
                        drops.push(Drop { sent, reason });
                    }
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
        struct Asked<'a, M: Mission>(&'a M, &'a M::Agent);
        impl<M: Mission> Knowledge for Asked<'_, M> {
            fn admits(&self, target: TargetId, location: [f64; 2], tolerance_m: f64) -> bool {
                self.0.admits(self.1, target, location, tolerance_m)
            }
        }
        let asked: Vec<Asked<'_, M>> =
            self.seats.iter().map(|seat| Asked(&self.mission, &seat.agent)).collect();
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

impl<A: Agent> Seat<A> {
    /// Handles what arrived and, if its time has come, the timeout.
    fn run(&mut self, now: SimTime) {
        let inbox = std::mem::take(&mut self.inbox);
        let agent = &mut self.agent;
        let ((), times) = stages::collect(|| {
            for bytes in inbox {
                agent.handle_message(now, &bytes);
            }
            if agent.poll_timeout().is_some_and(|due| due <= now) {
                agent.handle_timeout(now);
            }
        });
        self.times.add(&times);
    }

    /// Takes everything the agent has to say.
    fn poll(&mut self) {
        self.outbox.extend(std::iter::from_fn(|| self.agent.poll_transmit()));
        self.commands.extend(std::iter::from_fn(|| self.agent.poll_command()));
        self.events.extend(std::iter::from_fn(|| self.agent.poll_event()));
    }
}
