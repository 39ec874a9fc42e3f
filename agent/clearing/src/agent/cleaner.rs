//! A cleaner: its masks from frame to frame, what it asks of its followers, and how an agent becomes one.

use csat_proto::command::Command;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use super::duty::State;
use super::{ClearingAgent, Event};
use crate::bitmap::{Bitmap, Rect};
use crate::config::Rules;
use crate::exchange::message::{Duty, Request};
use crate::exchange::validate::Received;
use crate::formation::{Place, Roster, odd_tails};
use crate::frontier::{Run, runs};
use crate::giving::decide;
use crate::masks::{Masks, Sight};
use crate::motion::{Direction, STAY};
use crate::mutant::{Mutant, is_on};

/// Cleaners that did not help each other for this time meet anew, seconds.
const MEETING_S: f64 = 10.0;
/// A cleaner without frontier stays where it is for this time, and says what is cleared there, seconds.
pub const LINGER_S: f64 = 2.0;
/// Room around a frontier that is taken over, beyond the errors of placing it, pixels.
const TAKEN_PX: u16 = 4;

/// What a cleaner knows and plans.
#[derive(Debug, Clone)]
pub struct Cleaner {
    /// What it knows of the road in its image.
    pub masks: Masks,
    /// The sub-frontiers.
    pub runs: Vec<Run>,
    /// Which of them it would give away.
    pub give: Vec<usize>,
    /// Who follows.
    pub roster: Roster,
    /// Where it moves, or moved last.
    pub heading: Direction,
    /// From whom it took its frontier over.
    pub parent: Option<AgentId>,
    /// Since when.
    pub since: Step,
    /// Whom it asks to take what over.
    pub requests: Vec<Request>,
    /// Since when it cannot move on.
    pub waits_since: Option<Step>,
    /// Where it waits, in the frame of its odometry, metres.
    anchor_m: [f64; 2],
    /// Whether it cannot move on, and nobody comes.
    pub is_stalled: bool,
    /// Since when its frontier is empty.
    done_since: Option<Step>,
    /// When the last help of another cleaner came, by cleaner.
    met: std::collections::BTreeMap<AgentId, Step>,
    /// The first offset of each other cleaner, for [`Mutant::StaleOffset`].
    stale_m: std::collections::BTreeMap<AgentId, [f64; 2]>,
}

impl Cleaner {
    /// Whether others wait for its mask: because it just became a cleaner, or asks them, or will soon be none.
    pub fn is_awaited(&self, now: Step, linger: u32) -> bool {
        let is_new = now.0.saturating_sub(self.since.0) <= linger;
        is_new || self.done_since.is_some() || !self.requests.is_empty()
    }

    fn new(masks: Masks, parent: Option<AgentId>, since: Step, roster: Roster) -> Self {
        Self {
            masks,
            runs: Vec::new(),
            give: Vec::new(),
            roster,
            heading: STAY,
            parent,
            since,
            requests: Vec::new(),
            waits_since: None,
            anchor_m: [0.0; 2],
            is_stalled: false,
            done_since: None,
            met: Default::default(),
            stale_m: Default::default(),
        }
    }
}

impl ClearingAgent {
    /// Takes a frame in: the masks of a cleaner and of a wing advance.
    pub(super) fn look(&mut self, frame: &Frame) {
        let moved = self.registration.place(self.step, &self.pose, self.commanded_m);
        self.commanded_m = [0.0; 2];
        self.claims = self.nothing.clone();
        let is_first = self.config.id == AgentId(0)
            && self.config.incarnation == Incarnation(0)
            && self.counters.calls == 0
            && matches!(self.state, State::Helper { .. });
        if moved.is_lost {
            self.scout = None;
        }
        if !is_first && !self.is_cleaner() && !self.is_scout() {
            self.scout = None;
            return;
        }
        let seen = self.sight.road(&frame.labels);
        if let State::Cleaner(cleaner) = &mut self.state {
            let is_held = cleaner.masks.advance(&self.sight, moved, &seen) && !moved.is_lost;
            cleaner.masks.grow(&self.sight);
            // The rules of the paper do not know when they lose a frontier.
            if !is_held && self.sight.rules == Rules::Acknowledged {
                self.fleet.lose(self.config.id);
            }
        } else if is_first {
            self.start(seen);
        } else if let Some(scout) = &mut self.scout {
            // A scout has no frontier to hold.
            let _ = scout.advance(&self.sight, moved, &seen);
        } else {
            self.registration.restart();
            self.scout = Some(Masks::new(&self.sight, seen));
        }
    }

    /// Whether it may soon be asked to take a frontier over. Then it has to know what is cleared around it, or it
    /// would guard that against what is cleared as well.
    fn is_scout(&self) -> bool {
        matches!(self.state, State::Follower { place: Some(Place::Wing(_)), .. })
    }

    /// (8): what is connected with the start line is cleared.
    fn start(&mut self, seen: Bitmap) {
        let mut masks = Masks::new(&self.sight, seen);
        masks.begin(&self.sight, &self.start_line());
        self.registration.restart();
        let others = (1..self.config.fleet.count).map(AgentId);
        let cleaner = Cleaner::new(masks, None, self.step, Roster::of(others));
        self.enter(State::Cleaner(Box::new(cleaner)));
    }

    /// The pixels of the start line.
    fn start_line(&self) -> Bitmap {
        let mut line = self.sight.nothing();
        let half = f64::from(self.sight.size) / 2.0;
        let [from, to] = self.config.start_line_m;
        let pixels = |metres: f64| metres / self.config.pixel_m();
        let count = 2 * u32::from(self.sight.size);
        for index in 0..=count {
            let share = f64::from(index) / f64::from(count);
            let at = |axis: usize| pixels(from[axis] + share * (to[axis] - from[axis]));
            let [row, column] = [half - at(1), half + at(0)].map(f64::floor);
            let inside = 0.0..f64::from(self.sight.size);
            if inside.contains(&row) && inside.contains(&column) {
                line.set(row as u16, column as u16);
            }
        }
        line.dilated(self.sight.radii.out)
    }

    /// A cleaner learns what another one knows to be cleared.
    pub(super) fn learn(&mut self, got: &Received) {
        let Some(offset_m) = got.offset_m else { return };
        let State::Cleaner(cleaner) = &mut self.state else {
            let by = self.registration.placement(offset_m);
            if let (Some(scout), Some(safe)) = (&mut self.scout, &got.safe) {
                scout.learn(&self.sight, &safe.shifted(by));
            }
            return;
        };
        let mut placed_m = offset_m;
        if is_on(Mutant::StaleOffset) {
            placed_m = *cleaner.stale_m.entry(got.from).or_insert(offset_m);
        }
        let by = self.registration.placement(placed_m);
        let is_by_overlap = self.sight.rules == Rules::Paper || is_on(Mutant::DeletedUnseen);
        let given_up = if is_by_overlap {
            let image = Bitmap::inside(self.sight.size, self.sight.size, self.sight.margin);
            cleaner.masks.learn(&self.sight, &image.shifted(by))
        } else if let Some(safe) = &got.safe {
            cleaner.masks.learn(&self.sight, &safe.shifted(by))
        } else {
            0
        };
        if given_up > 0 {
            let met = cleaner.met.insert(got.from, self.step);
            let parent = got.message.formation.as_ref().and_then(|formation| formation.parent);
            let is_own = parent == Some(self.config.id) || cleaner.parent == Some(got.from);
            let meeting = self.config.steps(MEETING_S);
            let is_new = met.is_none_or(|met| self.step.0 - met.0 > meeting);
            if is_new && !is_own {
                self.counters.encounters += 1;
                self.events.push_back(Event::Encounter { step: self.step, with: got.from });
            }
        }
    }

    /// A follower takes over what its leader asks it to, if that is well inside its own image.
    pub(super) fn consider_requests(&mut self, got: &Received) {
        let (Some((leader, request)), Some(scout)) = (self.request(), &self.scout) else { return };
        let Some(offset_m) = got.offset_m.filter(|_| got.safe.is_some()) else { return };
        if leader != got.from {
            return;
        }
        let by = self.registration.placement(offset_m);
        let Some(rect) = self.taken(&request.rect(), by) else { return };
        let seeds = scout.seeds(&self.sight, &rect);
        if seeds.is_empty() {
            return;
        }
        let Some(mut masks) = self.scout.take() else { return };
        masks.begin(&self.sight, &seeds);
        let formation = got.message.formation.as_ref();
        let tails = formation.into_iter().flat_map(odd_tails).filter(|id| *id != self.config.id);
        let roster = Roster::of(tails);
        self.counters.splits += 1;
        let cleaner = Cleaner::new(masks, Some(leader), self.step, roster);
        self.enter(State::Cleaner(Box::new(cleaner)));
    }

    /// A rectangle of another image, widened and placed in the own one; `None` unless it lies within M.
    fn taken(&self, rect: &Rect, by: [i32; 2]) -> Option<Rect> {
        let wide = i32::from(self.sight.radii.rho + TAKEN_PX);
        let last = i32::from(self.sight.size - 1 - self.sight.margin);
        let first = i32::from(self.sight.margin);
        let place = |[from, to]: [u16; 2], by: i32| {
            let placed = [i32::from(from) + by - wide, i32::from(to) + by + wide];
            let is_inside = placed[0] >= first && placed[1] <= last;
            is_inside.then(|| placed.map(|at| at as u16))
        };
        Some(Rect { rows: place(rect.rows, by[0])?, columns: place(rect.columns, by[1])? })
    }

    /// The end of a step: what to do next.
    pub(super) fn decide(&mut self) {
        let missing = self.config.steps(self.config.clearing.lost_after_s);
        self.fleet.miss(self.config.id, self.first, self.step, missing);
        if let Some(cleaner) = self.fleet.take_noticed() {
            self.events.push_back(Event::Lost { step: self.step, cleaner });
        }
        self.update_follower();
        self.update_helper();
        self.update_cleaner();
        if !matches!(self.state, State::Station | State::Cleaner(_)) {
            self.commanded_m = self.fly();
        }
        if !matches!(self.state, State::Station) {
            self.commands.push_back(Command::Displace { by_m: self.commanded_m });
        }
    }

    fn update_cleaner(&mut self) {
        if !self.is_cleaner() {
            return;
        }
        let state = std::mem::replace(&mut self.state, State::Helper { target: None });
        let State::Cleaner(mut cleaner) = state else { return };
        cleaner.runs = runs(cleaner.masks.frontier(), self.sight.margin);
        if !self.has_lost() {
            self.claims = cleaner.masks.claims(&self.sight);
        }
        self.update_roster(&mut cleaner);
        if cleaner.runs.is_empty() {
            cleaner.done_since.get_or_insert(self.step);
            cleaner.requests.clear();
        } else {
            cleaner.done_since = None;
            self.plan(&mut cleaner);
        }
        let linger = self.config.steps(LINGER_S);
        let is_over = cleaner.done_since.is_some_and(|since| self.step.0 - since.0 >= linger);
        self.state = State::Cleaner(cleaner);
        if is_over {
            self.enter(State::Helper { target: None });
        }
    }

    /// Followers are those that say so.
    fn update_roster(&self, cleaner: &mut Cleaner) {
        let range = self.range_steps();
        let is_new = self.step.0 - cleaner.since.0 <= range;
        for (id, peer) in self.fleet.iter() {
            let follows =
                peer.beat.duty == Duty::Follower && peer.beat.leader == Some(self.config.id);
            if follows && peer.is_near(self.step, range) {
                cleaner.roster.add(id);
            }
        }
        cleaner.roster.retain(|id| {
            let follows = |duty, leader| duty == Duty::Follower && leader == Some(self.config.id);
            match self.fleet.get(id) {
                // Those that it took along may not know it yet.
                Some(peer) if is_new => {
                    peer.beat.duty == Duty::Follower
                        && (peer.beat.leader == cleaner.parent
                            || peer.beat.leader == Some(self.config.id))
                }
                Some(peer) => {
                    follows(peer.beat.duty, peer.beat.leader) && peer.is_near(self.step, range)
                }
                None => is_new,
            }
        });
    }

    fn plan(&mut self, cleaner: &mut Cleaner) {
        let decision = decide(&self.mover, self.config.clearing.give, &cleaner.runs);
        let direction = match decision.advance {
            Some(direction) => {
                cleaner.heading = direction;
                cleaner.waits_since = None;
                direction
            }
            None => self.hold(cleaner),
        };
        let step_m = self.config.clearing.step_m;
        self.commanded_m = direction.map(|axis| f64::from(axis) * step_m);
        cleaner.give = decision.give;
        self.ask(cleaner);
        let waited = cleaner.waits_since.map_or(0, |since| self.step.0 - since.0);
        let is_stalled = waited > self.config.steps(self.config.clearing.patience_s)
            && cleaner.roster.is_empty()
            && !self.is_help_coming();
        if is_stalled != cleaner.is_stalled {
            cleaner.is_stalled = is_stalled;
            let runs = cleaner.give.len() as u32;
            self.events.push_back(Event::Stalled { step: self.step, is_stalled, runs });
        }
    }

    /// Where to move while waiting: back to where it began to wait, unless the frontier is too near to an edge there.
    fn hold(&self, cleaner: &mut Cleaner) -> Direction {
        let place_m = self.place_m();
        if cleaner.waits_since.is_none() {
            (cleaner.waits_since, cleaner.anchor_m) = (Some(self.step), place_m);
        }
        let step_m = self.config.clearing.step_m;
        let back = [0, 1].map(|axis| (cleaner.anchor_m[axis] - place_m[axis]) / step_m);
        let direction = self.mover.hold(&cleaner.runs, back);
        let Some(away) = direction.away else { return direction.way };
        cleaner.anchor_m =
            [0, 1].map(|axis| if away[axis] == 0 { cleaner.anchor_m[axis] } else { place_m[axis] });
        direction.way
    }

    fn is_help_coming(&self) -> bool {
        let heard = self.config.steps(self.config.clearing.lost_after_s);
        self.fleet.iter().any(|(_, peer)| {
            peer.beat.duty == Duty::Helper
                && peer.beat.leader == Some(self.config.id)
                && self.step.0.saturating_sub(peer.heard.0) <= heard
        })
    }

    /// Asks the nearest wings to take runs over.
    fn ask(&mut self, cleaner: &mut Cleaner) {
        cleaner.requests.clear();
        let mut wings: Vec<AgentId> = cleaner.roster.wings.iter().flatten().copied().collect();
        for index in &cleaner.give {
            let Some(run) = cleaner.runs.get(*index) else { continue };
            let mut request =
                Request { to: self.config.id, rows: run.rect.rows, columns: run.rect.columns };
            let to_m = self.middle_m(&request);
            let Some(nearest) = (0..wings.len()).min_by(|a, b| {
                self.distance_m(wings[*a], to_m).total_cmp(&self.distance_m(wings[*b], to_m))
            }) else {
                return;
            };
            request.to = wings.remove(nearest);
            self.fleet.ask(request.to);
            cleaner.requests.push(request);
        }
        if self.sight.rules == Rules::Paper || is_on(Mutant::GivenAtOnce) {
            give_at_once(cleaner, &self.sight);
        }
    }

    /// How far another agent is from a point, given from here, metres.
    fn distance_m(&self, id: AgentId, to_m: [f64; 2]) -> f64 {
        let near = self.fleet.get(id).and_then(|peer| peer.near);
        let place = self.place_m();
        near.map_or(f64::INFINITY, |near| {
            let away = [0, 1].map(|axis| near.place_m[axis] - place[axis] - to_m[axis]);
            away[0].hypot(away[1])
        })
    }
}

/// The paper's split: what others are asked to take over is theirs at once.
fn give_at_once(cleaner: &mut Cleaner, sight: &Sight) {
    for request in &cleaner.requests {
        let mut given = sight.nothing();
        given.fill(&request.rect());
        cleaner.masks.learn(sight, &given.dilated(3));
    }
}
