use csat_proto::raster::Grid;

use super::*;
use crate::config::{Criterion, Schedule};
use crate::guidance::tests::{Scene, default_config};

/// UAV 1 of four, in contact up to 85 m.
fn config() -> AgentConfig {
    let mut config = default_config();
    config.id = AgentId(1);
    config.fleet.count = 4;
    config.guidance.criterion = Criterion::Str5;
    config.radio_range_m = 85.0;
    config
}

fn at(x: f64) -> Pose {
    Pose::level([x, 0.0, 50.0], 0.0)
}

/// Loads plans, each of a UAV, of an age, along a line of positions x. A UAV sees the cell at which a block ends.
fn load(links: &mut Connectivity, own: f64, plans: &[(u16, u32, &[f64])]) {
    let scene = Scene::new(&config());
    let ids: Vec<AgentId> = plans.iter().map(|(id, ..)| AgentId(*id)).collect();
    let ages: Vec<u32> = plans.iter().map(|(_, age, _)| *age).collect();
    let poses: Vec<Vec<Pose>> =
        plans.iter().map(|(.., plan)| plan.iter().map(|x| at(*x)).collect()).collect();
    let input = PlannerInput { neighbours: &ids, plan_ages: &ages, ..scene.input() };
    links.load(&input, &at(own), &poses, &everything(), |_, pose, set| {
        if let Some([x, y, _]) = pose.map(|pose| pose.p_world) {
            let (column, row) = set.grid().cell_of([x, y]).unwrap();
            set.clear(column, row);
        }
    });
}

fn everything() -> Raster {
    let grid = Grid::covering(&config().ground, 10.0);
    let mut all = Raster::empty(grid);
    (0..grid.rows).for_each(|row| all.set_run(row, 0..grid.columns));
    all
}

/// How many cells a UAV at x is told of at the end of a block.
fn told(links: &Connectivity, block: usize, x: f64) -> u32 {
    let mut set = everything();
    links.tell(block, &links.heard(block, at(x).p_world), &mut set);
    everything().count() - set.count()
}

#[test]
fn who_is_in_reach_of_one_of_a_group_hears_of_what_all_have_seen() {
    let mut links = Connectivity::new(&config()).unwrap();
    let plans: [(u16, u32, &[f64]); 3] =
        [(0, 0, &[0.0, 15.0]), (2, 1, &[80.0, 80.0, 80.0]), (3, 1, &[200.0, 185.0, 170.0])];
    load(&mut links, -50.0, &plans);
    assert_eq!(links.heard(0, at(-80.0).p_world).len(), 1, "UAVs 0 and 2 pass messages on");
    assert_eq!(links.heard(0, at(140.0).p_world).len(), 2, "a link between two groups");
    assert_eq!(links.heard(0, [140.0, 0.0, 120.0]).len(), 0, "height counts");
    assert_eq!((told(&links, 0, -80.0), told(&links, 0, 140.0)), (2, 3));
    assert_eq!(told(&links, 0, 260.0), 1, "of UAV 3 alone");
    assert_eq!(told(&links, 1, -80.0), 0, "UAV 0 has left");
    assert_eq!(told(&links, 1, 260.0), 2, "what was seen in the first block is still news");
    load(&mut links, -50.0, &[]);
    assert_eq!(told(&links, 0, 0.0), 0, "nobody is known to be anywhere");
}

/// What a UAV out of touch has seen is news when it comes back, for as long as its plan says that it is out of reach.
#[test]
fn a_silent_uav_is_expected_back_by_its_plan() {
    let mut links = Connectivity::new(&config()).unwrap();
    let way = [150.0, 165.0, 180.0, 165.0, 150.0];
    let mut at_age = |age: u32, id: u16, own: f64| {
        let rest = [&way[age as usize..], &vec![0.0; age as usize][..]].concat();
        load(&mut links, own, &[(id, age, &rest)]);
        [0, 1].map(|block| told(&links, block, 160.0))
    };
    assert_eq!(at_age(0, 2, 0.0), [1, 2], "it hears all at the start");
    assert_eq!(at_age(1, 2, 0.0), [1, 2], "a UAV that plans later is still in contact");
    assert_eq!(at_age(2, 2, 0.0), [2, 2], "it remembers the cell at 165 m");
    assert_eq!(at_age(3, 2, 0.0), [2, 3]);
    assert_eq!(
        at_age(4, 2, 70.0),
        [3, 0],
        "it is out of reach until the end of the block, when the plan ends"
    );
    assert_eq!(at_age(3, 2, 70.0), [0, 0], "it should be heard and is not");
    assert_eq!(at_age(3, 2, 0.0), [0, 0], "so nobody knows where it is");
    assert_eq!(at_age(2, 0, 0.0), [1, 2], "a recent plan counts");
}

/// Without waiting the newest plan of each UAV is of the last decision.
#[test]
fn a_uav_in_contact_knows_what_this_one_knows_whenever_it_plans() {
    for (schedule, news) in [(Schedule::SequentialLoopback, 2), (Schedule::Asynchronous, 1)] {
        let mut config = config();
        config.guidance.schedule = schedule;
        let mut links = Connectivity::new(&config).unwrap();
        load(&mut links, 0.0, &[(0, 1, &[150.0, 165.0, 180.0])]);
        load(&mut links, 0.0, &[(0, 1, &[165.0, 180.0, 195.0])]);
        assert_eq!(told(&links, 0, 160.0), news, "{schedule:?}");
    }
}

#[test]
fn only_str5_with_a_range_predicts_contact() {
    let mut config = config();
    assert!(Connectivity::new(&config).is_some());
    assert!(config.relays_plans());
    config.exchange.liars = 1;
    assert!(config.predicts_contact() && !config.relays_plans(), "liars may lie about plans");
    config.radio_range_m = f64::INFINITY;
    assert!(Connectivity::new(&config).is_none());
    config.radio_range_m = 100.0;
    config.guidance.criterion = Criterion::Str4;
    assert!(Connectivity::new(&config).is_none());
}
