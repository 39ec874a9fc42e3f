//! Links that lose, delay, repeat and reorder messages.

use std::collections::BTreeMap;
use std::sync::Arc;

use csat_proto::ids::ChannelId;
use csat_proto::radio::Reception;
use csat_proto::time::SimTime;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::vehicle::error;
use super::{HBSR, PERIOD_S, Setup};

/// What the links do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkModel {
    pub loss: f64,
    pub max_delay_s: f64,
    pub duplication: f64,
    pub hbsr_range_m: f64,
}

impl Default for LinkModel {
    fn default() -> Self {
        Self { loss: 0.0, max_delay_s: 0.0, duplication: 0.0, hbsr_range_m: 120.0 }
    }
}

struct Sent {
    from: usize,
    to: usize,
    place_m: [f64; 2],
    channel: ChannelId,
    bytes: Arc<[u8]>,
}

pub struct Links {
    model: LinkModel,
    agents: usize,
    offset_error_m: f64,
    random: ChaCha8Rng,
    number: u64,
    /// By step of arrival; shuffled by the draw.
    flying: BTreeMap<(u32, u32, u64), Sent>,
    places: Vec<[f64; 2]>,
    /// Bytes sent.
    pub bytes: BTreeMap<ChannelId, u64>,
}

impl Links {
    pub fn new(setup: &Setup) -> Self {
        Self {
            model: setup.links,
            agents: usize::from(setup.uavs),
            offset_error_m: setup.offset_error_m,
            random: ChaCha8Rng::seed_from_u64(setup.seed ^ 0x5eed),
            number: 0,
            flying: BTreeMap::new(),
            places: Vec::new(),
            bytes: BTreeMap::new(),
        }
    }

    pub fn send(
        &mut self,
        step: u32,
        from: usize,
        place_m: [f64; 2],
        channel: ChannelId,
        bytes: Arc<[u8]>,
    ) {
        *self.bytes.entry(channel).or_default() += bytes.len() as u64;
        for to in (0..self.agents).filter(|to| *to != from) {
            let copies = 1 + u32::from(self.random.random_bool(self.model.duplication));
            for _ in 0..copies {
                if self.random.random_bool(self.model.loss) {
                    continue;
                }
                let delay_s = self.random.random_range(0.0..=self.model.max_delay_s);
                let key = (step + (delay_s / PERIOD_S) as u32, self.random.random(), self.number);
                let bytes = bytes.clone();
                self.flying.insert(key, Sent { from, to, place_m, channel, bytes });
                self.number += 1;
            }
        }
    }

    /// What arrives at a step, in any order. `places` are those of the agents now.
    pub fn arrivals(&mut self, step: u32, places: &[[f64; 2]]) -> Vec<(usize, Reception)> {
        self.places = places.to_vec();
        let later = self.flying.split_off(&(step + 1, 0, 0));
        let due = std::mem::replace(&mut self.flying, later);
        due.into_values().filter_map(|sent| self.receive(step, sent)).collect()
    }

    fn receive(&mut self, step: u32, sent: Sent) -> Option<(usize, Reception)> {
        let Sent { from, to, place_m, channel, bytes } = sent;
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let is_near = channel == HBSR;
        if is_near && apart(self.places[from], self.places[to]) > self.model.hbsr_range_m {
            return None;
        }
        let [east, north] = [0, 1].map(|axis| place_m[axis] - self.places[to][axis]);
        let offset_m = is_near
            .then(|| [east, north].map(|m| m + error(&mut self.random, self.offset_error_m)));
        // The nose points north.
        let bearing = north.atan2(east) - std::f64::consts::FRAC_PI_2;
        let bearing_rad = bearing + error(&mut self.random, 5_f64.to_radians());
        let at = SimTime::from_seconds(f64::from(step) * PERIOD_S);
        Some((to, Reception { channel, at, bearing_rad, offset_m, bytes }))
    }
}
