//! Fleets of schedulers on one bus.

use super::super::tests::default_config;
use super::*;
use crate::config::{Criterion, GuidanceConfig};

fn config(id: u16, count: u16, schedule: Schedule) -> AgentConfig {
    let mut config = default_config();
    config.id = AgentId(id);
    config.fleet.count = count;
    config.guidance = GuidanceConfig { schedule, ..GuidanceConfig::default() };
    config
}

/// A pose that encodes the agent, the step, the pass and the block of its plan.
fn pose(agent: u16, step: Step, pass: u8, block: u32) -> Pose {
    let x = f64::from(agent) * 1000.0 + f64::from(pass) * 100.0;
    Pose::level([x, f64::from(step.0 + block * 6), 52.0], 0.0)
}

fn plan(agent: u16, step: Step, pass: u8) -> Plan {
    Plan { step, pass, poses: (1..3).map(|block| pose(agent, step, pass, block).into()).collect() }
}

/// The poses of [`plan`].
fn planned(agent: u16, step: Step, pass: u8) -> Vec<Pose> {
    plan(agent, step, pass).poses.into_iter().map(Pose::from).collect()
}

/// One planning event: time, agent, pass, and the agents it accounts for.
type Event = (SimTime, u16, u8, Vec<u16>);

/// Runs one decision of a fleet; the agents in `alive` plan, and their plans arrive after `delay_s`.
fn run(
    fleet: &mut [Scheduler],
    alive: &[u16],
    start: SimTime,
    delay_s: f64,
) -> (Vec<Event>, Vec<u16>) {
    let (mut events, mut commanded, mut now) = (Vec::new(), Vec::new(), start);
    let mut in_flight: Vec<(SimTime, u16, Plan)> = Vec::new();
    alive.iter().for_each(|&i| fleet[usize::from(i)].on_instant(start));
    loop {
        for &i in alive {
            let scheduler = &mut fleet[usize::from(i)];
            scheduler.on_timeout(now);
            while let Some(pass) = scheduler.ready() {
                let heard = pass.neighbours.iter().map(|id| id.0).collect();
                events.push((now, i, pass.pass, heard));
                let plan = plan(i, pass.step, pass.pass);
                commanded.extend(scheduler.on_own_plan(&plan).then_some(i));
                in_flight.push((now.after(delay_s), i, plan));
            }
        }
        let deadlines = alive.iter().filter_map(|&i| fleet[usize::from(i)].next_deadline());
        let Some(next) = in_flight.iter().map(|&(at, ..)| at).chain(deadlines).min() else { break };
        now = next;
        let (due, later) = in_flight.into_iter().partition(|&(at, ..)| at <= now);
        in_flight = later;
        let due: Vec<(SimTime, u16, Plan)> = due;
        for (_, from, plan) in due {
            for &to in alive.iter().filter(|&&to| to != from) {
                fleet[usize::from(to)].on_plan(now, AgentId(from), &plan).unwrap();
            }
        }
    }
    (events, commanded)
}

fn fleet(schedule: Schedule) -> Vec<Scheduler> {
    (0..3).map(|id| Scheduler::new(&config(id, 3, schedule))).collect()
}

fn order(events: &[Event]) -> Vec<(u16, u8, Vec<u16>)> {
    events.iter().map(|(_, id, pass, heard)| (*id, *pass, heard.clone())).collect()
}

#[test]
fn sequential_is_by_index_and_looks_back_only() {
    let mut fleet = fleet(Schedule::Sequential);
    for decision in 0..3 {
        let start = SimTime::from_seconds(3.0 * f64::from(decision));
        let (events, commanded) = run(&mut fleet, &[0, 1, 2], start, 0.01);
        assert_eq!(order(&events), [(0, 0, vec![]), (1, 0, vec![0]), (2, 0, vec![0, 1])]);
        assert_eq!(commanded, [0, 1, 2]);
        assert!((events[2].0.seconds_since(start) - 0.02).abs() < 1e-6, "no time was lost");
    }
}

#[test]
fn the_loopback_accounts_for_everybody() {
    let mut fleet = fleet(Schedule::SequentialLoopback);
    for decision in 0..3 {
        let start = SimTime::from_seconds(3.0 * f64::from(decision));
        let (events, commanded) = run(&mut fleet, &[0, 1, 2], start, 0.01);
        let first = [(0, 0, vec![]), (1, 0, vec![0]), (2, 0, vec![0, 1])];
        let second = [(0, 1, vec![1, 2]), (1, 1, vec![0, 2]), (2, 1, vec![0, 1])];
        assert_eq!(order(&events), [first, second].concat());
        assert_eq!(commanded, [0, 1, 2]);
    }
}

#[test]
fn the_loopback_waits_for_the_right_passes() {
    let mut middle = Scheduler::new(&config(1, 3, Schedule::SequentialLoopback));
    let step = Step(6);
    middle.on_instant(SimTime::from_seconds(3.0));
    assert_eq!(middle.ready(), None);
    middle.on_plan(SimTime(0), AgentId(2), &plan(2, step, 0)).unwrap();
    assert_eq!(middle.ready(), None, "the first pass waits for those before");
    middle.on_plan(SimTime(0), AgentId(0), &plan(0, step, 0)).unwrap();
    let pass = middle.ready().unwrap();
    assert_eq!((pass.pass, &pass.neighbours[..]), (0, &[AgentId(0)][..]));
    assert!(!middle.on_own_plan(&plan(1, step, 0)));
    assert_eq!(middle.ready(), None, "the second pass waits for the second plan of UAV 0");
    middle.on_plan(SimTime(0), AgentId(0), &plan(0, step, 1)).unwrap();
    let pass = middle.ready().unwrap();
    assert_eq!(pass.pass, 1);
    assert_eq!(pass.poses[0], planned(0, step, 1), "of UAV 0 the second plan");
    assert_eq!(pass.poses[1], planned(2, step, 0), "of UAV 2 the first");
    assert!(!middle.on_own_plan(&plan(1, step, 0)), "a stale pass is ignored");
    assert!(middle.ready().is_some());
    assert!(middle.on_own_plan(&plan(1, step, 1)));
    assert_eq!((middle.ready(), middle.next_deadline()), (None, None));
}

/// The horizon of `str4` is so long that the plans of the last decision serve as a first pass.
#[test]
fn far_sighted_plans_need_one_pass_and_account_for_everybody() {
    for schedule in [Schedule::Sequential, Schedule::SequentialLoopback] {
        let far_sighted = |id| {
            let mut config = config(id, 3, schedule);
            config.guidance.criterion = Criterion::Str4;
            Scheduler::new(&config)
        };
        let mut fleet: Vec<Scheduler> = (0..3).map(far_sighted).collect();
        let (events, _) = run(&mut fleet, &[0, 1, 2], SimTime(0), 0.01);
        assert_eq!(order(&events), [(0, 0, vec![]), (1, 0, vec![0]), (2, 0, vec![0, 1])]);
        let (events, commanded) = run(&mut fleet, &[0, 1, 2], SimTime::from_seconds(3.0), 0.01);
        let accounts_for_all = [(0, 0, vec![1, 2]), (1, 0, vec![0, 2]), (2, 0, vec![0, 1])];
        assert_eq!(order(&events), accounts_for_all);
        assert_eq!(commanded, [0, 1, 2]);
        // UAVs before this one have planned again; of plans of UAVs after it the second block is the
        // current one.
        fleet[1].on_instant(SimTime::from_seconds(6.0));
        assert_eq!(fleet[1].ready(), None, "it waits for those before");
        fleet[1].on_plan(SimTime(0), AgentId(0), &plan(0, Step(12), 0)).unwrap();
        let pass = fleet[1].ready().unwrap();
        assert_eq!(pass.poses[0][0], planned(0, Step(12), 0)[0]);
        assert_eq!(pass.poses[1][0], planned(2, Step(6), 0)[1]);
    }
}

/// A silent UAV does not tell what it sees: its far-sighted plans count for a short time only.
#[test]
fn far_sighted_plans_of_the_silent_count_for_two_decisions() {
    let mut config = config(1, 2, Schedule::SequentialLoopback);
    config.guidance.criterion = Criterion::Str4;
    let mut last = Scheduler::new(&config);
    last.on_plan(SimTime(0), AgentId(0), &plan(0, Step(0), 0)).unwrap();
    for (decision, heeded) in [(0, 1), (1, 1), (2, 1), (3, 0)] {
        let start = SimTime::from_seconds(3.0 * f64::from(decision));
        last.on_instant(start);
        last.on_timeout(start.after(0.4));
        assert_eq!(last.ready().unwrap().neighbours.len(), heeded, "decision {decision}");
        last.on_own_plan(&plan(1, Step(6 * decision), 0));
    }
}

#[test]
fn asynchronous_plans_at_once_with_the_plans_before() {
    let mut fleet = fleet(Schedule::Asynchronous);
    let (events, _) = run(&mut fleet, &[0, 1, 2], SimTime(0), 0.01);
    assert_eq!(order(&events), [(0, 0, vec![]), (1, 0, vec![]), (2, 0, vec![])]);
    let start = SimTime::from_seconds(3.0);
    // A plan of this decision has arrived already; the order of the agents must not matter.
    fleet[0].on_plan(SimTime(0), AgentId(2), &plan(2, Step(6), 0)).unwrap();
    fleet[0].on_instant(start);
    let pass = fleet[0].ready().unwrap();
    assert_eq!(pass.neighbours, [AgentId(1), AgentId(2)]);
    // One block of the old plan is over; after the other block it goes straight on, 15 m per block.
    let old = planned(2, Step(0), 0)[1];
    let on = Pose::level([old.p_world[0] + 15.0, old.p_world[1], old.p_world[2]], 0.0);
    assert_eq!(pass.poses[1], [old, on]);
    let (events, commanded) = run(&mut fleet, &[0, 1, 2], start, 0.01);
    assert!(events.iter().all(|(at, _, _, heard)| *at == start && heard.len() == 2));
    assert_eq!(commanded, [0, 1, 2]);
}

#[test]
fn a_silent_neighbour_costs_one_delay_and_nobody_misses_the_decision() {
    for schedule in [Schedule::Sequential, Schedule::SequentialLoopback] {
        for dead in 0..3 {
            let mut fleet = fleet(schedule);
            let alive: Vec<u16> = (0..3).filter(|&id| id != dead).collect();
            let mut last_plan_s = Vec::new();
            for decision in 0..3 {
                let start = SimTime::from_seconds(3.0 * f64::from(decision));
                let (events, commanded) = run(&mut fleet, &alive, start, 0.01);
                assert_eq!(commanded, alive, "in order, {schedule:?} without {dead}");
                let last = events.last().unwrap().0.seconds_since(start);
                assert!(last <= 0.4, "{last}");
                last_plan_s.push(last);
            }
            let nobody_waits = schedule == Schedule::Sequential && dead == 2;
            assert_eq!(last_plan_s[0] > 0.1, !nobody_waits, "{last_plan_s:?}");
            assert!(last_plan_s[1] < 0.05 && last_plan_s[2] < 0.05, "{last_plan_s:?}");
            // It is back: from now on the others wait for it.
            run(&mut fleet, &[0, 1, 2], SimTime::from_seconds(9.0), 0.01);
            let (events, _) = run(&mut fleet, &[0, 1, 2], SimTime::from_seconds(12.0), 0.01);
            assert_eq!(order(&events)[2], (2, 0, vec![0, 1]));
        }
    }
}

/// With links that lose all messages the deadlines alone keep the order.
#[test]
fn nobody_heard_still_means_in_order() {
    let mut fleet = fleet(Schedule::SequentialLoopback);
    let mut times = Vec::new();
    for (index, scheduler) in fleet.iter_mut().enumerate() {
        let mut now = SimTime(0);
        scheduler.on_instant(now);
        for expected_pass in 0..2 {
            if let Some(deadline) = scheduler.next_deadline() {
                scheduler.on_timeout(SimTime(deadline.0 - 1));
                assert_eq!(scheduler.ready(), None, "not a moment too early");
                scheduler.on_timeout(deadline);
                now = deadline;
            }
            let pass = scheduler.ready().unwrap();
            assert_eq!((pass.pass, pass.neighbours.len()), (expected_pass, 0));
            times.push((expected_pass, index, now));
            scheduler.on_own_plan(&plan(index as u16, Step(0), expected_pass));
        }
    }
    times.sort();
    let firsts: Vec<SimTime> = times[..3].iter().map(|&(.., at)| at).collect();
    assert!(firsts.is_sorted_by(|a, b| a < b), "{firsts:?}");
    assert!(times.iter().all(|&(.., at)| at <= SimTime::from_seconds(0.4)));
}

#[test]
fn a_late_plan_only_updates_what_is_known() {
    let mut last = Scheduler::new(&config(1, 2, Schedule::Sequential));
    last.on_instant(SimTime(0));
    last.on_timeout(SimTime::from_seconds(0.4));
    assert_eq!(last.ready().unwrap().neighbours, []);
    last.on_own_plan(&plan(1, Step(0), 0));
    last.on_instant(SimTime::from_seconds(3.0));
    assert!(last.ready().is_some(), "given up on, so not waited for");
    // The plan of decision 0 arrives in decision 6: its sender is alive, so the agent waits for it
    // again.
    last.on_plan(SimTime(0), AgentId(0), &plan(0, Step(0), 0)).unwrap();
    assert_eq!(last.ready(), None);
    last.on_timeout(SimTime::from_seconds(3.4));
    let pass = last.ready().unwrap();
    assert_eq!(pass.poses[0][0], planned(0, Step(0), 0)[1], "its second block is the current one");
    // Newer, older and repeated plans: the newest one counts.
    last.on_plan(SimTime(0), AgentId(0), &plan(0, Step(6), 0)).unwrap();
    last.on_plan(SimTime(0), AgentId(0), &plan(0, Step(0), 0)).unwrap();
    assert_eq!(last.ready().unwrap().poses[0], planned(0, Step(6), 0));
    // An early plan is for the next decision and is not used before.
    last.on_plan(SimTime(0), AgentId(0), &plan(0, Step(12), 0)).unwrap();
    assert_eq!(last.ready().unwrap().poses[0], planned(0, Step(6), 0));
    last.on_own_plan(&plan(1, Step(6), 0));
    last.on_instant(SimTime::from_seconds(6.0));
    assert_eq!(last.ready().unwrap().poses[0], planned(0, Step(12), 0));
}

#[test]
fn impossible_plans_are_refused() {
    let mut scheduler = Scheduler::new(&config(1, 3, Schedule::Sequential));
    scheduler.on_instant(SimTime::from_seconds(3.0));
    let good = plan(0, Step(6), 0);
    let refused = [
        (1, good.clone()),
        (3, good.clone()),
        (0, plan(0, Step(18), 0)),
        (0, plan(0, Step(7), 0)),
        (0, plan(0, Step(6), 1)),
        (0, Plan { poses: vec![], ..good.clone() }),
        (0, Plan { poses: vec![good.poses[0]; 256], ..good.clone() }),
    ];
    for (from, plan) in refused {
        assert!(scheduler.on_plan(SimTime(0), AgentId(from), &plan).is_err(), "{from} {plan:?}");
        assert_eq!(scheduler.ready(), None);
    }
    scheduler.on_plan(SimTime(0), AgentId(0), &good).unwrap();
    assert!(scheduler.ready().is_some());
}

#[test]
fn a_lone_uav_plans_once() {
    let mut fleet = [Scheduler::new(&config(0, 1, Schedule::SequentialLoopback))];
    assert!(fleet[0].decides_at(Step(0)) && fleet[0].decides_at(Step(6)));
    assert!(!fleet[0].decides_at(Step(5)));
    let (events, commanded) = run(&mut fleet, &[0], SimTime(0), 0.01);
    assert_eq!((order(&events), commanded), (vec![(0, 0, vec![])], vec![0]));
}

/// A far-sighted agent calls a UAV silent after two decisions without a plan, also from its own start on.
#[test]
fn who_does_not_plan_is_silent_after_two_decisions() {
    let mut config = config(1, 3, Schedule::SequentialLoopback);
    config.guidance.criterion = Criterion::Str4;
    config.guidance.plan_timeout_s = 0.0;
    for first in [0, 10] {
        let mut scheduler = Scheduler::new(&config);
        let block = scheduler.steps_per_block;
        let mut decide = |decision: u32, heard: &[u16]| {
            let step = Step((first + decision) * block);
            let now = SimTime(0).after(f64::from(step.0) * config.period_s);
            scheduler.on_frame(now, step);
            for id in heard {
                scheduler.on_plan(SimTime(0), AgentId(*id), &plan(*id, step, 0)).unwrap();
            }
            scheduler.on_timeout(now);
            let pass = scheduler.ready().expect("nothing to wait for");
            scheduler.on_own_plan(&plan(1, step, 0));
            pass.silent.into_iter().map(|id| id.0).collect::<Vec<u16>>()
        };
        assert_eq!(decide(0, &[]), [0; 0], "it has just started");
        assert_eq!(decide(1, &[2]), [0; 0]);
        assert_eq!(decide(2, &[]), [0], "only 2 was heard");
        assert_eq!(decide(3, &[0]), [0; 0]);
        assert_eq!(decide(4, &[]), [2]);
        assert_eq!(decide(5, &[]), [2], "0 was heard two decisions ago");
        assert_eq!(decide(6, &[]), [0, 2]);
    }
}

/// UAV 1 of four under `str5` with a range, at its decision at `step`.
fn relay(step: Step) -> Scheduler {
    let mut config = config(1, 4, Schedule::SequentialLoopback);
    config.guidance.criterion = Criterion::Str5;
    config.guidance.plan_timeout_s = 0.0;
    config.radio_range_m = 100.0;
    let mut scheduler = Scheduler::new(&config);
    scheduler.on_instant(SimTime(0).after(f64::from(step.0) * config.period_s));
    scheduler
}

fn hear(scheduler: &mut Scheduler, uav: u16, plan: Plan) -> Result<(), PlanError> {
    scheduler.on_relayed(&[RelayedPlan { uav: AgentId(uav), plan }])
}

fn relayed(scheduler: &mut Scheduler) -> Vec<(u16, u32)> {
    let plans = scheduler.plans_to_relay(&pose(0, Step(0), 0, 0));
    plans.iter().map(|RelayedPlan { uav, plan }| (uav.0, plan.step.0)).collect()
}

#[test]
fn each_recent_plan_of_a_uav_nearby_is_passed_on_once() {
    let mut scheduler = relay(Step(12));
    let near = |agent, step| Plan { poses: plan(0, Step(0), 0).poses, ..plan(agent, step, 0) };
    scheduler.on_plan(SimTime(0), AgentId(0), &near(0, Step(6))).unwrap();
    hear(&mut scheduler, 3, near(3, Step(0))).unwrap();
    scheduler.on_plan(SimTime(0), AgentId(2), &plan(2, Step(6), 0)).unwrap();
    assert_eq!(relayed(&mut scheduler), [(0, 6), (3, 0)], "UAV 2 is 2 km away");
    assert_eq!(relayed(&mut scheduler), []);
    scheduler.on_plan(SimTime(0), AgentId(0), &near(0, Step(12))).unwrap();
    hear(&mut scheduler, 3, near(3, Step(0))).unwrap();
    assert_eq!(relayed(&mut scheduler), [(0, 12)], "only what is new");
    scheduler.on_instant(SimTime::from_seconds(9.0));
    hear(&mut scheduler, 2, near(2, Step(0))).unwrap();
    assert_eq!(relayed(&mut scheduler), [], "that plan is three decisions old");
}

/// A plan that was passed on counts as one from its UAV, unless a newer one was heard, and nobody waits for the next.
#[test]
fn a_plan_that_was_passed_on_counts_and_is_not_waited_for() {
    let mut scheduler = relay(Step(12));
    hear(&mut scheduler, 0, plan(0, Step(6), 0)).unwrap();
    scheduler.on_plan(SimTime(0), AgentId(2), &plan(2, Step(12), 0)).unwrap();
    hear(&mut scheduler, 2, plan(2, Step(6), 0)).unwrap();
    scheduler.on_timeout(SimTime::from_seconds(6.0));
    let pass = scheduler.ready().unwrap();
    assert_eq!(
        (&pass.neighbours[..], &pass.ages[..]),
        (&[AgentId(0), AgentId(2)][..], &[1, 0][..])
    );
    scheduler.on_own_plan(&plan(1, Step(12), 0));
    hear(&mut scheduler, 0, plan(0, Step(12), 0)).unwrap();
    scheduler.on_instant(SimTime::from_seconds(9.0));
    assert!(scheduler.ready().is_some(), "it has not been heard itself since it missed a deadline");
    let from_afar = hear(&mut scheduler, 0, plan(0, Step(600), 0)).unwrap_err();
    assert!(matches!(from_afar, PlanError::NoSuchDecision { .. }), "{from_afar}");
    assert!(hear(&mut scheduler, 1, plan(1, Step(12), 0)).is_err(), "its own plan");
}

/// Where contact is predicted a plan counts as far as it reaches, and elsewhere for two decisions.
#[test]
fn with_a_range_plans_of_str5_count_to_their_end() {
    for (range_m, last) in [(100.0, 20), (f64::INFINITY, 2)] {
        let mut config = config(1, 2, Schedule::SequentialLoopback);
        config.guidance.criterion = Criterion::Str5;
        config.guidance.plan_timeout_s = 0.0;
        config.radio_range_m = range_m;
        let mut scheduler = Scheduler::new(&config);
        scheduler.on_plan(SimTime(0), AgentId(0), &plan(0, Step(0), 0)).unwrap();
        let counts = |decision: u32| {
            let now = SimTime::from_seconds(3.0 * f64::from(decision));
            scheduler.on_instant(now);
            scheduler.on_timeout(now);
            let pass = scheduler.ready().unwrap();
            assert_eq!(pass.silent.is_empty(), decision < 2 || !pass.neighbours.is_empty());
            !pass.neighbours.is_empty()
        };
        let counted: Vec<bool> = (0..24).map(counts).collect();
        assert_eq!(counted.iter().rposition(|counts| *counts), Some(last), "{range_m}");
    }
}

/// One decision after the other with a delay: a UAV accounts for one that plans after it only if that one could take
/// the new plan into account.
#[test]
fn of_two_that_do_not_hear_each_other_in_time_the_one_with_the_higher_number_gives_way() {
    let cases = [
        (Schedule::SequentialLoopback, 0.3, vec![1]),
        (Schedule::SequentialLoopback, 1.0, vec![]),
        (Schedule::Asynchronous, 0.3, vec![]),
    ];
    for (schedule, delay_s, heard) in cases {
        for (own, other, expected) in [(0, 1, heard), (1, 0, vec![0])] {
            let mut config = config(own, 2, schedule);
            config.guidance.criterion = Criterion::Str4;
            let mut scheduler = Scheduler::new(&config);
            for decision in 0..3 {
                let step = Step(decision * scheduler.steps_per_block);
                let start = SimTime(0).after(f64::from(step.0) * config.period_s);
                scheduler.on_frame(start, step);
                scheduler.on_timeout(start.after(0.4));
                let pass = scheduler.ready().expect("nothing to wait for");
                let known: Vec<u16> = pass.neighbours.iter().map(|id| id.0).collect();
                assert_eq!(known, if decision == 0 { vec![] } else { expected.clone() });
                scheduler.on_own_plan(&plan(own, step, 0));
                let arrives = start.after(delay_s);
                scheduler.on_plan(arrives, AgentId(other), &plan(other, step, 0)).unwrap();
            }
        }
    }
}
