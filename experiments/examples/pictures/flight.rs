//! A flight with perfect links, and what the pictures need of it.

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::AgentConfig;
use csat_agent::estimate::state::Knowledge;
use csat_agent::sense::{Measured, Sensor};
use csat_experiments::rounding;
use csat_experiments::scenario::{self, Loaded, Request};
use csat_experiments::set_membership::SetMembership;
use csat_experiments::view::View;
use csat_mission::engine::Engine;
use csat_mission::mission::{Detail, Mission};
use csat_mission::picture;
use csat_proto::camera::Pose;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, TargetId};
use csat_proto::region::Region;
use csat_proto::time::Step;
use csat_world::camera::Renderer;

/// What the monitor saw of one car at one step.
#[derive(Debug, Clone, Copy)]
pub struct Check {
    /// Whether agent 0 has identified the car.
    pub is_identified: bool,
    /// Whether the car is in the set that must contain it.
    pub is_contained: bool,
    /// Area of that set, m².
    pub area_m2: f64,
}

/// A step of a flight.
pub struct Recorded {
    /// The town, the cars, and what agent 0 knows.
    pub view: View,
    /// T, seconds.
    pub period_s: f64,
    /// The agents after the step.
    pub agents: Vec<SetMembershipAgent>,
    /// Which of them knows a car best: whose frame is drawn.
    pub viewer: usize,
    /// Its frame.
    pub frame: Frame,
    /// All that this frame proves, as if it were the first one.
    pub measured: Measured,
    /// What the viewer knew a step before.
    pub before: Knowledge,
    /// The monitor's question and answer at each step, for each car.
    pub checks: Vec<Vec<Check>>,
}

impl Recorded {
    /// Flies `city`, seed 1: everything is of `time_s`, a multiple of T_MPC, but for the checks, which
    /// go on until `until_s`.
    pub fn fly(time_s: f64, until_s: f64) -> Self {
        let loaded = load(&[]);
        let mut view = View::of_town(&loaded);
        let Loaded { scenario, world, .. } = loaded;
        let mission = SetMembership::new(&scenario);
        let mut renderer = Renderer::new(scenario.camera);
        let mut engine = Engine::new(mission.clone(), world, &scenario.netem, scenario.seed);
        let last = (time_s / scenario.run.period_s).round() as u32;
        let mut checks = Vec::new();
        while checks.len() < last as usize {
            engine.step();
            checks.push(check(&engine));
        }
        let before = |agent: &SetMembershipAgent| Knowledge::clone(agent.knowledge());
        let mut before: Vec<Knowledge> = engine.nodes().iter().map(|s| before(&s.agent)).collect();
        let step = engine.step().step;
        checks.push(check(&engine));
        let (scene, poses) = (engine.world().scene(), engine.world().poses());
        let mut look = |(id, pose)| renderer.frame(&scene, pose, step, scenario.seed, AgentId(id));
        let frames = (0..).zip(&poses).map(&mut look);
        let mut agents: Vec<_> = engine.nodes().iter().map(|node| node.agent.clone()).collect();
        let sense = |(index, frame): (usize, Frame)| {
            let measured = Sensor::new(agents[index].config()).measure(&frame);
            (index, frame, measured)
        };
        let views = frames.enumerate().map(sense);
        let worth = |(_, _, measured): &(usize, Frame, Measured)| worth_seeing(measured);
        let best = views.max_by(|a, b| worth(a).total_cmp(&worth(b)));
        let (viewer, frame, measured) = best.expect("there are UAVs");
        view.time_s = time_s;
        view.targets = engine.world().targets().iter().map(|t| vec![t.location]).collect();
        let report = mission.report(&mut agents[viewer], &Pose::default(), Detail::Full);
        view.agents = vec![mission.picture(&report)];
        let until = (until_s / scenario.run.period_s).round() as usize;
        while checks.len() <= until {
            engine.step();
            checks.push(check(&engine));
        }
        let before = before.swap_remove(viewer);
        let period_s = scenario.run.period_s;
        Self { view, period_s, agents, viewer, frame, measured, before, checks }
    }

    /// The agent whose frame is drawn.
    pub fn agent(&self) -> &SetMembershipAgent {
        &self.agents[self.viewer]
    }

    /// Its configuration.
    pub fn config(&self) -> &AgentConfig {
        self.agent().config()
    }

    /// The pose of its frame.
    pub fn pose(&self) -> &Pose {
        &self.frame.pose
    }

    /// The last step.
    pub fn step(&self) -> Step {
        self.agent().knowledge().step
    }

    /// Its camera's footprint, metres.
    pub fn footprint(&self) -> Vec<[f64; 2]> {
        self.config().camera.at(self.pose()).footprint()
    }
}

/// `city`, seed 1, with more settings.
pub fn load(sets: &[&str]) -> Loaded {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let request = Request { scenario: Some("city"), sets: &sets, seed: Some(1) };
    scenario::load(request).unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// A region in metres, for drawing.
pub fn shapes(region: &Region) -> picture::Shapes {
    rounding::shapes(region)
}

fn check(engine: &Engine<SetMembership>) -> Vec<Check> {
    let knowledge = engine.nodes()[0].agent.knowledge();
    let targets = engine.world().targets().iter();
    targets
        .map(|truth| {
            let set = knowledge.set_of(truth.id).region();
            Check {
                is_identified: knowledge.targets.contains_key(&truth.id),
                is_contained: set.distance_m(truth.location) <= 1e-3,
                area_m2: set.area_m2(),
            }
        })
        .collect()
}

/// A frame that knows a car well makes the better picture: the area where no other car can be, m².
fn worth_seeing(measured: &Measured) -> f64 {
    let areas = measured.targets.iter().map(|seen| seen.exclusion.region().area_m2());
    areas.fold(0.0, f64::max)
}

/// The identified target that the frame shows nearest to the UAV.
pub fn nearest_detection(recorded: &Recorded) -> Option<(TargetId, [f64; 2])> {
    let [x, y, _] = recorded.pose().p_world;
    let seen = recorded.measured.targets.iter();
    let place = |target: &csat_agent::sense::MeasuredTarget| {
        Some((target.target, target.location.region().barycentre()?))
    };
    let far = |p: [f64; 2]| (p[0] - x).hypot(p[1] - y);
    seen.filter_map(place).min_by(|a, b| far(a.1).total_cmp(&far(b.1)))
}
