//! Ground stations: agents without camera that receive, merge and relay, and whose radio walls
//! obstruct.

use std::collections::BTreeMap;

use csat_agent::config::{Criterion, ExchangeMode};
use csat_experiments::scenario::Scenario;
use csat_experiments::set_membership::SetMembership;
use csat_mission::engine::{Engine, LifeEvent, StepTrace};
use csat_netem::config::{OutageConfig, OutageKind, PartitionConfig, PropagationConfig};
use csat_netem::fate::Reason;
use csat_proto::agent::Agent;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{HeldFacts, Message};
use csat_proto::model::Station;
use csat_tests::missions::{small, with_mode, world_of};
use csat_world::obstacle::Obstacle;
use csat_world::world::WorldError;
use csat_world::world::stations::StationError;

const MODES: [ExchangeMode; 3] =
    [ExchangeMode::Snapshot, ExchangeMode::Facts, ExchangeMode::FactsRepair];

type Mission = Engine<SetMembership>;

fn at(x_m: f64, y_m: f64, z_m: f64) -> Station {
    Station { x_m, y_m, z_m }
}

fn engine(scenario: &Scenario) -> Mission {
    let world = world_of(scenario).expect("a world");
    Engine::new(SetMembership::new(scenario), world, &scenario.netem, scenario.seed)
}

/// One more step, without violations.
fn step(engine: &mut Mission) -> StepTrace<SetMembership> {
    let trace = engine.step();
    assert_eq!(trace.violations, [], "step {}", trace.step);
    trace
}

fn unexplored_m2(engine: &Mission, agent: usize) -> f64 {
    engine.nodes()[agent].agent.knowledge().unexplored.region().area_m2()
}

/// With perfect links a station has the knowledge of the UAVs, to the last bit, and the fleet flies
/// and knows the same as without a station.
#[test]
fn with_perfect_links_a_station_knows_what_the_fleet_knows() {
    for mode in MODES {
        let without = with_mode(small(3, 120.0, 2), mode);
        let with = Scenario { stations: vec![at(-70.0, 0.0, 2.0)], ..without.clone() };
        let (mut without, mut with) = (engine(&without), engine(&with));
        for k in 0..=40 {
            let digests = [&mut without, &mut with].map(|engine| {
                step(engine);
                let digests = engine.nodes().iter().map(|node| node.agent.digest());
                digests.collect::<Vec<u64>>()
            });
            let [fleet, all] = &digests;
            assert_eq!(fleet[..], all[..2], "{mode:?}, step {k}");
            assert_eq!(all[2], all[0], "{mode:?}, step {k}: the station");
        }
        assert!(unexplored_m2(&with, 2) < 0.8 * 120.0 * 120.0);
        assert_eq!(with.nodes()[2].agent.news_age_s(), Some(0.0));
        let rejected: Vec<_> = with.nodes().iter().map(|s| s.agent.rejected().clone()).collect();
        assert_eq!(rejected, vec![BTreeMap::new(); 3], "{mode:?}");
    }
}

#[test]
fn without_exchange_a_station_knows_nothing() {
    let alone = with_mode(small(3, 120.0, 2), ExchangeMode::None);
    let mut engine = engine(&Scenario { stations: vec![at(0.0, -70.0, 2.0)], ..alone });
    for _ in 0..=20 {
        let trace = step(&mut engine);
        assert!(trace.flown.iter().all(|flown| flown.bytes_sent == 0));
    }
    assert_eq!(unexplored_m2(&engine, 2), 120.0 * 120.0);
    assert!(unexplored_m2(&engine, 0) < 120.0 * 120.0);
    assert_eq!(engine.nodes()[2].agent.news_age_s(), Some(10.0));
}

/// Two UAVs 100 m above each other with a range of 95 m, and a station between them in range of both.
fn apart(mode: ExchangeMode, stations: Vec<Station>) -> Scenario {
    let mut scenario = with_mode(small(5, 140.0, 2), mode);
    (scenario.agents.altitude_step_m, scenario.agents.altitude_band_m) = (100.0, 100.0);
    scenario.camera.d_max_m = 400.0;
    // Their paths must not depend on their knowledge.
    scenario.guidance.criterion = Criterion::Circles;
    scenario.netem.radio.range_m = 95.0;
    Scenario { stations, ..scenario }
}

/// The held facts in the last message of an agent in a step.
fn held(trace: &StepTrace<SetMembership>, agent: u16) -> Option<Vec<HeldFacts>> {
    let mut own = trace.passages.iter().filter(|passage| passage.sent.src == AgentId(agent));
    own.find_map(|passage| {
        let body = Envelope::decode(&passage.bytes).ok()?.body;
        match postcard::from_bytes(&body).ok()? {
            Message::Fact(fact) => Some(fact.held.facts),
            Message::Snapshot(snapshot) => Some(snapshot.fact.held.facts),
            Message::Plan(_) | Message::Relay(_) => None,
        }
    })
}

#[test]
fn uavs_that_do_not_hear_each_other_learn_through_a_station() {
    let station = vec![at(0.0, 0.0, 84.0)];
    let fly = |mode, stations| {
        let mut engine = engine(&apart(mode, stations));
        let mut most = [0, 0];
        for _ in 0..=80 {
            let trace = step(&mut engine);
            for passage in &trace.passages {
                if passage.sent.src.0 < 2 && passage.sent.dst.0 < 2 {
                    assert_eq!(passage.fate.first, Err(Reason::Range));
                }
            }
            for (agent, most) in (0..).zip(&mut most) {
                let of_other = |facts: &HeldFacts| facts.origin == AgentId(1 - agent);
                let held = held(&trace, agent).unwrap_or_default();
                let count = held.iter().find(|facts| of_other(facts)).map_or(0, |f| f.count);
                *most = count.max(*most);
            }
        }
        (most, [0, 1].map(|agent| unexplored_m2(&engine, agent)), engine)
    };
    let (held, apart_m2, _) = fly(ExchangeMode::FactsRepair, Vec::new());
    assert_eq!(held, [0, 0]);
    let (held, together_m2, _) = fly(ExchangeMode::FactsRepair, station.clone());
    assert!(held.iter().all(|count| *count > 40), "facts of the other UAV: {held:?}");
    println!("{together_m2:?} m² unexplored, {apart_m2:?} m² without the station");
    assert!((0..2).all(|uav| together_m2[uav] < 0.95 * apart_m2[uav]));
    // With facts alone, only the UAV that took a frame sends what it proves.
    let (_, silent_m2, silent) = fly(ExchangeMode::Facts, station);
    let said = silent.per_link().into_iter().filter(|((src, ..), _)| *src == AgentId(2));
    assert_eq!(said.map(|(_, link)| link.counts.sent).sum::<u64>(), 0);
    assert!(silent_m2.iter().zip(apart_m2).all(|(a, b)| (a - b).abs() < 1e-6 * b), "{silent_m2:?}");
}

/// A lost message of the station proves nothing: no UAV sends a snapshot for it.
#[test]
fn what_a_station_says_is_not_repaired() {
    let mut scenario = small(3, 120.0, 2);
    scenario.stations = vec![at(0.0, -70.0, 2.0)];
    scenario.exchange.snapshot_period_s = 1000.0;
    // UAV 1 does not hear the station; all others hear each other.
    let groups = vec![vec![2], vec![1]];
    scenario.netem.partition =
        vec![PartitionConfig { from_s: 0.0, until_s: f64::INFINITY, groups, one_way: true }];
    let mut engine = engine(&scenario);
    let mut snapshots = 0;
    for k in 0..=60 {
        let trace = step(&mut engine);
        for passage in trace.passages.iter().filter(|passage| passage.sent.src.0 < 2) {
            let body = Envelope::decode(&passage.bytes).expect("an envelope").body;
            let message = postcard::from_bytes(&body).expect("a message");
            // Each agent sends one regular snapshot at its first turn.
            snapshots += u32::from(k > 10 && matches!(message, Message::Snapshot(_)));
        }
    }
    assert_eq!(snapshots, 0);
}

#[test]
fn a_station_that_crashes_comes_back_and_learns_again() {
    let mut scenario = small(3, 120.0, 2);
    scenario.stations = vec![at(0.0, -70.0, 2.0)];
    let outage = OutageConfig { agent: 2, from_s: 5.0, until_s: 10.0, kind: OutageKind::Crash };
    scenario.netem.outage = vec![outage];
    let mut engine = engine(&scenario);
    let (mut lives, mut known_m2) = (Vec::new(), Vec::new());
    for _ in 0..=60 {
        let trace = step(&mut engine);
        lives.extend(trace.lives);
        known_m2.push(120.0 * 120.0 - unexplored_m2(&engine, 2));
    }
    let restarted = |(agent, event): &(AgentId, LifeEvent)| {
        let LifeEvent::Restarted { step, incarnation } = event else { return None };
        Some((agent.0, step.0, *incarnation))
    };
    assert_eq!(lives.len(), 2);
    assert_eq!(lives.iter().find_map(restarted), Some((2, 20, Incarnation(1))));
    assert!(known_m2[9] > 0.0 && known_m2[20] < known_m2[9], "it begins with what this step tells");
    let fleet_m2 = 120.0 * 120.0 - unexplored_m2(&engine, 0);
    assert!(known_m2[60] > 0.95 * fleet_m2, "{} of {fleet_m2} m²", known_m2[60]);
}

/// A station at the south wall of the widest building, and the obstacles.
fn beside_a_wall(scenario: &Scenario) -> (Station, Vec<Obstacle>) {
    let world = world_of(scenario).expect("a world");
    let lowest = |o: &Obstacle| {
        let points = o.rings().flatten().collect::<Vec<_>>();
        points.into_iter().min_by(|a, b| a[1].total_cmp(&b[1])).expect("corners")
    };
    let widest = world.obstacles().iter().max_by(|a, b| a.area_m2().total_cmp(&b.area_m2()));
    let [x_m, y_m] = lowest(widest.expect("a building"));
    (at(x_m, y_m - 0.5, 1.5), world.obstacles().to_vec())
}

/// Whether a point of the line between two antennas is in a building, by other means than
/// `world::radio`.
fn passes_a_building(obstacles: &[Obstacle], a: [f64; 3], b: [f64; 3]) -> bool {
    let inside = |p: [f64; 3], o: &Obstacle| {
        let crossings = o.rings().flat_map(|ring| {
            let next = ring.iter().copied().cycle().skip(1).take(ring.len()).collect::<Vec<_>>();
            ring.into_iter().zip(next)
        });
        let beyond = |(a, b): &([f64; 2], [f64; 2])| {
            (a[1] > p[1]) != (b[1] > p[1])
                && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        p[2] < o.height_m && crossings.filter(beyond).count() % 2 == 1
    };
    (0..=4000).any(|i| {
        let t = f64::from(i) / 4000.0;
        let p = std::array::from_fn(|axis| a[axis] + t * (b[axis] - a[axis]));
        obstacles.iter().any(|o| inside(p, o))
    })
}

#[test]
fn walls_decide_what_a_station_hears() {
    let mut scenario = small(2, 150.0, 2);
    let (station, obstacles) = beside_a_wall(&scenario);
    scenario.stations = vec![station];
    let mut delivered = Vec::new();
    for obstruction_db in [0.0, 200.0] {
        scenario.netem.radio.propagation = Some(PropagationConfig {
            exponent: 2.0,
            shadowing_sigma_db: 0.0,
            obstruction_db,
            ..PropagationConfig::default()
        });
        let mut engine = engine(&scenario);
        let (mut lost, mut heard, mut grazing) = (0, 0, 0);
        for _ in 0..=60 {
            for passage in step(&mut engine).passages {
                let sent = &passage.sent;
                let is_lost = passage.fate.first == Err(Reason::Propagation);
                assert!(is_lost || passage.fate.first.is_ok());
                let is_behind = obstruction_db > 0.0
                    && passes_a_building(&obstacles, sent.src_p_world, sent.dst_p_world);
                assert!(is_lost || !is_behind, "{:?} to {:?}", sent.src_p_world, sent.dst_p_world);
                // A corner may lie between two of the sampled points.
                grazing += u32::from(is_lost && !is_behind);
                if sent.src.0 < 2 && sent.dst.0 < 2 {
                    assert!(!is_lost, "both fly above the roofs");
                } else {
                    (lost, heard) = (lost + u32::from(is_lost), heard + u32::from(!is_lost));
                }
            }
        }
        println!("{obstruction_db} dB: {heard} heard, {lost} lost, {grazing} of them at a corner");
        assert!(100 * grazing <= lost);
        delivered.push(engine.counters().delivered);
        assert_eq!(lost > 0, obstruction_db > 0.0);
        assert!(heard > 0, "the sky is open to the south");
    }
    assert!(delivered[1] < delivered[0], "{delivered:?}");
}

#[test]
fn where_no_station_can_be_is_told() {
    let scenario = small(2, 150.0, 2);
    let (beside, obstacles) = beside_a_wall(&scenario);
    let errors = |stations: Vec<Station>| {
        let errors = world_of(&Scenario { stations, ..scenario.clone() });
        errors.map_or_else(|errors| errors.errors, |_| Vec::new())
    };
    assert_eq!(errors(vec![beside]), []);
    // Slightly north of the corner a station would be in the building.
    let building = obstacles.iter().max_by(|a, b| a.area_m2().total_cmp(&b.area_m2())).unwrap();
    let ring = building.rings().next().unwrap();
    let middle = [0, 1].map(|axis| (ring[0][axis] + ring[1][axis]) / 2.0);
    let [x_m, y_m] = middle;
    let roof_m = building.height_m;
    let on = |z_m| errors(vec![beside, at(x_m, y_m, z_m)]);
    let expected = StationError::Indoors {
        index: 1,
        x_m,
        y_m,
        z_m: roof_m,
        name: building.name.clone(),
        roof_m,
    };
    assert_eq!(on(roof_m), [WorldError::Station(expected)]);
    assert_eq!(on(roof_m + 0.1), []);
    let far = |x_m, y_m, z_m| match &errors(vec![at(x_m, y_m, z_m)])[..] {
        [WorldError::Station(StationError::Far { axis, .. })] => *axis,
        other => panic!("{other:?}"),
    };
    assert_eq!(far(1075.1, 0.0, 2.0), "x_m");
    assert_eq!(far(0.0, f64::NAN, 2.0), "y_m");
    assert_eq!(far(0.0, 75.0, -0.1), "z_m");
    assert_eq!(errors(vec![at(1075.0, -1075.0, 0.0)]), []);
    let many = errors(vec![at(0.0, -80.0, 2.0); 65]);
    assert!(matches!(many[..], [WorldError::Station(StationError::TooMany { stations: 65, .. })]));
}
