use super::*;
use crate::config::{
    DelayConfig, LossConfig, OutageConfig, OutageKind, PartitionConfig, PropagationConfig,
    RateConfig,
};
use crate::fate::tests::sent;
use proptest::prelude::*;

fn links(radio: ChannelConfig, seed: u64) -> Links {
    Links::new(&NetemConfig { radio, ..Default::default() }, seed, None)
}

fn payload() -> Arc<[u8]> {
    Arc::from([0u8; 10])
}

fn outage(agent: u16, from_s: f64, until_s: f64) -> OutageConfig {
    OutageConfig { agent, from_s, until_s, kind: OutageKind::Crash }
}

/// All rules at once, on every link.
fn storm() -> ChannelConfig {
    ChannelConfig {
        range_m: 100.0,
        mtu_bytes: 60,
        corruption: 0.1,
        duplication: 0.2,
        light_delay: true,
        loss: LossConfig::GilbertElliott { p: 0.1, r: 0.3, h: 0.2, k: 0.98 },
        delay: DelayConfig::Pareto { mean_s: 0.4, shape: 2.5, correlation: 0.6 },
        // Over 50 m about one message in nine has a packet error.
        propagation: Some(PropagationConfig {
            tx_power_dbm: -1.0,
            shadowing_sigma_db: 0.2,
            ..Default::default()
        }),
        ..Default::default()
    }
}

#[test]
fn a_perfect_channel_delivers_at_once() {
    let fate = links(ChannelConfig::default(), 1).fate(&sent(0));
    let at_once = Ok(Delivery { at: sent(0).time, corrupted: false });
    assert_eq!(fate, Fate { first: at_once, duplicate: None });
}

#[test]
fn messages_arrive_in_order_and_are_counted() {
    let radio = ChannelConfig {
        loss: LossConfig::Iid { p: 0.5 },
        delay: DelayConfig::Constant { mean_s: 0.25 },
        ..Default::default()
    };
    let mut links = links(radio, 1);
    for sequence in 0..100 {
        links.send(&sent(sequence), payload());
        assert!(links.counters().conserved());
    }
    assert_eq!(links.receive(SimTime::from_seconds(1.2)), None);
    let in_flight = links.counters().in_flight;
    let arrived = std::iter::from_fn(|| links.receive(SimTime::from_seconds(1.25))).count();
    assert_eq!(arrived as u64, in_flight);
    assert!((20..80).contains(&arrived));
    let counters = links.counters();
    assert!(counters.conserved());
    assert_eq!((counters.in_flight, counters.bytes_sent), (0, 1000));
    let (id, link) = links.per_link().next().unwrap();
    assert_eq!(id, (AgentId(0), AgentId(1), ChannelId(0)));
    assert_eq!((link.counts.sent, link.counts.delivered), (100, arrived as u64));
    assert!((link.mean_delay_s().unwrap() - 0.25).abs() < 1e-9);
    assert!((link.mean_distance_m().unwrap() - 50.0).abs() < 1e-9);
}

#[test]
fn a_broadcast_costs_its_bytes_once() {
    let mut links = links(ChannelConfig::default(), 1);
    for sequence in 0..3 {
        for dst in 1..5 {
            links.send(&Sent { dst: AgentId(dst), ..sent(sequence) }, payload());
        }
    }
    // The same number in another incarnation or on another channel is another message.
    links.send(&Sent { incarnation: Incarnation(1), ..sent(0) }, payload());
    links.send(&Sent { channel: ChannelId(1), ..sent(0) }, payload());
    assert_eq!((links.counters().sent, links.counters().bytes_sent), (14, 50));
    assert_eq!(links.counters().dropped, [(Reason::NoChannel, 1)].into());
}

/// The bucket belongs to the sender: a message that one receiver misses took its tokens.
#[test]
fn a_full_queue_loses_a_message_for_all() {
    let rate = RateConfig { bytes_s: 100.0, burst_bytes: 100, queue_bytes: 100 };
    let radio = ChannelConfig { rate, range_m: 60.0, ..Default::default() };
    let mut links = links(radio, 1);
    let far = |i| Sent { dst: AgentId(2), dst_p_world: [500.0, 0.0, 0.0], ..sent(i) };
    let at = |fate: Fate| fate.first.map(|delivery| delivery.at.seconds());
    for (i, expected) in [Ok(1.0), Ok(2.0), Err(Reason::Queue)].into_iter().enumerate() {
        let i = i as u64;
        // The rule of the range comes before that of the queue, whichever receiver is queried first.
        assert_eq!(at(links.fate(&far(i))), Err(Reason::Range));
        assert_eq!(at(links.fate(&sent(i))), expected);
    }
}

#[test]
fn what_is_damaged_arrives_and_is_counted() {
    let radio = ChannelConfig { corruption: 1.0, duplication: 1.0, ..Default::default() };
    let mut links = links(radio, 1);
    links.send(&sent(0), payload());
    let arrivals: Vec<Arrival> = std::iter::from_fn(|| links.receive(sent(0).time)).collect();
    assert_eq!(arrivals.len(), 2);
    assert_eq!(arrivals[0], arrivals[1], "a copy is as damaged as its original");
    assert_eq!(arrivals[0].src_p_world, sent(0).src_p_world, "it comes from where it was sent");
    assert_eq!(arrivals[0].bytes.iter().filter(|&&byte| byte != 0).count(), 1);
    let counters = links.counters();
    assert_eq!((counters.sent, counters.duplicated), (1, 1));
    assert_eq!((counters.delivered, counters.corrupted), (2, 2));
}

/// In another emulator packets in flight are lost when their sender fails.
#[test]
fn in_flight_survives_its_sender_and_later_partitions_but_not_a_dead_receiver() {
    let delay = DelayConfig::Constant { mean_s: 5.0 };
    let apart = PartitionConfig {
        from_s: 2.0,
        until_s: 100.0,
        groups: vec![vec![0], vec![1]],
        one_way: false,
    };
    let config = NetemConfig {
        radio: ChannelConfig { delay, ..Default::default() },
        outage: vec![outage(0, 2.0, 9.0), outage(2, 2.0, 7.0)],
        partition: vec![apart],
        ..Default::default()
    };
    let mut links = Links::new(&config, 1, None);
    let mut fate = |src, dst, time_s| {
        let time = SimTime::from_seconds(time_s);
        let message = Sent { src: AgentId(src), dst: AgentId(dst), time, ..sent(0) };
        links.send(&message, payload()).first.map(|delivery| delivery.at.seconds())
    };
    assert_eq!(fate(0, 1, 1.0), Ok(6.0), "sent before its sender died and the partition began");
    assert_eq!(fate(0, 1, 3.0), Err(Reason::Outage), "the sender is dead");
    assert_eq!(fate(1, 2, 1.0), Err(Reason::Outage), "arrives at 6 s, dead until 7 s");
    assert_eq!(fate(1, 2, 2.5), Ok(7.5), "sent to a dead agent that is alive on arrival");
    assert_eq!(fate(1, 0, 3.0), Err(Reason::Partition), "the reason asked first");
    assert_eq!(fate(0, 1, 9.0), Err(Reason::Partition));
    assert_eq!(links.receive(SimTime::from_seconds(6.0)).unwrap().dst, AgentId(1));
    assert!(links.counters().conserved());
}

/// The first rule gives the reason where several rules would lose the message.
#[test]
fn the_first_rule_names_the_reason() {
    let mut config = NetemConfig {
        radio: ChannelConfig {
            loss: LossConfig::Iid { p: 1.0 },
            rate: RateConfig { bytes_s: 1.0, burst_bytes: 0, queue_bytes: 0 },
            ..Default::default()
        },
        ..Default::default()
    };
    let reason = |config: &NetemConfig| Links::new(config, 1, None).fate(&sent(0)).first;
    assert_eq!(reason(&config), Err(Reason::Loss));
    config.jammer = vec![crate::config::JammerConfig {
        p_m: [0.0; 2],
        radius_m: f64::INFINITY,
        from_s: 0.0,
        until_s: 9.0,
        loss: 1.0,
        channel: None,
    }];
    assert_eq!(reason(&config), Err(Reason::Jamming));
    let deaf = PropagationConfig { tx_power_dbm: -300.0, ..Default::default() };
    config.radio.propagation = Some(deaf);
    assert_eq!(reason(&config), Err(Reason::Propagation));
    config.radio.range_m = 1.0;
    assert_eq!(reason(&config), Err(Reason::Range));
    let groups = vec![vec![0], vec![1]];
    config.partition = vec![PartitionConfig { from_s: 0.0, until_s: 9.0, groups, one_way: true }];
    assert_eq!(reason(&config), Err(Reason::Partition));
    config.outage = vec![outage(0, 0.0, 9.0)];
    assert_eq!(reason(&config), Err(Reason::Outage));
}

/// Another emulator restarts its random numbers whenever a setting changes.
#[test]
fn reconfiguring_every_tick_resets_nothing() {
    let mut still = links(storm(), 5);
    let mut moving = links(storm(), 5);
    for i in 0..2000u64 {
        let radio = ChannelConfig { range_m: 60.0 + (i % 40) as f64, ..storm() };
        moving.reconfigure(&NetemConfig { radio, ..Default::default() });
        assert_eq!(moving.send(&sent(i), payload()), still.send(&sent(i), payload()), "{i}");
        assert_eq!(moving.next_arrival(), still.next_arrival());
    }
    assert_eq!(moving.counters(), still.counters());
    let counters = still.counters();
    let reasons: Vec<Reason> = counters.dropped.keys().copied().collect();
    assert_eq!(reasons, [Reason::Propagation, Reason::Loss], "the storm blows");
    assert!(counters.duplicated > 100 && counters.in_flight > 500, "{counters:?}");
}

#[test]
fn reconfiguring_keeps_queues_and_chains() {
    let rate = |bytes_s| RateConfig { bytes_s, burst_bytes: 0, queue_bytes: 10_000 };
    let with_rate = |bytes_s| ChannelConfig { rate: rate(bytes_s), ..Default::default() };
    let mut queue = links(with_rate(100.0), 1);
    for i in 0..10 {
        queue.fate(&sent(i));
    }
    // 1000 bytes are waiting; they and 100 more now leave ten times as fast.
    queue.reconfigure(&NetemConfig { radio: with_rate(1000.0), ..Default::default() });
    assert_eq!(queue.fate(&sent(10)).first.unwrap().at, SimTime::from_seconds(2.1));

    // A chain whose transitions have probability 0 stays in its state.
    let chain = |p, r| ChannelConfig {
        loss: LossConfig::GilbertElliott { p, r, h: 0.0, k: 1.0 },
        ..Default::default()
    };
    for seed in 0..20 {
        let mut links = links(chain(0.5, 0.5), seed);
        let last = links.fate(&sent(9)).first;
        let frozen = chain(1e-12, 1e-12);
        links.reconfigure(&NetemConfig { radio: frozen, ..Default::default() });
        assert!((10..100).all(|i| links.fate(&sent(i)).first == last));
    }
}

/// A message that waits in a queue needs a radio when it leaves, and a sender that did not crash.
#[test]
fn a_queue_does_not_leave_through_a_radio_that_is_off() {
    let rate = RateConfig { bytes_s: 100.0, burst_bytes: 0, queue_bytes: 1000 };
    let lost = |kind| {
        let radio = ChannelConfig { rate, ..Default::default() };
        let outage = vec![OutageConfig { kind, ..outage(0, 2.5, 4.5) }];
        let config = NetemConfig { radio, outage, ..Default::default() };
        let mut links = Links::new(&config, 1, None);
        // They leave at 2, 3, 4 and 5 s.
        let mut at_once = |i| links.fate(&Sent { time: SimTime(1_000_000), bytes: 100, ..sent(i) });
        [0, 1, 2, 3].map(|i| at_once(i).first == Err(Reason::Outage))
    };
    assert_eq!(lost(OutageKind::Radio), [false, true, true, false]);
    assert_eq!(lost(OutageKind::Crash), [false, true, true, true]);
}

#[test]
fn every_incarnation_has_fates_of_its_own_and_those_of_an_older_one_stay() {
    let mut links = links(storm(), 5);
    let of = |i, incarnation| Sent { incarnation: Incarnation(incarnation), ..sent(i) };
    let first: Vec<Fate> = (0..50).map(|i| links.fate(&of(i, 0))).collect();
    let second: Vec<Fate> = (0..50).map(|i| links.fate(&of(i, 1))).collect();
    assert_ne!(first, second);
    assert_eq!(links.fate(&of(49, 0)), first[49]);
    assert_eq!(links.fate(&of(7, 1)), second[7]);
}

proptest! {
    /// A subset of the messages, in any order, has the fates that all messages have in order.
    #[test]
    fn fates_do_not_depend_on_other_messages(
        seed: u64,
        order in Just((0..60u64).collect::<Vec<_>>()).prop_shuffle(),
        kept in 1..60usize,
    ) {
        let message = |i: u64| Sent { dst: AgentId(1 + (i % 3) as u16), ..sent(i) };
        let mut all = links(storm(), seed);
        let fates: Vec<Fate> = (0..60).map(|i| all.fate(&message(i))).collect();
        let mut some = links(storm(), seed);
        for &i in &order[..kept] {
            prop_assert_eq!(some.fate(&message(i)), fates[i as usize]);
        }
    }

    /// No query in any order panics, and the counters keep their invariant.
    #[test]
    fn any_message_is_judged(
        seed: u64,
        messages in prop::collection::vec(
            (any::<[u16; 3]>(), any::<u8>(), any::<u64>(), any::<u64>(), any::<[f64; 6]>()), 1..20
        ),
    ) {
        let mut links = links(ChannelConfig { rate: RateConfig { bytes_s: 9.0, ..Default::default() }, ..storm() }, seed);
        for ([src, dst, incarnation], channel, sequence, time, p) in messages {
            let message = Sent {
                src: AgentId(src),
                dst: AgentId(dst),
                incarnation: Incarnation(u32::from(incarnation)),
                channel: ChannelId(channel % 2),
                sequence,
                time: SimTime(time),
                bytes: sequence as usize % 5000,
                src_p_world: [p[0], p[1], p[2]],
                dst_p_world: [p[3], p[4], p[5]],
            };
            links.send(&message, payload());
            links.receive(SimTime(time));
            prop_assert!(links.counters().conserved());
            prop_assert!(links.per_link().all(|(_, link)| link.counts.conserved()));
        }
    }
}

fn end(agent: u16, x_m: f64) -> End {
    End { agent: AgentId(agent), p_world: [x_m, 0.0, 50.0] }
}

/// Whether the links from the first end to the second one and back work at a time.
fn both_ways(config: &NetemConfig, ends: [End; 2], time_s: f64) -> [bool; 2] {
    let links = Links::new(config, 1, None);
    let works = |src, dst| links.works(src, dst, SimTime::from_seconds(time_s));
    [works(ends[0], ends[1]), works(ends[1], ends[0])]
}

#[test]
fn range_partition_outage_and_jammers_cut_a_link() {
    let ends = |distance_m| [end(0, 0.0), end(1, distance_m)];
    let range = |range_m| NetemConfig {
        radio: ChannelConfig { range_m, ..Default::default() },
        ..Default::default()
    };
    assert_eq!(both_ways(&NetemConfig::default(), ends(1e6), 1.0), [true, true]);
    assert_eq!(both_ways(&range(100.0), ends(100.0), 1.0), [true, true]);
    assert_eq!(both_ways(&range(100.0), ends(100.1), 1.0), [false, false]);
    let apart = PartitionConfig {
        from_s: 1.0,
        until_s: 2.0,
        groups: vec![vec![0], vec![1]],
        one_way: true,
    };
    let one_way = NetemConfig { partition: vec![apart], ..Default::default() };
    assert_eq!(both_ways(&one_way, ends(1.0), 1.0), [false, true]);
    assert_eq!(both_ways(&one_way, ends(1.0), 2.0), [true, true]);
    let out = NetemConfig { outage: vec![outage(1, 1.0, 2.0)], ..Default::default() };
    assert_eq!(both_ways(&out, ends(1.0), 1.5), [false, false], "it neither sends nor hears");
    assert_eq!(both_ways(&out, ends(1.0), 2.0), [true, true]);
    let jammer = |loss| NetemConfig {
        jammer: vec![crate::config::JammerConfig {
            p_m: [0.0, 0.0],
            radius_m: 10.0,
            from_s: 0.0,
            until_s: f64::INFINITY,
            loss,
            channel: None,
        }],
        ..Default::default()
    };
    assert_eq!(both_ways(&jammer(0.9), ends(50.0), 1.0), [true, false], "the receiver is jammed");
    assert_eq!(both_ways(&jammer(0.4), ends(50.0), 1.0), [true, true]);
}

#[test]
fn a_link_works_over_any_of_its_radios_and_whatever_chance_does() {
    let radio = |range_m| ChannelConfig {
        range_m,
        loss: LossConfig::Iid { p: 1.0 },
        corruption: 1.0,
        ..Default::default()
    };
    let far = [("far".to_owned(), radio(1000.0))].into();
    let config = NetemConfig { radio: radio(10.0), channels: far, ..Default::default() };
    assert_eq!(both_ways(&config, [end(0, 0.0), end(1, 500.0)], 1.0), [true, true]);
    assert_eq!(both_ways(&config, [end(0, 0.0), end(1, 1500.0)], 1.0), [false, false]);
}

/// Asking changes no fate and no count.
#[test]
fn asking_whether_a_link_works_leaves_no_trace() {
    let [mut asked, mut other] = [links(storm(), 5), links(storm(), 5)];
    for sequence in 0..50 {
        let there = End { agent: AgentId(0), p_world: sent(0).src_p_world };
        let here = End { agent: AgentId(1), p_world: sent(0).dst_p_world };
        asked.works(there, here, sent(0).time);
        assert_eq!(asked.send(&sent(sequence), payload()), other.send(&sent(sequence), payload()));
    }
    assert_eq!(asked.counters(), other.counters());
}
