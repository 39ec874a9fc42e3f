//! How long each stage of an agent-step takes, on moments recorded in the middle of a mission, and a
//! short mission as a whole. `docs/performance.md` says how to run this and what came out.

#[path = "recorded/mod.rs"]
mod recorded;

use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion};
use csat_agent::config::Criterion as Cost;
use csat_agent::estimate::Estimator;
use csat_agent::estimate::evidence::ReceivedFact;
use csat_agent::estimate::state::Knowledge;
use csat_world::camera::Renderer;
use recorded::Moment;

/// The length of the whole mission, seconds.
const MISSION_S: u32 = 30;

fn main() {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(3))
        .sample_size(50)
        .configure_from_args();
    for (name, moment) in ["60s", "150s"].into_iter().zip(recorded::moments(&[60.0, 150.0])) {
        let mut group = criterion.benchmark_group(name);
        world_and_own_frame(&mut group, &moment);
        messages_and_fusion(&mut group, &moment);
        guidance(&mut group, &moment);
        group.finish();
    }
    whole_mission(&mut criterion);
    criterion.final_summary();
}

fn world_and_own_frame(group: &mut BenchmarkGroup<'_, WallTime>, moment: &Moment) {
    let Moment { config, frame, .. } = moment;
    let mut renderer = Renderer::new(config.camera);
    group.bench_function("render", |b| b.iter(|| recorded::stage_render(&mut renderer, moment)));
    group.bench_function("sense", |b| {
        let sensor = || moment.sensor.clone();
        b.iter_batched_ref(sensor, |s| recorded::stage_sense(s, frame), BatchSize::LargeInput);
    });
    group.bench_function("estimate", |b| {
        // An estimator that had done it before would only look up the result.
        let ready = || (Estimator::new(config), moment.before.clone());
        let work = |(estimator, knowledge): &mut (_, _)| {
            recorded::stage_estimate(estimator, knowledge, moment)
        };
        b.iter_batched_ref(ready, work, BatchSize::LargeInput);
    });
}

fn messages_and_fusion(group: &mut BenchmarkGroup<'_, WallTime>, moment: &Moment) {
    let Moment { config, before, corrected, facts, snapshots, .. } = moment;
    group.bench_function("say", |b| {
        let transmitter = || recorded::transmitter(config);
        b.iter_batched_ref(transmitter, |t| recorded::stage_say(t, moment), BatchSize::LargeInput);
    });
    group.bench_function("hear", |b| {
        let receiver = || recorded::receiver(config);
        b.iter_batched_ref(receiver, |r| recorded::stage_hear(r, moment), BatchSize::LargeInput);
    });
    let mut with =
        |name: &str,
         knowledge: &Knowledge,
         heard: &[ReceivedFact],
         work: &dyn Fn(&Estimator, &mut Knowledge, Vec<ReceivedFact>)| {
            group.bench_function(name, |b| {
                let ready = || (Estimator::new(config), knowledge.clone(), heard.to_vec());
                let work = |(estimator, mut knowledge, heard): (Estimator, Knowledge, Vec<_>)| {
                    work(&estimator, &mut knowledge, heard);
                    (estimator, knowledge)
                };
                b.iter_batched(ready, work, BatchSize::LargeInput);
            });
        };
    with("update", before, facts, &|estimator, k, heard| {
        recorded::stage_update(estimator, k, (moment, heard));
    });
    with("update-snapshots", before, snapshots, &|estimator, k, heard| {
        recorded::stage_update_snapshots(estimator, k, (moment, heard));
    });
    with("fuse", corrected, facts, &|estimator, k, heard| {
        recorded::stage_fuse(estimator, k, heard);
    });
    with("fuse-snapshots", corrected, snapshots, &|estimator, k, heard| {
        recorded::stage_fuse_snapshots(estimator, k, heard);
    });
}

fn guidance(group: &mut BenchmarkGroup<'_, WallTime>, moment: &Moment) {
    let planner = |cost| recorded::planner(&moment.config, cost);
    let mut str1 = planner(Cost::Str1);
    group.bench_function("guidance-str1", |b| {
        b.iter(|| recorded::stage_guidance_str1(&mut str1, moment));
    });
    let mut str2 = planner(Cost::Str2);
    group.bench_function("guidance-str2", |b| {
        b.iter(|| recorded::stage_guidance_str2(&mut str2, moment));
    });
    let mut str3 = planner(Cost::Str3);
    group.bench_function("guidance-str3", |b| {
        b.iter(|| recorded::stage_guidance_str3(&mut str3, moment));
    });
    group.bench_function("guidance-decision", |b| {
        b.iter(|| recorded::stage_guidance_decision(&mut str3, moment));
    });
}

fn whole_mission(criterion: &mut Criterion) {
    let runs = tempfile::tempdir().expect("a folder for the runs");
    let mut group = criterion.benchmark_group("mission");
    group.sample_size(10);
    group.bench_function(format!("{MISSION_S}s"), |b| {
        let ready = || recorded::about_to_fly(MISSION_S, runs.path());
        b.iter_batched(ready, recorded::whole_mission, BatchSize::PerIteration);
    });
    group.finish();
}
