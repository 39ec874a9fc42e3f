//! `str5`: what it costs a UAV to fly out of reach of the others' radios.
//!
//! Ground that another UAV has seen and not told stays unexplored to this one, and ground that it plans to
//! look at is searched twice. So contact is worth ground: at each block a candidate pays for the way that is
//! missing to every group of other UAVs, as far as their plans are known. The groups are the connected
//! components of the others, because messages are passed on. A UAV that flies away can be worth its price,
//! for instance to look at ground that has grown for long.

use csat_proto::camera::Pose;

use crate::config::{AgentConfig, Criterion};

/// The cost of lost contact with the UAVs that are known to be somewhere.
#[derive(Debug, Clone)]
pub(super) struct Connectivity {
    /// Up to this distance UAVs are in contact, metres.
    reach_m: f64,
    /// The cost of a metre beyond it, cells.
    price: f64,
    /// Per block, the groups of the others.
    groups: Vec<Vec<Vec<[f64; 3]>>>,
}

/// No cost is higher, cells: more than any region has.
const MOST: f64 = 1e9;

impl Connectivity {
    /// The contact that `str5` keeps on a grid of that many `cells`; `None` for the other criteria, and
    /// where the radios reach everywhere.
    pub(super) fn new(config: &AgentConfig, cells: usize) -> Option<Self> {
        let guidance = &config.guidance;
        if guidance.criterion != Criterion::Str5 || config.radio_range_m == f64::INFINITY {
            return None;
        }
        let block_m = config.fleet.speed_m_s * guidance.period_s;
        Some(Self {
            reach_m: guidance.str5.reach * config.radio_range_m,
            price: guidance.str5.apart * cells as f64 / block_m,
            groups: Vec::new(),
        })
    }

    /// Begins a decision, given the poses of each other UAV at the ends of the blocks.
    pub(super) fn load(&mut self, others: &[Vec<Pose>], blocks: usize) {
        let at = |block: usize| others.iter().filter_map(move |plan| plan.get(block));
        self.groups = (0..blocks)
            .map(|block| self.groups_of(at(block).map(|pose| pose.p_world).collect()))
            .collect();
    }

    /// The connected components of positions, `world`, metres.
    fn groups_of(&self, positions: Vec<[f64; 3]>) -> Vec<Vec<[f64; 3]>> {
        let mut groups: Vec<Vec<[f64; 3]>> = Vec::new();
        for position in positions {
            let (near, mut apart): (Vec<_>, Vec<_>) = std::mem::take(&mut groups)
                .into_iter()
                .partition(|group| gap_m(group, position) <= self.reach_m);
            apart.push(near.into_iter().flatten().chain([position]).collect());
            groups = apart;
        }
        groups
    }

    /// The cost of being at a position at the end of a block, cells.
    pub(super) fn cost(&self, block: usize, position: [f64; 3]) -> i64 {
        let missing_m = |group: &Vec<[f64; 3]>| (gap_m(group, position) - self.reach_m).max(0.0);
        let missing_m: f64 = self.groups[block].iter().map(missing_m).sum();
        (missing_m * self.price).min(MOST) as i64
    }
}

/// The distance of a position to the nearest one of a group, metres.
fn gap_m(group: &[[f64; 3]], [x, y, z]: [f64; 3]) -> f64 {
    let squares =
        group.iter().map(|at| (at[0] - x).powi(2) + (at[1] - y).powi(2) + (at[2] - z).powi(2));
    squares.fold(f64::INFINITY, f64::min).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Str5Config;
    use crate::guidance::tests::default_config;

    fn connectivity(range_m: f64) -> Connectivity {
        let mut config = default_config();
        config.guidance.criterion = Criterion::Str5;
        config.radio_range_m = range_m;
        config.guidance.str5 = Str5Config { reach: 0.85, apart: 0.05 };
        Connectivity::new(&config, 10_000).unwrap()
    }

    fn plan(x: f64) -> Vec<Pose> {
        vec![Pose::level([x, 0.0, 50.0], 0.0)]
    }

    /// Reach 85 m; a block is 15 m, and each missing block costs 500 of 10 000 cells.
    #[test]
    fn a_uav_pays_for_the_way_to_every_group() {
        let mut links = connectivity(100.0);
        links.load(&[plan(0.0), plan(160.0), plan(80.0), plan(400.0)], 1);
        assert_eq!(links.groups[0].len(), 2, "the first three pass messages on");
        let cost = |x: f64| links.cost(0, [x, 0.0, 50.0]);
        // In reach of one group, 400 - 85 - 245 = 70 m short of the other.
        assert_eq!(cost(245.0), 2333);
        // In reach of none: 30 and 40 m short.
        assert_eq!(cost(275.0), 2333);
        assert_eq!(cost(400.0), 5166);
        links.load(&[plan(0.0), plan(160.0)], 1);
        assert_eq!(
            links.cost(0, [80.0, 0.0, 50.0]),
            0,
            "a relay between two is in contact with both"
        );
        assert_eq!(links.cost(0, [80.0, 0.0, 90.0]), 296, "height counts");
        links.load(&[], 1);
        assert_eq!(links.cost(0, [1e3, 0.0, 50.0]), 0, "nobody is known to be anywhere");
    }

    #[test]
    fn only_str5_with_a_range_keeps_contact() {
        let mut config = default_config();
        config.radio_range_m = 100.0;
        for criterion in [Criterion::Str3, Criterion::Str4] {
            config.guidance.criterion = criterion;
            assert!(Connectivity::new(&config, 1).is_none());
        }
        config.guidance.criterion = Criterion::Str5;
        assert!(Connectivity::new(&config, 1).is_some());
        config.radio_range_m = f64::INFINITY;
        assert!(Connectivity::new(&config, 1).is_none());
    }
}
