//! What always holds: nothing that was claimed to be cleared is ever contaminated, under any links; and with enough
//! UAVs and good links all is cleared.

mod sim;

use csat_clearing::agent::Role;
use csat_clearing::config::{ClearingConfig, Coding, OdometryBounds, Rules};
use csat_proto::agent::Agent;
use sim::links::LinkModel;
use sim::town::Town;
use sim::{Flight, Outcome, Setup, fly};

const BAD: LinkModel =
    LinkModel { loss: 0.6, max_delay_s: 2.0, duplication: 0.2, hbsr_range_m: 60.0 };

fn safe(setup: &Setup) -> Outcome {
    let outcome = fly(setup);
    assert_eq!((outcome.violations, &outcome.first_violation), (0, &None), "{setup:?}");
    assert_eq!(outcome.overlooked, None, "{setup:?}");
    assert_eq!(outcome.rejected, 0);
    outcome
}

fn cleared(setup: &Setup) -> Outcome {
    let outcome = safe(setup);
    assert!(outcome.cleared_s.is_some(), "{outcome:?} of {:?}", setup.town);
    outcome
}

#[test]
fn one_uav_clears_a_dead_end() {
    let outcome = cleared(&Setup { uavs: 1, ..Setup::new(Town::straight(), 1) });
    // 400 m at 1 m/s, of which the first and the last image need no flight.
    assert!((300.0..400.0).contains(&outcome.cleared_s.unwrap()), "{outcome:?}");
    assert_eq!((outcome.cleaners_max, outcome.splits, outcome.has_lost), (1, 0, false));
}

#[test]
fn one_uav_stalls_at_a_crossing_and_says_so() {
    let outcome = safe(&Setup { uavs: 1, ..Setup::new(Town::cross(), 2) });
    assert!(outcome.is_stalled && outcome.cleared_s.is_none(), "{outcome:?}");
    assert!(outcome.cleared_share > 0.3);
}

#[test]
fn a_frontier_that_waits_is_held() {
    let setup = Setup { uavs: 1, ..Setup::new(Town::cross(), 2) };
    for (motion_error_m, drift_share, until_s) in [(0.02, 0.002, 1200.0), (0.12, 0.0, 700.0)] {
        let odometry = OdometryBounds { drift_share, ..setup.odometry };
        let mut flight = Flight::new(&Setup { motion_error_m, odometry, ..setup.clone() });
        while flight.time_s() < until_s {
            flight.advance();
        }
        let outcome = flight.finish();
        assert!(outcome.is_stalled && !outcome.has_lost, "{outcome:?}");
        assert_eq!((outcome.violations, outcome.overlooked), (0, None));
    }
}

#[test]
fn who_cannot_hold_a_frontier_says_so() {
    let odometry = OdometryBounds { jitter_m: 0.1, drift_share: 0.2 };
    let setup = Setup { uavs: 1, max_s: 400.0, odometry, ..Setup::new(Town::cross(), 2) };
    let outcome = safe(&setup);
    assert!(outcome.has_lost, "{outcome:?}");
}

#[test]
fn a_team_clears_crossings() {
    for town in [Town::tee(), Town::cross()] {
        let outcome = cleared(&Setup { uavs: 4, ..Setup::new(town, 3) });
        assert!(outcome.splits > 0);
    }
}

#[test]
fn a_team_clears_a_ring_and_a_fork() {
    let outcome = cleared(&Setup { uavs: 4, ..Setup::new(Town::ring(), 4) });
    assert!(outcome.splits > 0);
    cleared(&Setup { uavs: 5, ..Setup::new(Town::fork(), 5) });
}

#[test]
fn a_team_clears_blocks_that_are_smaller_than_an_image() {
    for apart_m in [40.0, 75.0] {
        let town = Town::ladder(apart_m, &[-120.0, 60.0]);
        cleared(&Setup { uavs: 4, ..Setup::new(town, 6) });
    }
}

#[test]
fn cleaners_that_only_see_each_other_keep_their_frontiers() {
    cleared(&Setup { uavs: 3, ..Setup::new(Town::hooks(), 12) });
}

#[test]
fn bad_links_leak_nothing() {
    for (town, uavs) in
        [(Town::cross(), 4), (Town::ring(), 4), (Town::ladder(60.0, &[-120.0, 0.0]), 3)]
    {
        safe(&Setup { uavs, links: BAD, max_s: 500.0, ..Setup::new(town, 7) });
    }
}

#[test]
fn bad_links_leak_nothing_in_a_desert() {
    for seed in 0..2 {
        let setup = Setup::new(Town::desert(seed, 110.0), seed);
        let outcome = safe(&Setup { links: BAD, max_s: 250.0, ..setup });
        assert!(outcome.cleaners_max > 1, "{outcome:?}");
    }
}

#[test]
fn the_rules_of_the_paper_leak() {
    // The street shows only while it is in the stripe at the border, so the rear end of the other road is forgotten.
    let clearing = ClearingConfig { rules: Rules::Paper, ..ClearingConfig::default() };
    let town = Town::rear();
    let setup = Setup { uavs: 1, clearing, max_s: 300.0, ..Setup::new(town, 8) };
    let outcome = fly(&setup);
    assert!(outcome.violations > 0, "{outcome:?}");
    let clearing = ClearingConfig::default();
    safe(&Setup { clearing, ..setup });
}

#[test]
fn a_lost_frontier_is_noticed_and_nothing_is_claimed_any_more() {
    let mut setup = Setup { uavs: 4, max_s: 330.0, ..Setup::new(Town::tee(), 9) };
    setup.clearing.lost_after_s = 20.0;
    setup.crash = Some((0, 215.0));
    let mut flight = Flight::new(&setup);
    while flight.advance() {}
    assert!(flight.agents[1..].iter().all(|agent| agent.has_lost()));
    assert!(flight.agents[1..].iter().all(|agent| agent.claims().is_empty()));
    assert!(flight.finish().has_lost);
}

#[test]
fn masks_may_be_written_in_any_way() {
    let setup = Setup { uavs: 3, ..Setup::new(Town::ladder(60.0, &[-180.0]), 10) };
    let mut flights = [Coding::Bitmap, Coding::Runs].map(|coding| {
        let clearing = ClearingConfig { coding, ..ClearingConfig::default() };
        Flight::new(&Setup { clearing, ..setup.clone() })
    });
    for _ in 0..1000 {
        flights.iter_mut().for_each(|flight| assert!(flight.advance()));
        let digests = flights
            .each_ref()
            .map(|flight| flight.agents.iter().map(Agent::digest).collect::<Vec<_>>());
        assert_eq!(digests[0], digests[1]);
    }
    let [bitmaps, runs] = flights.map(|flight| flight.links.bytes[&sim::HBSR]);
    assert!(runs * 2 < bitmaps, "{runs} bytes of runs, {bitmaps} of bitmaps");
}

#[test]
fn a_station_listens() {
    let setup = Setup::new(Town::straight(), 11);
    let config = csat_clearing::config::AgentConfig { stations: 1, ..setup.config(8) };
    let mut station = csat_clearing::agent::ClearingAgent::new(&config);
    let now = csat_proto::time::SimTime(0);
    station.handle_step(now, csat_proto::time::Step(0), csat_proto::camera::Pose::default());
    station.handle_timeout(now);
    assert_eq!((station.role(), station.poll_timeout()), (Role::Station, None));
    assert!(station.poll_command().is_none() && station.poll_transmit().is_none());
}
