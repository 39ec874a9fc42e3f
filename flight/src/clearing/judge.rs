//! What the mission promises at every step: no road that is called cleared is contaminated, and every frontier lies
//! inside the image of the UAV that holds it. A crash of a UAV with a frontier is not survived: the promise is that it
//! is told.
//!
//! The contamination is the world's: evaders of unbounded speed, wherever no cleaner has looked since.

use std::collections::{BTreeMap, VecDeque};

use csat_clearing::bitmap::Bitmap;
use csat_clearing::config::AgentConfig;
use csat_mission::judge::{Broken, Judge, Judged, Promise, Truth};
use csat_mission::measures::Values;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;
use csat_world::contamination::{Contamination, Square};
use csat_world::road_area::RoadArea;
use csat_world::search_number::Network;
use serde_json::json;

use super::claims::Claims;
use super::report::Report;

/// What is called cleared is cleared.
pub const CLEARED: &str = "cleared";
/// A frontier lies in the image of the UAV that holds it.
pub const FRONTIER: &str = "frontier";

/// The loss of a frontier is told.
pub const TOLD: &str = "told";

/// All that the mission promises.
pub const PROMISES: &[Promise] = &[
    Promise { key: CLEARED, broken: "a road called cleared that is contaminated" },
    Promise {
        key: FRONTIER,
        broken: "a frontier that is not inside the image of the UAV that holds it",
    },
    Promise { key: TOLD, broken: "a UAV that crashed with its frontier, which no other one tells" },
];

/// For how many steps a report that is late is waited for, in real time.
const PATIENCE: usize = 64;

/// How long a loss may take to be told once it has been noticed, seconds.
const TELLING_S: f64 = 5.0;

/// Holds claims against the contamination.
pub struct Safety {
    camera: CameraModel,
    uavs: usize,
    /// R_S, the roads that are connected to the start line.
    connected: RoadArea,
    contamination: Contamination,
    claims: Claims,
    /// Steps whose reports are not complete, the oldest first.
    waiting: VecDeque<Waiting>,
    /// The last report of each UAV that was judged.
    last: BTreeMap<AgentId, Seen>,
    /// Whether a UAV says that a frontier is lost.
    is_lost: bool,
    /// Who crashed with a frontier, and when.
    fallen: Option<(AgentId, Step)>,
    /// Whether it was checked that this is told.
    is_told_checked: bool,
    /// How many steps there are to tell it.
    patience: u32,
    cleaners_max: usize,
    /// The search numbers of R_S: the same at every step.
    search_numbers: Values,
    /// The area of R_S that each UAV was the first to claim, m².
    first_m2: Vec<f64>,
}

/// A step, and what was reported of it so far.
struct Waiting {
    step: Step,
    poses: Vec<Pose>,
    is_alive: Vec<bool>,
    reports: BTreeMap<AgentId, Seen>,
}

/// What the judge needs of a report.
#[derive(Default)]
struct Seen {
    incarnation: Incarnation,
    /// The first step of its life.
    since: Step,
    is_cleaner: bool,
    has_frontier: bool,
    is_lost: bool,
    claims: Option<Bitmap>,
}

impl Safety {
    /// A judge of a fleet that starts at a part of `roads` that is `connected` and whose centre lines are `network`,
    /// if it has any.
    pub fn new(
        config: &AgentConfig,
        roads: &RoadArea,
        connected: RoadArea,
        network: Option<&Network>,
    ) -> Self {
        let uavs = usize::from(config.fleet.count);
        Self {
            camera: config.camera,
            uavs,
            connected,
            contamination: Contamination::new(roads),
            claims: Claims::new(roads),
            waiting: VecDeque::new(),
            last: BTreeMap::new(),
            is_lost: false,
            fallen: None,
            is_told_checked: false,
            patience: config.steps(config.clearing.lost_after_s + TELLING_S),
            cleaners_max: 0,
            search_numbers: network.map(search_numbers).unwrap_or_default(),
            first_m2: vec![0.0; uavs],
        }
    }

    /// Whether every UAV that runs has reported of the oldest step that waits.
    fn is_complete(&self) -> bool {
        let Some(oldest) = self.waiting.front() else { return false };
        let mut alive =
            oldest.is_alive.iter().take(self.uavs).zip(0..).filter(|(alive, _)| **alive);
        self.waiting.len() > PATIENCE
            || alive.all(|(_, id)| oldest.reports.contains_key(&AgentId(id)))
    }

    /// The step of `truth` among those that wait.
    fn waiting_for(&mut self, truth: &Truth<'_>) -> &mut Waiting {
        let place = self.waiting.iter().position(|waiting| waiting.step == truth.step);
        let place = place.unwrap_or_else(|| {
            let (poses, is_alive, reports) = (truth.poses.to_vec(), Vec::new(), BTreeMap::new());
            self.waiting.push_back(Waiting { step: truth.step, poses, is_alive, reports });
            self.waiting.len() - 1
        });
        &mut self.waiting[place]
    }

    fn is_another_life(&self, id: AgentId, seen: &Seen) -> bool {
        self.last.get(&id).is_some_and(|last| last.incarnation != seen.incarnation)
    }

    /// Judges the oldest step that waits.
    fn judge_oldest(&mut self, judged: &mut Judged) {
        let Some(Waiting { step, poses, is_alive, mut reports }) = self.waiting.pop_front() else {
            return;
        };
        for (index, is_alive) in is_alive.iter().enumerate().take(self.uavs) {
            let id = AgentId(index as u16);
            let seen = reports.remove(&id);
            let is_over = seen.as_ref().map_or(!is_alive, |seen| self.is_another_life(id, seen));
            if is_over && self.last.remove(&id).is_some_and(|seen| seen.has_frontier) {
                self.fallen = self.fallen.or(Some((id, step)));
            }
            match seen {
                Some(mut seen) => {
                    seen.since = self.last.get(&id).map_or(step, |last| last.since);
                    self.last.insert(id, seen);
                }
                None if is_over => {}
                // It said nothing of this step: what it claimed before is no claim of this image.
                None => self.last.entry(id).or_default().claims = None,
            }
        }
        let squares: BTreeMap<AgentId, Square> = self
            .last
            .iter()
            .filter(|(_, seen)| seen.is_cleaner)
            .map(|(id, _)| (*id, Square::of_image(&self.camera, &poses[usize::from(id.0)])))
            .collect();
        self.cleaners_max = self.cleaners_max.max(squares.len());
        let images: Vec<Square> = squares.values().copied().collect();
        let spread = self.contamination.step(&images);
        self.is_lost |= self.last.values().any(|seen| seen.is_lost);
        self.check_told(step, judged);
        if self.is_lost || self.fallen.is_some() {
            self.claims.withdraw_all();
            self.first_m2.iter_mut().for_each(|area| *area = 0.0);
            return;
        }
        self.hold(spread.recontaminated, judged);
        self.claim(&squares, judged);
        judged.checks.push((CLEARED, self.claims.count()));
    }

    /// Whether the loss of a frontier is told in time, by UAVs that live long enough to notice it.
    fn check_told(&mut self, step: Step, judged: &mut Judged) {
        let Some((agent, fell)) = self.fallen else { return };
        let Some(since) = self.last.values().map(|seen| seen.since).min() else { return };
        let is_due = step.0.saturating_sub(since.max(fell).0) >= self.patience;
        if is_due && !std::mem::replace(&mut self.is_told_checked, true) {
            judged.checks.push((TOLD, 1));
            if !self.is_lost {
                judged.faults.push(Broken::new(TOLD, agent, json!({ "crashed": agent })));
            }
        }
    }

    /// Holds the claims of before against what has become contaminated.
    fn hold(&mut self, cells: Vec<u32>, judged: &mut Judged) {
        let mut broken: BTreeMap<AgentId, Vec<u32>> = BTreeMap::new();
        for cell in cells {
            if let Some(agent) = self.claims.claimant(cell) {
                broken.entry(agent).or_default().push(cell);
                self.claims.withdraw(cell);
                self.count_first(agent, cell, -1.0);
            }
        }
        judged.faults.extend(broken.iter().map(|(agent, cells)| self.fault(*agent, cells)));
    }

    /// Takes down what the cleaners claim now.
    fn claim(&mut self, squares: &BTreeMap<AgentId, Square>, judged: &mut Judged) {
        for (agent, square) in squares {
            let Some(mask) = self.last.get_mut(agent).and_then(|seen| seen.claims.take()) else {
                continue;
            };
            let new = self.claims.claim(*agent, square, &mask);
            new.iter().for_each(|cell| self.count_first(*agent, *cell, 1.0));
            let is_dirty = |cell: &u32| self.contamination.is_contaminated(*cell);
            let dirty: Vec<u32> = new.into_iter().filter(is_dirty).collect();
            if !dirty.is_empty() {
                judged.faults.push(self.fault(*agent, &dirty));
            }
            for cell in dirty {
                self.claims.withdraw(cell);
                self.count_first(*agent, cell, -1.0);
            }
        }
    }

    fn count_first(&mut self, agent: AgentId, cell: u32, sign: f64) {
        if self.connected.contains(cell) {
            let cell_m = self.connected.cell_m();
            self.first_m2[usize::from(agent.0)] += sign * cell_m * cell_m;
        }
    }

    fn fault(&self, agent: AgentId, cells: &[u32]) -> Broken {
        let location = cells.first().map(|cell| self.connected.middle(*cell));
        let detail = json!({ "cells": cells.len(), "location": location });
        Broken::new(CLEARED, agent, detail)
    }

    fn share_pct(&self, area_m2: f64) -> f64 {
        100.0 * area_m2 / self.connected.area_m2()
    }
}

/// How many searchers need to see a point each to clear a network.
fn search_numbers(network: &Network) -> Values {
    let (edge, node) = (network.edge_search(), network.node_search());
    let numbers = [
        ("edge_search_at_least", edge.at_least),
        ("edge_search_at_most", edge.at_most),
        ("node_search_at_least", node.at_least),
        ("node_search_at_most", node.at_most),
    ];
    numbers.map(|(key, number)| (key, Some(number as f64))).to_vec()
}

impl Judge<Report> for Safety {
    fn judge(&mut self, agent: AgentId, report: &Report, truth: &Truth<'_>) -> Judged {
        let mut judged = Judged::default();
        if usize::from(agent.0) >= self.uavs {
            return judged;
        }
        if let Some(distance_px) = report.frontier_to_edge_px {
            judged.checks.push((FRONTIER, 1));
            if distance_px == 0 {
                judged.faults.push(Broken::new(
                    FRONTIER,
                    agent,
                    json!({ "to_edge_px": distance_px }),
                ));
            }
        }
        let seen = Seen {
            incarnation: report.incarnation,
            since: truth.step,
            is_cleaner: report.claims.is_some(),
            has_frontier: report.frontier_px > 0,
            is_lost: report.is_lost,
            claims: report.claims.clone(),
        };
        self.waiting_for(truth).reports.insert(agent, seen);
        judged
    }

    fn close(&mut self, truth: &Truth<'_>, is_alive: &[bool]) -> Judged {
        self.waiting_for(truth).is_alive = is_alive.to_vec();
        let mut judged = Judged::default();
        while self.is_complete() {
            self.judge_oldest(&mut judged);
        }
        judged
    }

    fn fleet(&self) -> Values {
        let contaminated_m2 = self.contamination.contaminated_m2_in(&self.connected);
        let cleaners = self.last.values().filter(|seen| seen.is_cleaner).count();
        let mut values = vec![
            ("cleared_pct", Some(self.share_pct(self.first_m2.iter().sum()))),
            ("contaminated_pct", Some(self.share_pct(contaminated_m2))),
            ("is_cleared", Some(f64::from(u8::from(contaminated_m2 == 0.0)))),
            ("cleaners", Some(cleaners as f64)),
            ("cleaners_max", Some(self.cleaners_max as f64)),
        ];
        values.extend(self.search_numbers.iter().copied());
        values
    }

    fn agent(&self, agent: AgentId) -> Values {
        let area_m2 = self.first_m2.get(usize::from(agent.0));
        vec![("cleared_by_uav_pct", area_m2.map(|area_m2| self.share_pct(*area_m2)))]
    }
}
