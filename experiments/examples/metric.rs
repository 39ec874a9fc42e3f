//! A number of one's own about a mission, without a change to csat, as docs/extending.md explains it:
//! how far apart the fleet flies.

use csat_experiments::flight::{self, Audience, Moment, RunOptions};
use csat_experiments::record::{RecordError, RecordOptions, Recorder};
use csat_experiments::run_folder::Destination;
use csat_experiments::scenario::{self, Request};
use csat_experiments::set_membership::SetMembership;
use csat_mission::mission::Detail;
use csat_proto::time::Step;

/// The greatest distance between two UAVs, metres, by step.
#[derive(Default)]
struct Spread(Vec<f64>);

impl Audience<SetMembership> for Spread {
    /// Maps are not needed: each agent tells what the monitor needs, and no more.
    fn wants(&mut self, _: Step) -> Detail {
        Detail::Brief
    }

    fn see(&mut self, moment: &Moment<'_, SetMembership>) -> Result<(), RecordError> {
        let pairs = moment.rows.iter().flat_map(|a| moment.rows.iter().map(move |b| (a, b)));
        let apart = pairs.map(|(a, b)| [0, 1].map(|axis| a.p_world[axis] - b.p_world[axis]));
        let distances_m = apart.map(|[east, north]| east.hypot(north));
        self.0.push(distances_m.fold(0.0, f64::max));
        Ok(())
    }
}

fn main() -> Result<(), RecordError> {
    let sets = ["run.duration_s=10".to_owned()];
    let request = Request { scenario: Some("city"), sets: &sets, seed: Some(1) };
    let loaded = scenario::load(request).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let folder = std::env::temp_dir().join(format!("csat-metric-{}", std::process::id()));
    let destination = Destination::Numbered(folder.join("city"));
    let mut recorder = Recorder::create(&loaded, &RecordOptions { destination, quiet: true })?;
    let mut spread = Spread::default();
    let outcome = flight::run(loaded, &RunOptions::default(), &mut recorder, &mut spread)?;
    let finished = recorder.finish(outcome)?;
    let farthest_m = spread.0.iter().copied().fold(0.0, f64::max);
    println!("{}: at most {farthest_m:.1} m apart", finished.folder.display());
    Ok(())
}
