//! A flight, and the factors of all its frames.

use csat_bayes::config::AgentConfig;
use csat_bayes::factor::Factor;
use csat_mission::engine::Engine;
use csat_mission::measures::Measures;
use csat_mission::mission::Mission;
use csat_proto::time::Step;

use crate::bayes::Bayes;
use crate::bayes::report::Report;
use crate::scenario::Loaded;
use crate::scenario::missions::Offered;

/// A flight.
pub struct Flight {
    /// Its seed.
    pub seed: u64,
    /// What its first agent was told.
    pub config: AgentConfig,
    /// T, seconds.
    pub period_s: f64,
    /// How many steps it has.
    pub steps: u32,
    /// The factors of all frames, in the order of steps and aircraft.
    pub factors: Vec<Factor>,
    /// The true paths of the aircraft, `world`, metres, a place per step.
    pub paths: Vec<Vec<[f64; 2]>>,
    /// Where the target is, `world`, metres.
    pub target: [f64; 2],
    /// Per step, in how many frames the target was detected so far.
    pub detections: Vec<f64>,
}

impl Flight {
    /// Flies the mission of a scenario.
    pub fn fly(loaded: Loaded) -> Self {
        let Loaded { scenario, world, .. } = loaded;
        let mission = Bayes::of(&scenario);
        let target = world.targets().first().map(|target| target.location).unwrap_or_default();
        let uavs = usize::from(scenario.agents.count);
        let mut measures = mission.measures();
        let config = mission.config().clone();
        let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
        let (mut factors, mut detections) = (Vec::new(), Vec::new());
        let mut paths = vec![Vec::new(); uavs];
        for _ in 0..=scenario.steps() {
            let trace = engine.step();
            let reports: Vec<&Report> =
                trace.flown.iter().take(uavs).filter_map(|flown| flown.report.as_ref()).collect();
            for (report, pose) in reports.iter().zip(engine.world().poses()) {
                measures.observe(report, &pose, &[target]);
            }
            factors.extend(reports.iter().filter_map(|report| report.own));
            let values = measures.fleet(&reports, &[target]);
            let value = values.iter().find(|(key, _)| *key == "detections");
            detections.push(value.and_then(|(_, value)| *value).unwrap_or_default());
            for (path, pose) in paths.iter_mut().zip(engine.world().poses()) {
                path.push([pose.p_world[0], pose.p_world[1]]);
            }
        }
        Self {
            seed: scenario.seed,
            config,
            period_s: scenario.run.period_s,
            steps: scenario.steps(),
            factors,
            paths,
            target,
            detections,
        }
    }

    /// When the target was detected first, seconds.
    pub fn detected_s(&self) -> Option<f64> {
        self.detected_at().map(|step| self.time_s(step))
    }

    /// The step at which the target was detected first.
    pub fn detected_at(&self) -> Option<Step> {
        self.nth_detection(1)
    }

    /// The step of the frame that detected the target for the nth time.
    pub fn nth_detection(&self, n: usize) -> Option<Step> {
        let step = self.detections.iter().position(|count| *count >= n as f64)?;
        Some(Step(step as u32))
    }

    /// The time of a step, seconds.
    pub fn time_s(&self, step: Step) -> f64 {
        f64::from(step.0) * self.period_s
    }

    /// The step at a time, or the last one.
    pub fn step_at(&self, time_s: f64) -> Step {
        Step(((time_s / self.period_s).round().max(0.0) as u32).min(self.steps))
    }

    /// The factors of a step.
    pub fn factors_of(&self, step: Step) -> &[Factor] {
        let first = self.factors.partition_point(|factor| factor.step < step);
        let after = self.factors.partition_point(|factor| factor.step <= step);
        &self.factors[first..after]
    }
}
