//! Every stage of an agent-step a few times, for `bench/callgrind.sh` to count instructions in.
//!
//! Usage: `stage [SECONDS]`: the moment of the mission to record, a multiple of T_MPC (60). Prints how
//! often it calls each function whose name holds `stage_`; what else it does is not to be counted.

#[path = "../benches/recorded/mod.rs"]
#[expect(dead_code, reason = "whole missions are for the benchmark of time")]
mod recorded;

use std::hint::black_box;

use csat_agent::config::Criterion as Cost;
use csat_agent::estimate::Estimator;
use csat_world::camera::Renderer;
use recorded::Moment;

/// Counts are the same at each call but for the allocator's mood.
const CALLS: usize = 3;

fn main() {
    let time_s = std::env::args().nth(1).map_or(60.0, |s| s.parse().expect("seconds"));
    let moment = recorded::moments(&[time_s]).pop().expect("one moment");
    // Planners and renderers keep scratch memory, which the first call allocates.
    let mut scratch = Scratch::new(&moment);
    for _ in 0..CALLS {
        scratch.call_each(&moment);
    }
    println!("{CALLS}");
}

struct Scratch {
    renderer: Renderer,
    planners: [csat_agent::guidance::Planner; 3],
}

impl Scratch {
    fn new(moment: &Moment) -> Self {
        let planner = |cost| recorded::planner(&moment.config, cost);
        Self {
            renderer: Renderer::new(moment.config.camera),
            planners: [Cost::Str1, Cost::Str2, Cost::Str3].map(planner),
        }
    }

    fn call_each(&mut self, moment: &Moment) {
        let Moment { config, frame, before, corrected, facts, snapshots, .. } = moment;
        black_box(recorded::stage_render(&mut self.renderer, moment));
        black_box(recorded::stage_sense(&mut moment.sensor.clone(), frame));
        recorded::stage_say(&mut recorded::transmitter(config), moment);
        recorded::stage_hear(&mut recorded::receiver(config), moment);
        // An estimator that had done it before would only look up the result.
        let estimator = || Estimator::new(config);
        black_box(recorded::stage_estimate(&estimator(), &mut before.clone(), moment));
        let (heard, knew) = ((moment, facts.clone()), (moment, snapshots.clone()));
        black_box(recorded::stage_update(&estimator(), &mut before.clone(), heard));
        black_box(recorded::stage_update_snapshots(&estimator(), &mut before.clone(), knew));
        let (facts, snapshots) = (facts.clone(), snapshots.clone());
        black_box(recorded::stage_fuse(&estimator(), &mut corrected.clone(), facts));
        black_box(recorded::stage_fuse_snapshots(&estimator(), &mut corrected.clone(), snapshots));
        let [str1, str2, str3] = &mut self.planners;
        black_box(recorded::stage_guidance_str1(str1, moment));
        black_box(recorded::stage_guidance_str2(str2, moment));
        black_box(recorded::stage_guidance_str3(str3, moment));
        black_box(recorded::stage_guidance_decision(str3, moment));
    }
}
