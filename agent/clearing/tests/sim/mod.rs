//! A small simulator of the road clearing, apart from the one of csat: roads on a raster, cameras, odometry, links,
//! and evaders of unbounded speed.

pub mod links;
pub mod town;
pub mod truth;
pub mod vehicle;

use csat_clearing::agent::{ClearingAgent, Role};
use csat_clearing::bitmap::Bitmap;
use csat_clearing::config::{AgentConfig, ClearingConfig, OdometryBounds, Rules, mistakes};
use csat_proto::agent::Agent;
use csat_proto::camera::CameraModel;
use csat_proto::command::Command;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::FleetModel;
use csat_proto::time::{SimTime, Step};
use links::{LinkModel, Links};
use town::Town;
use truth::Truth;
use vehicle::Vehicle;

pub const PERIOD_S: f64 = 0.125;
/// How often masks are held against the truth, steps.
const CHECK_STEPS: u32 = 8;
pub const HBSR: ChannelId = ChannelId(0);
pub const LBLR: ChannelId = ChannelId(1);

/// What is flown.
#[derive(Debug, Clone)]
pub struct Setup {
    pub town: Town,
    pub seed: u64,
    pub uavs: u16,
    pub clearing: ClearingConfig,
    pub links: LinkModel,
    pub motion_error_m: f64,
    pub odometry: OdometryBounds,
    pub offset_error_m: f64,
    pub max_s: f64,
    /// The agent that crashes, and when, seconds.
    pub crash: Option<(usize, f64)>,
}

impl Setup {
    pub fn new(town: Town, seed: u64) -> Self {
        Self {
            town,
            seed,
            uavs: 8,
            clearing: ClearingConfig::default(),
            links: LinkModel::default(),
            motion_error_m: 0.05,
            odometry: OdometryBounds { jitter_m: 0.1, drift_share: 0.005 },
            offset_error_m: 0.5,
            max_s: 3000.0,
            crash: None,
        }
    }

    pub fn config(&self, id: u16) -> AgentConfig {
        AgentConfig {
            run: RunId(1),
            seed: self.seed,
            id: AgentId(id),
            incarnation: Incarnation(0),
            period_s: PERIOD_S,
            fleet: FleetModel {
                count: self.uavs,
                speed_m_s: 5.0,
                altitude_m: 70.0,
                altitude_step_m: 0.0,
                ..FleetModel::default()
            },
            stations: 0,
            camera: CameraModel {
                columns: 256,
                rows: 256,
                aperture_deg: 80.0,
                tilt_deg: 90.0,
                ..CameraModel::default()
            },
            cell_m: truth::CELL_M,
            gap_px: 1,
            motion_error_m: self.motion_error_m,
            odometry: self.odometry,
            hbsr: HBSR,
            offset_error_m: self.offset_error_m,
            lblr: LBLR,
            bearing_error_deg: 5.0,
            start_line_m: [[0.0, -4.0], [0.0, 4.0]],
            clearing: self.clearing.clone(),
        }
    }
}

/// How a mission ended.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outcome {
    /// The share of R_S that is not contaminated.
    pub cleared_share: f64,
    /// When all of it was cleared, seconds.
    pub cleared_s: Option<f64>,
    /// Steps in which something that was claimed to be cleared was contaminated.
    pub violations: u32,
    pub first_violation: Option<String>,
    /// Where road was taken for cleared, or for no road, that nobody has cleared.
    pub overlooked: Option<String>,
    /// When it ended, seconds.
    pub end_s: f64,
    pub is_stalled: bool,
    pub has_lost: bool,
    pub cleaners_max: usize,
    pub splits: u32,
    pub encounters: u32,
    pub merges: u32,
    pub rejected: u64,
}

/// A mission in flight.
pub struct Flight {
    pub setup: Setup,
    pub truth: Truth,
    pub agents: Vec<ClearingAgent>,
    pub vehicles: Vec<Vehicle>,
    pub links: Links,
    pub step: u32,
    pub outcome: Outcome,
    /// Since when nobody can move on.
    idle_since: Option<f64>,
    is_alive: Vec<bool>,
}

impl Flight {
    pub fn new(setup: &Setup) -> Self {
        let agents: Vec<_> =
            (0..setup.uavs).map(|id| ClearingAgent::new(&setup.config(id))).collect();
        let wrong = mistakes(&setup.config(0));
        assert!(wrong.is_empty(), "{wrong:?}");
        let vehicles = (0..setup.uavs).map(|id| Vehicle::new(setup, id)).collect();
        Self {
            truth: Truth::new(&setup.town),
            is_alive: vec![true; agents.len()],
            agents,
            vehicles,
            links: Links::new(setup),
            step: 0,
            outcome: Outcome::default(),
            idle_since: None,
            setup: setup.clone(),
        }
    }

    pub fn time_s(&self) -> f64 {
        f64::from(self.step) * PERIOD_S
    }

    /// Flies a step; returns whether the mission goes on.
    pub fn advance(&mut self) -> bool {
        let now = SimTime::from_seconds(self.time_s());
        if let Some((agent, _)) = self.setup.crash.filter(|(_, at)| *at <= self.time_s()) {
            self.is_alive[agent] = false;
        }
        for index in self.alive() {
            let frame = self.vehicles[index].frame(Step(self.step), &self.truth);
            self.agents[index].handle_frame(now, &frame);
            self.send(index);
        }
        let places: Vec<[f64; 2]> = self.vehicles.iter().map(|vehicle| vehicle.place_m).collect();
        for (to, message) in self.links.arrivals(self.step, &places) {
            if self.is_alive[to] {
                self.agents[to].handle_message(now, &message);
            }
        }
        for index in self.alive() {
            assert!(self.agents[index].poll_timeout().is_some());
            self.agents[index].handle_timeout(now);
            self.send(index);
            self.command(index);
        }
        self.judge();
        self.step += 1;
        !self.is_over()
    }

    fn alive(&self) -> Vec<usize> {
        (0..self.agents.len()).filter(|index| self.is_alive[*index]).collect()
    }

    fn send(&mut self, from: usize) {
        while let Some(sent) = self.agents[from].poll_transmit() {
            let place = self.vehicles[from].place_m;
            self.links.send(self.step, from, place, sent.channel, sent.bytes.into());
        }
        while self.agents[from].poll_event().is_some() {}
    }

    fn command(&mut self, index: usize) {
        while let Some(command) = self.agents[index].poll_command() {
            let Command::Displace { by_m } = command else { panic!("{command:?}") };
            self.vehicles[index].displace(by_m);
        }
    }

    /// The cleaners.
    pub fn cleaners(&self) -> Vec<usize> {
        self.alive()
            .into_iter()
            .filter(|index| self.agents[*index].role() == Role::Cleaner)
            .collect()
    }

    fn judge(&mut self) {
        let cleaners = self.cleaners();
        let places: Vec<[f64; 2]> = cleaners.iter().map(|i| self.vehicles[*i].place_m).collect();
        self.truth.contaminate(&places);
        self.outcome.cleaners_max = self.outcome.cleaners_max.max(cleaners.len());
        let time_s = self.time_s();
        for index in self.alive() {
            let agent = &self.agents[index];
            assert_eq!(agent.step(), Step(self.step));
            self.truth.claim(self.vehicles[index].place_m, agent.claims());
            if let Some(masks) = agent.masks() {
                self.truth.take(self.vehicles[index].place_m, masks.mine());
            }
            let inside = Bitmap::inside(256, 256, self.setup.config(0).radii().rim());
            let is_held = !agent.frontier().meets(&inside.complement());
            let is_safe = self.setup.clearing.rules == Rules::Acknowledged;
            assert!(is_held || agent.has_lost() || !is_safe, "a frontier at the edge");
        }
        if self.step.is_multiple_of(CHECK_STEPS) {
            self.check_masks();
        }
        // Who notices a loss withdraws the claims of all.
        self.outcome.has_lost |= self.agents.iter().any(ClearingAgent::has_lost);
        if let Some(cell) = self.truth.violation()
            && !self.outcome.has_lost
        {
            self.outcome.violations += 1;
            self.outcome.first_violation.get_or_insert(format!("{time_s} s at {cell:?} m"));
        }
        if self.truth.is_cleared() && self.outcome.cleared_s.is_none() {
            self.outcome.cleared_s = Some(time_s);
        }
        let can_move = self.agents.iter().any(|agent| agent.is_cleaner() && !agent.is_stalled());
        if can_move {
            self.idle_since = None;
        } else {
            self.idle_since.get_or_insert(time_s);
        }
    }

    /// All road in sight that is not in 𝒱 is unknown to the agent.
    fn check_masks(&mut self) {
        for index in self.alive() {
            let (agent, place_m) = (&self.agents[index], self.vehicles[index].place_m);
            let Some(masks) = agent.masks().filter(|_| !self.outcome.has_lost) else { continue };
            let margin = agent.config().radii().blind() + truth::SLACK_PX;
            if let Some(pixel) = self.truth.overlooked(place_m, masks.unknown(), margin) {
                let found = format!("{} s, UAV {index}, pixel {pixel:?}", self.time_s());
                self.outcome.overlooked.get_or_insert(found);
            }
        }
    }

    fn is_over(&self) -> bool {
        let time_s = self.time_s();
        let is_done = self.outcome.cleared_s.is_some() && self.cleaners().is_empty();
        is_done
            || time_s > self.setup.max_s
            || self.idle_since.is_some_and(|idle| time_s > idle + 60.0)
    }

    pub fn finish(mut self) -> Outcome {
        let sum = |of: fn(&ClearingAgent) -> u32| self.agents.iter().map(of).sum();
        self.outcome.splits = sum(|agent| agent.counters().splits);
        self.outcome.encounters = sum(|agent| agent.counters().encounters);
        self.outcome.merges = sum(|agent| agent.counters().merges);
        self.outcome.rejected =
            self.agents.iter().flat_map(|agent| agent.rejected().values()).sum();
        self.outcome.is_stalled = self.agents.iter().any(ClearingAgent::is_stalled);
        self.outcome.cleared_share = self.truth.cleared_share();
        self.outcome.end_s = self.time_s();
        self.outcome
    }
}

/// Flies a mission to its end.
pub fn fly(setup: &Setup) -> Outcome {
    let mut flight = Flight::new(setup);
    while flight.advance() {}
    flight.finish()
}
