//! A mission step by step: the world, its fleet wherever it is, and the monitor.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use csat_netem::config::{NetemConfig, OutageConfig};
use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::{Arrival, LinkId};
use csat_netem::propagation::Obstruction;
use csat_proto::agent::Agent;
use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::{SimTime, Step};
use csat_world::radio::Buildings;
use csat_world::target::TargetTruth;
use csat_world::truth::{CheckCounts, Checked, MessageCounts, Monitor};
use csat_world::world::World;
use serde::Serialize;
use xxhash_rust::xxh3::Xxh3Default;

use crate::fleet::{Brief, Fleet, Frames};
pub use crate::fleet::{Flown, Passage};
use crate::judge::{Broken, Fault, Judge, Judged, Truth, Violation};
use crate::local::LocalFleet;
use crate::mission::{Detail, Mission, Report, Tally};
use crate::node::Node;

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

/// What happened in one step.
pub struct StepTrace<M: Mission> {
    /// k.
    pub step: Step,
    /// Who crashed or was restarted.
    pub lives: Vec<(AgentId, LifeEvent)>,
    /// Whether each agent runs, by index. In real time one that runs may have told nothing yet.
    pub alive: Vec<bool>,
    /// What each agent told its observers, by index.
    pub flown: Vec<Flown<M>>,
    /// What the agents reported, by agent.
    pub events: Vec<(AgentId, <M::Agent as Agent>::Event)>,
    /// What the links did, in the order of sending.
    pub passages: Vec<Passage>,
    /// What arrived, in the order of arrival.
    pub arrivals: Vec<Arrival>,
    /// What the monitor and the judge found.
    pub violations: Vec<Violation>,
}

impl<M: Mission> StepTrace<M> {
    fn new(
        step: Step,
        lives: Vec<(AgentId, LifeEvent)>,
        alive: Vec<bool>,
        mut flown: Vec<Flown<M>>,
        violations: Vec<Violation>,
    ) -> Self {
        let (mut events, mut passages, mut arrivals) = (Vec::new(), Vec::new(), Vec::new());
        for agent in &mut flown {
            events.extend(agent.events.drain(..).map(|event| (agent.agent, event)));
            passages.append(&mut agent.passages);
            arrivals.append(&mut agent.arrivals);
        }
        passages.sort_by_key(|Passage { sent: s, .. }| {
            (s.time, s.src, s.incarnation, s.channel, s.sequence, s.dst)
        });
        arrivals.sort_by_key(|arrival: &Arrival| (arrival.at, arrival.src));
        Self { step, lives, alive, flown, events, passages, arrivals, violations }
    }
}

/// An agent's life, as the engine keeps books of it.
#[derive(Debug, Clone, Copy)]
struct Life {
    incarnation: Incarnation,
    is_alive: bool,
    /// Which process drives it, or drove it last.
    process: Option<u64>,
}

/// A running mission.
pub struct Engine<M: Mission, F = LocalFleet<M>> {
    world: World,
    fleet: F,
    lives: Vec<Life>,
    /// What each agent did not believe and did not say in its present life.
    tallies: Vec<Tally>,
    /// What lives that are over did not believe and did not say.
    ended: Tally,
    crashes: Vec<OutageConfig>,
    monitor: Monitor,
    judge: M::Judge,
    /// What the judge checked.
    judged: CheckCounts,
    /// Reports that came after the truth of their step was forgotten.
    unchecked: u64,
    /// Where targets and agents were.
    truths: VecDeque<Kept>,
    /// Whether what each agent has seen so far was false, by index.
    is_false: Vec<bool>,
    seed: u64,
    period_s: f64,
    digest: Xxh3Default,
    bytes_sent: u64,
    started: bool,
}

/// What was true at a step.
struct Kept {
    step: Step,
    targets: Vec<TargetTruth>,
    poses: Vec<Pose>,
}

impl Kept {
    fn truth<'a>(&'a self, is_false: &'a [bool]) -> Truth<'a> {
        Truth { step: self.step, targets: &self.targets, poses: &self.poses, is_false }
    }
}

/// For how many steps the truth is kept, for reports that come late.
pub const MAX_TRUTHS: usize = 128;

/// Whether an outage lasts at a time.
fn is_on(outage: &OutageConfig, now: SimTime) -> bool {
    (outage.from_s..outage.until_s).contains(&now.seconds())
}

/// What may stand between antennas, if a channel of `netem` asks for it.
pub fn obstruction(netem: &NetemConfig, world: &World) -> Option<Arc<dyn Obstruction>> {
    netem
        .has_propagation()
        .then(|| Arc::new(Buildings::new(world.obstacles())) as Arc<dyn Obstruction>)
}

impl<M: Mission + Clone> Engine<M> {
    /// A mission about to begin in `world`, with all agents in this process.
    pub fn new(mission: M, world: World, netem: &NetemConfig, seed: u64) -> Self {
        let count = world.poses().len();
        let obstruction = obstruction(netem, &world);
        let fleet = LocalFleet::new(mission.clone(), count, netem, seed, obstruction);
        Self::with_fleet(mission, world, fleet, netem, seed)
    }

    /// The agents, by index.
    pub fn nodes(&self) -> &[Node<M>] {
        self.fleet.nodes()
    }

    /// What the links do from now on; what is under way stays under way.
    pub fn reconfigure_links(&mut self, netem: &NetemConfig) {
        self.fleet.reconfigure_links(netem);
        self.crashes = netem.crashes().cloned().collect();
    }

    /// Flies one step: the first call is step 0, at the start.
    pub fn step(&mut self) -> StepTrace<M> {
        let Ok(trace) = self.try_step(Detail::Brief);
        trace
    }
}

impl<M: Mission, F: Fleet<M>> Engine<M, F> {
    /// A mission about to begin in `world`, flown by `fleet`.
    pub fn with_fleet(mission: M, world: World, fleet: F, netem: &NetemConfig, seed: u64) -> Self {
        let count = world.poses().len();
        let period_s = world.config().period_s;
        let life = Life { incarnation: Incarnation(0), is_alive: true, process: None };
        Self {
            lives: vec![life; count],
            tallies: vec![Tally::default(); count],
            ended: Tally::default(),
            monitor: world.monitor(),
            judge: mission.judge(&world),
            judged: CheckCounts::default(),
            unchecked: 0,
            truths: VecDeque::new(),
            is_false: vec![false; count],
            crashes: netem.crashes().cloned().collect(),
            world,
            fleet,
            seed,
            period_s,
            digest: Xxh3Default::new(),
            bytes_sent: 0,
            started: false,
        }
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Where targets were at a step of late: in real time a report may be of an earlier step than the
    /// world's. `None` if that was too long ago.
    pub fn truth_at(&self, step: Step) -> Option<&[TargetTruth]> {
        truth_at(&self.truths, step).map(|truth| truth.targets.as_slice())
    }

    /// Where agents were at such a step, by index.
    pub fn poses_at(&self, step: Step) -> Option<&[Pose]> {
        truth_at(&self.truths, step).map(|truth| truth.poses.as_slice())
    }

    /// What judges the agents.
    pub fn judge(&self) -> &M::Judge {
        &self.judge
    }

    /// The agents, wherever they are.
    pub fn fleet_mut(&mut self) -> &mut F {
        &mut self.fleet
    }

    /// Whether an agent runs.
    pub fn is_alive(&self, agent: AgentId) -> bool {
        self.lives[usize::from(agent.0)].is_alive
    }

    /// Whether what an agent has seen so far was false: it lied, or took a target for another one.
    pub fn is_false(&self, agent: AgentId) -> bool {
        self.is_false[usize::from(agent.0)]
    }

    /// Everything each agent knows, or knew when it crashed.
    pub fn show(&mut self) -> Vec<Option<M::Report>> {
        self.fleet.show()
    }

    /// What all lives did not believe and did not say.
    pub fn tally(&self) -> Tally {
        let mut tally = self.ended.clone();
        self.tallies.iter().for_each(|more| tally.add(more));
        tally
    }

    /// What the links did so far.
    pub fn counters(&self) -> Counters {
        // Each receiver counts the bytes of a broadcast.
        Counters { bytes_sent: self.bytes_sent, ..self.fleet.counters() }
    }

    /// What each link did so far, by sender, receiver and channel.
    pub fn per_link(&self) -> Vec<(LinkId, LinkCounters)> {
        self.fleet.per_link()
    }

    /// How many frames each agent was shown and missed so far.
    pub fn frames(&self) -> Vec<Frames> {
        self.fleet.frames()
    }

    /// What processes did not believe of what was said to them so far, by kind.
    pub fn refused(&self) -> BTreeMap<String, u64> {
        self.fleet.refused()
    }

    /// All checks so far, by promise: the monitor's and the judge's.
    pub fn checked(&self) -> CheckCounts {
        let mut checked = self.judged.clone();
        checked.add_all(self.monitor.counts());
        checked
    }

    /// How many reports of agents came too late to be judged so far.
    pub fn unchecked(&self) -> u64 {
        self.unchecked
    }

    /// Hash of every agent's state at every step so far.
    pub fn digest(&self) -> u64 {
        self.digest.digest()
    }

    /// Flies one step: the first call is step 0, at the start.
    ///
    /// # Errors
    /// When the fleet cannot fly it.
    pub fn try_step(&mut self, detail: Detail) -> Result<StepTrace<M>, F::Error> {
        if self.started {
            self.world.advance();
        }
        self.started = true;
        let step = self.world.step();
        let at = |step: Step| SimTime::from_seconds(f64::from(step.0) * self.period_s);
        let (now, next) = (at(step), at(Step(step.0 + 1)));
        let is_down = |agent| self.crashes.iter().any(|c| c.agent == agent && is_on(c, now));
        let is_down_by_schedule: Vec<bool> = (0..self.lives.len() as u16).map(is_down).collect();
        let lives = self.crash_and_restart(&is_down_by_schedule);
        let brief = Brief {
            step,
            now,
            next,
            seed: self.seed,
            scene: self.world.scene(),
            false_scenes: self.world.false_scenes(),
            targets: self.world.targets().to_vec(),
            roads: self.world.road_area().cloned(),
            poses: self.world.poses(),
            reported: self.world.reported_poses(),
            lives: self.lives.iter().map(|l| l.is_alive.then_some(l.incarnation)).collect(),
            is_down_by_schedule,
            detail,
        };
        let mut flown = self.fleet.fly(&brief)?;
        self.note_falsehoods(&brief);
        self.obey(&mut flown);
        for agent in &flown {
            self.digest.update(&agent.digest.to_le_bytes());
            self.bytes_sent += agent.bytes_sent;
            if let Some(report) = &agent.report {
                self.tallies[usize::from(agent.agent.0)].clone_from(report.tally());
            }
        }
        let violations = self.watch(step, &flown);
        let alive = self.lives.iter().map(|life| life.is_alive).collect();
        Ok(StepTrace::new(step, lives, alive, flown, violations))
    }

    /// Notes which agents have seen something false by now.
    fn note_falsehoods(&mut self, brief: &Brief) {
        for (is_false, has_erred) in self.is_false.iter_mut().zip(self.fleet.has_misidentified()) {
            *is_false |= has_erred;
        }
        for liar in brief.false_scenes.keys() {
            self.is_false[usize::from(liar.0)] = true;
        }
    }

    /// Ends and begins the lives of agents: by the schedule of crashes, and as their processes come
    /// and go.
    fn crash_and_restart(&mut self, is_down_by_schedule: &[bool]) -> Vec<(AgentId, LifeEvent)> {
        let step = self.world.step();
        let mut events = Vec::new();
        let attendance = self.fleet.attendance();
        for (index, (life, process)) in self.lives.iter_mut().zip(attendance).enumerate() {
            let id = AgentId(index as u16);
            let is_scheduled = is_down_by_schedule[index];
            let is_another = life.process.is_some() && process != life.process;
            if life.is_alive && (is_scheduled || process.is_none() || is_another) {
                life.is_alive = false;
                self.ended.add(&std::mem::take(&mut self.tallies[index]));
                events.push((id, LifeEvent::Crashed { step, incarnation: life.incarnation }));
            }
            if !life.is_alive && !is_scheduled && process.is_some() {
                life.is_alive = true;
                life.incarnation.0 += 1;
                events.push((id, LifeEvent::Restarted { step, incarnation: life.incarnation }));
            }
            life.process = process.or(life.process);
        }
        events
    }

    /// Passes the agents' commands to their vehicles; they take effect from this step on.
    fn obey(&mut self, flown: &mut [Flown<M>]) {
        for flown in flown {
            for command in flown.commands.drain(..) {
                if let Err(error) = self.world.command(flown.agent, command) {
                    tracing::error!(%error, "command refused");
                }
            }
        }
    }

    /// Lets the monitor check the world and the judge each report. An agent that does not run claims
    /// nothing.
    fn watch(&mut self, step: Step, flown: &[Flown<M>]) -> Vec<Violation> {
        let targets = self.world.targets();
        let mut found = self.monitor.check(step, targets);
        // Ground stations stand beside buildings, or on them.
        let uavs = usize::from(self.world.config().fleet.count);
        found.extend(self.monitor.check_flights(step, &self.world.poses()[..uavs]));
        let poses = self.world.poses();
        self.truths.push_back(Kept { step, targets: targets.to_vec(), poses });
        if self.truths.len() > MAX_TRUTHS {
            self.truths.pop_front();
        }
        let mut found: Vec<Violation> = found.into_iter().map(Violation::from).collect();
        for flown in flown {
            if let Some(report) = &flown.report {
                found.extend(self.judge_report(step, flown.agent, report));
            }
        }
        found.extend(self.close_step());
        let counters = self.fleet.counters();
        let counts = MessageCounts {
            sent: counters.sent,
            duplicated: counters.duplicated,
            delivered: counters.delivered,
            dropped: counters.dropped.values().sum(),
            in_flight: counters.in_flight,
        };
        found.extend(self.monitor.check_messages(step, counts).map(Violation::from));
        found
    }

    /// Holds a report against the truth at its step.
    fn judge_report(&mut self, now: Step, agent: AgentId, report: &M::Report) -> Vec<Violation> {
        let step = report.step();
        let Some(truth) = truth_at(&self.truths, step) else {
            tracing::warn!(%agent, %step, %now, "a report too late to check");
            self.unchecked += 1;
            return Vec::new();
        };
        let judged = self.judge.judge(agent, report, &truth.truth(&self.is_false));
        self.note(step, judged)
    }

    /// Lets the judge close the world's step.
    fn close_step(&mut self) -> Vec<Violation> {
        let Some(truth) = self.truths.back() else { return Vec::new() };
        let is_alive: Vec<bool> = self.lives.iter().map(|life| life.is_alive).collect();
        let (step, judged) =
            (truth.step, self.judge.close(&truth.truth(&self.is_false), &is_alive));
        self.note(step, judged)
    }

    /// Counts what the judge checked, and gives what it found.
    fn note(&mut self, step: Step, Judged { checks, faults }: Judged) -> Vec<Violation> {
        for (promise, checks) in checks {
            self.judged.add(promise, Checked { checks, violations: 0 });
        }
        let violation = |fault: Broken| {
            self.judged.add(fault.promise, Checked { checks: 0, violations: 1 });
            Violation { step, fault: Fault::Mission(fault) }
        };
        faults.into_iter().map(violation).collect()
    }
}

fn truth_at(truths: &VecDeque<Kept>, step: Step) -> Option<&Kept> {
    truths.iter().find(|truth| truth.step == step)
}
