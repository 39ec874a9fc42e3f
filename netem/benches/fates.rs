//! Fates per second on one core: `cargo bench -p csat-netem`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use csat_netem::config::{ChannelConfig, DelayConfig, LossConfig, NetemConfig};
use csat_netem::fate::Sent;
use csat_netem::link::Links;
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::SimTime;
use std::sync::Arc;

const MESSAGES: u64 = 10_000;
const AGENTS: u16 = 4;

fn sent(sequence: u64, dst: u16) -> Sent {
    Sent {
        src: AgentId(0),
        dst: AgentId(dst),
        incarnation: Incarnation(0),
        channel: ChannelId(0),
        sequence,
        time: SimTime(sequence * 1000),
        bytes: 400,
        src_p_world: [0.0, 0.0, 50.0],
        dst_p_world: [30.0, 40.0, 50.0],
    }
}

fn channels() -> Vec<(&'static str, ChannelConfig)> {
    let bursts = LossConfig::GilbertElliott { p: 0.05, r: 0.25, h: 0.1, k: 0.99 };
    let pareto = |correlation| DelayConfig::Pareto { mean_s: 0.2, shape: 3.0, correlation };
    let bursty = ChannelConfig { loss: bursts, delay: pareto(0.0), ..Default::default() };
    let everything = ChannelConfig {
        range_m: 100.0,
        corruption: 0.01,
        duplication: 0.01,
        delay: pareto(0.5),
        ..bursty.clone()
    };
    vec![
        ("perfect", ChannelConfig::default()),
        ("gilbert-elliott and pareto", bursty),
        ("everything", everything),
    ]
}

fn fates(c: &mut Criterion) {
    for (name, radio) in channels() {
        let config = NetemConfig { radio, ..Default::default() };
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(MESSAGES * u64::from(AGENTS - 1)));
        let mut next = 0;
        let mut links = Links::new(&config, 1, None);
        group.bench_function("decided", |b| {
            b.iter(|| {
                for sequence in next..next + MESSAGES {
                    for dst in 1..AGENTS {
                        std::hint::black_box(links.fate(&sent(sequence, dst)));
                    }
                }
                next += MESSAGES;
            });
        });
        let mut next = 0;
        let bytes: Arc<[u8]> = Arc::from([0; 400]);
        let mut links = Links::new(&config, 1, None);
        group.bench_function("sent and received", |b| {
            b.iter(|| {
                for sequence in next..next + MESSAGES {
                    for dst in 1..AGENTS {
                        links.send(&sent(sequence, dst), bytes.clone());
                    }
                    let now = SimTime(sequence * 1000);
                    while let Some(arrival) = links.receive(now) {
                        std::hint::black_box(arrival);
                    }
                }
                next += MESSAGES;
            });
        });
        group.finish();
    }
}

criterion_group!(benches, fates);
criterion_main!(benches);
