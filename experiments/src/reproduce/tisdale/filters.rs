//! What each representation of the belief makes of the same frames.

use csat_bayes::belief::Belief;
use csat_bayes::config::{AgentConfig, BeliefConfig, BeliefKind};
use csat_bayes::filter::Filter;
use csat_bayes::search_map::Gaussian;
use csat_proto::time::Step;

use super::flight::Flight;

/// A representation.
pub struct Kind {
    /// How people call it.
    pub name: &'static str,
    /// What it is.
    pub kind: BeliefKind,
    /// Side of its cells, metres.
    pub cell_m: f64,
}

/// The paper's three, and csat's own.
pub const KINDS: [Kind; 4] = [
    Kind { name: "fine grid, 0.67 m", kind: BeliefKind::Grid, cell_m: 0.67 },
    Kind { name: "coarse grid, 12.5 m", kind: BeliefKind::Grid, cell_m: 12.5 },
    Kind { name: "6400 particles", kind: BeliefKind::Particles, cell_m: 12.5 },
    Kind { name: "adaptive cells", kind: BeliefKind::Adaptive, cell_m: 12.5 },
];

/// What a representation knew at the end.
#[derive(Debug, Clone, Copy)]
pub struct Last {
    /// From its mean to the target, metres.
    pub error_m: f64,
    /// The square root of the trace of its covariance, metres.
    pub sigma_m: f64,
    /// The error over the deviation in its direction: the Mahalanobis distance.
    pub distance: f64,
}

/// A representation over time.
pub struct Curves {
    /// By step: the belief's mean and covariance.
    pub estimates: Vec<Gaussian>,
    /// By step: P(D) (8).
    pub cumulative_detection: Vec<f64>,
}

/// A filter of that kind that has seen no frame.
fn start(flight: &Flight, Kind { kind, cell_m, .. }: &Kind) -> Filter {
    let belief = BeliefConfig { kind: *kind, cell_m: *cell_m, ..flight.config.belief };
    Filter::new(&AgentConfig { belief, ..flight.config.clone() })
}

/// Filters a flight and looks at the belief after each step up to `until`.
fn follow(flight: &Flight, kind: &Kind, until: Step, mut see: impl FnMut(Step, &Filter)) {
    let mut filter = start(flight, kind);
    for step in (0..=until.0).map(Step) {
        filter.advance(step);
        filter.apply(flight.factors_of(step).to_vec());
        see(step, &filter);
    }
}

/// The beliefs of a kind at some steps, in their order.
pub fn beliefs_at(flight: &Flight, kind: &Kind, steps: &[Step]) -> Vec<Belief> {
    let Some(last) = steps.iter().max() else { return Vec::new() };
    let mut found: Vec<Option<Belief>> = vec![None; steps.len()];
    follow(flight, kind, *last, |now, filter| {
        for (_, belief) in steps.iter().zip(&mut found).filter(|(step, _)| **step == now) {
            *belief = Some(filter.belief().clone());
        }
    });
    found.into_iter().flatten().collect()
}

/// What a kind knows at the end.
pub fn last(flight: &Flight, kind: &Kind) -> Last {
    let mut estimate = start(flight, kind).belief().gaussian();
    let end = Step(flight.steps);
    follow(flight, kind, end, |step, filter| {
        if step == end {
            estimate = filter.belief().gaussian();
        }
    });
    let [x, y] = [0, 1].map(|axis| flight.target[axis] - estimate.mean[axis]);
    let [xx, xy, yy] = estimate.covariance;
    let determinant = xx * yy - xy * xy;
    let square = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant;
    Last { error_m: x.hypot(y), sigma_m: estimate.sigma_m(), distance: square.max(0.0).sqrt() }
}

/// A kind over time.
pub fn curves(flight: &Flight, kind: &Kind) -> Curves {
    let mut curves = Curves { estimates: Vec::new(), cumulative_detection: Vec::new() };
    follow(flight, kind, Step(flight.steps), |_, filter| {
        curves.estimates.push(filter.belief().gaussian());
        curves.cumulative_detection.push(filter.cumulative_detection());
    });
    curves
}
