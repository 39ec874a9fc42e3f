//! A second mission with tables of the same names as those of the first one, and what only such a mission may
//! fly: fixed-wing aircraft, and targets that walk at random.

use std::fmt::Write as _;
use std::sync::Once;

use csat_flight::scenario::missions::{Entry, Listed, Offered};
use csat_flight::scenario::validate::Issue;
use csat_flight::scenario::{Loaded, Mistakes, Request, Scenario, keys, load, missions};
use csat_flight::set_membership::SetMembership;
use csat_mission::mission::{Detail, Kind, Mission};
use csat_proto::agent::Agent;
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::{AgentId, Incarnation};
use csat_world::navigation::NavigationModel;
use csat_world::world::{World, WorldConfig};
use serde::{Deserialize, Serialize};

/// The set-membership mission under another name, with tables of its own.
#[derive(Clone)]
struct Other(SetMembership);

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Exchange {
    max_vertices: i64,
    taste: f64,
}

impl Default for Exchange {
    fn default() -> Self {
        Self { max_vertices: -3, taste: 0.5 }
    }
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Tables {
    exchange: Exchange,
    pose: NavigationModel,
}

impl Offered for Other {
    type Tables = Tables;

    const LABELS: bool = false;

    fn of(scenario: &Scenario) -> Self {
        Self(SetMembership::new(scenario))
    }

    fn judge_scenario(scenario: &Scenario) -> Vec<Issue> {
        let taste = scenario.own::<Tables>().exchange.taste;
        let is_bad = !(0.0..=1.0).contains(&taste);
        let issue = || Issue::refused(&["exchange.taste"], &taste.to_string(), "from 0 to 1");
        is_bad.then(issue).into_iter().collect()
    }

    fn equip(scenario: &Scenario, config: &mut WorldConfig) {
        config.navigation = Some(scenario.own::<Tables>().pose);
    }
}

type Base = SetMembership;

impl Mission for Other {
    type Agent = <Base as Mission>::Agent;
    type Report = <Base as Mission>::Report;
    type Judge = <Base as Mission>::Judge;
    type Measures = <Base as Mission>::Measures;

    const KIND: Kind = Kind { name: "other", ..Base::KIND };

    fn agent(&self, id: AgentId, incarnation: Incarnation) -> Self::Agent {
        self.0.agent(id, incarnation)
    }

    fn camera(&self, id: AgentId) -> Option<CameraModel> {
        self.0.camera(id)
    }

    fn report(&self, agent: &mut Self::Agent, pose: &Pose, detail: Detail) -> Self::Report {
        self.0.report(agent, pose, detail)
    }

    fn judge(&self, world: &World) -> Self::Judge {
        self.0.judge(world)
    }

    fn measures(&self) -> Self::Measures {
        self.0.measures()
    }

    fn footprint(&self, report: &Self::Report) -> Vec<[f64; 2]> {
        self.0.footprint(report)
    }

    fn is_inconsistency(&self, event: &<Self::Agent as Agent>::Event) -> bool {
        self.0.is_inconsistency(event)
    }
}

static INSTALL: Once = Once::new();

/// Loads a scenario of a mission with `--set` arguments.
fn load_of(mission: &str, sets: &[&str]) -> Result<Loaded, Mistakes> {
    const LIST: [&dyn Listed; 2] = [&Entry::<SetMembership>::new(), &Entry::<Other>::new()];
    INSTALL.call_once(|| missions::install(LIST.into()));
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), format!("mission = \"{mission}\"")).unwrap();
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    load(Request { scenario: file.path().to_str(), sets: &sets, seed: None })
}

fn load_with(sets: &[&str]) -> Result<Loaded, Mistakes> {
    load_of("set-membership", sets)
}

fn other_with(sets: &[&str]) -> Result<Loaded, Mistakes> {
    load_of("other", sets)
}

/// The text of all mistakes.
fn refused(loaded: Result<Loaded, Mistakes>) -> String {
    // A world is too much to be printed.
    let Err(Mistakes { mistakes, .. }) = loaded else { panic!("nothing was refused") };
    let mut text = String::new();
    for mistake in mistakes {
        writeln!(text, "{mistake}").unwrap();
    }
    text
}

#[test]
fn a_table_of_the_same_name_is_the_missions_own() {
    let sets = ["exchange.max_vertices=-7", "exchange.taste=1", "pose.noise=gauss-markov"];
    let scenario = other_with(&sets).unwrap().scenario;
    let own: Tables = scenario.own();
    assert_eq!((own.exchange.max_vertices, own.exchange.taste), (-7, 1.0));
    assert_eq!(scenario.exchange, Scenario::default().exchange, "the other table is not touched");
    let text = scenario.to_toml();
    assert!(text.contains("max_vertices = -7") && !text.contains("budget_bytes_s"), "{text}");
    assert!(!text.contains("[guidance]"), "{text}");
    assert_eq!(Scenario::from_toml(&text).unwrap(), scenario);
    let usual = load_with(&["exchange.max_vertices=9"]).unwrap().scenario;
    assert_eq!((usual.exchange.max_vertices, usual.own.len()), (9, 1));
    assert_eq!(Scenario::from_toml(&usual.to_toml()).unwrap(), usual);
}

#[test]
fn tables_of_other_missions_only_are_refused() {
    let text = refused(other_with(&["guidance.kappa=1"]));
    assert!(text.contains("`guidance` belongs to the mission `set-membership`"), "{text}");
    let text = refused(load_with(&["pose.noise=white"]));
    assert!(text.contains("unknown key `noise` in [pose]"), "both have such a table: {text}");
    let text = refused(load_with(&["exchange.taste=1"]));
    assert!(text.contains("unknown key `taste` in [exchange]"), "{text}");
    let text = refused(other_with(&["exchange.mode=none", "estimatr.x=1"]));
    assert!(text.contains("one of `max_vertices`, `taste`"), "{text}");
    assert!(text.contains("`netem`, `exchange`, `pose`"), "{text}");
    assert!(!text.contains("`guidance`"), "{text}");
}

#[test]
fn limits_are_those_of_the_mission() {
    // -7 is below the limit of the first mission's key.
    let text = refused(other_with(&["exchange.max_vertices=x", "exchange.taste=2"]));
    assert!(text.contains("`exchange.max_vertices` cannot be \"x\""), "{text}");
    assert!(!text.contains("4 or more"), "{text}");
    assert!(text.contains("`exchange.taste` cannot be 2"), "{text}");
    let text = refused(load_with(&["exchange.max_vertices=x"]));
    assert!(text.contains("a whole number, 4 or more"), "{text}");
    assert!(keys::keys("exchange.").iter().all(|key| key.mission.is_none()));
}

#[test]
fn a_mission_adds_to_the_world() {
    let loaded = other_with(&["pose.sigma=[1,2,3,0,0,0]"]).unwrap();
    let navigation = loaded.world.config().navigation.unwrap();
    assert_eq!(navigation.sigma, [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
    let reported = loaded.world.reported_poses().into_iter().map(|estimate| estimate.pose);
    assert_ne!(reported.collect::<Vec<_>>(), loaded.world.poses());
    assert_eq!(load_with(&[]).unwrap().world.config().navigation, None);
    let text = refused(other_with(&["pose.time_constant_s=0"]));
    assert!(text.contains("`pose.time_constant_s` cannot be 0"), "{text}");
    assert!(text.contains("pose.time_constant_s=0\n"), "with its place: {text}");
}

/// Poses and targets after ten steps.
fn flown(sets: &[&str]) -> (Vec<Pose>, Vec<[f64; 2]>) {
    let mut world = other_with(sets).unwrap_or_else(|error| panic!("{error}")).world;
    let turn = csat_proto::command::Command::Yaw { yaw_rad: 1.0 };
    world.command(AgentId(0), turn).unwrap();
    (0..10).for_each(|_| world.advance());
    (world.poses(), world.targets().iter().map(|target| target.location).collect())
}

#[test]
fn each_key_of_a_fixed_wing_aircraft_changes_its_flight() {
    let base = ["agents.vehicle=fixed-wing", "agents.speed_m_s=20"];
    let usual = flown(&base);
    assert_ne!(usual.0, flown(&base[1..]).0);
    for key in [
        "roll_max_deg=20",
        "roll_time_constant_s=1",
        "heading_time_constant_s=3",
        "pitch_trim_deg=2",
        "pitch_time_constant_s=1",
        "wind_m_s=[2,-3]",
    ] {
        let set = format!("agents.fixed_wing.{key}");
        assert_ne!(flown(&[&base[..], &[&set]].concat()).0, usual.0, "{key}");
        let text = refused(other_with(&[&set]));
        assert!(text.contains("with agents.vehicle = \"quadcopter\""), "{text}");
        assert!(text.contains("no such key: it has no effect"), "{text}");
    }
    let text = refused(other_with(&[base[0], base[1], "agents.yaw_settling_s=2"]));
    assert!(text.contains("`agents.yaw_settling_s` cannot be 2.0 with agents.vehicle"), "{text}");
}

#[test]
fn impossible_aircraft_are_refused() {
    for (key, expected) in [
        ("roll_max_deg=80", "above 0 and below 80 degrees"),
        ("roll_time_constant_s=0", "a finite number above 0"),
        ("heading_time_constant_s=-1", "a finite number above 0"),
        ("pitch_time_constant_s=nan", "a finite number above 0"),
        ("pitch_trim_deg=46", "from -45 to 45 degrees"),
        ("wind_m_s=[3,4]", "a wind slower than agents.speed_m_s = 5 m/s"),
        ("wind_m_s=[nan,0]", "a wind slower than agents.speed_m_s = 5 m/s"),
    ] {
        let set = format!("agents.fixed_wing.{key}");
        let text = refused(other_with(&["agents.vehicle=fixed-wing", &set]));
        assert!(text.contains(expected), "{key}: {text}");
        assert_eq!(text.matches("error: ").count(), 1, "{key}: {text}");
    }
}

#[test]
fn targets_stand_or_walk_in_towns_and_on_open_ground() {
    let (_, on_roads) = flown(&[]);
    let (_, standing) = flown(&["targets.driving=static"]);
    let walk = "targets.driving=random-walk";
    let (_, walking) = flown(&[walk]);
    let (_, far) = flown(&[walk, "targets.walk_m_sqrt_s=4"]);
    assert!(on_roads != standing && standing != walking && walking != far);
    let open = flown(&["map.kind=open", walk]);
    assert_eq!(open.1.len(), 8);
    assert!(!other_with(&["map.kind=open", walk]).unwrap().world.obstacles().iter().any(|_| true));
    let text = refused(other_with(&["map.kind=open"]));
    assert!(text.contains("0 of 8 cars found room on 0 m"), "{text}");
    let text = refused(other_with(&["map.kind=open", walk, "map.built_share=0.1"]));
    assert!(text.contains("`map.built_share` cannot be 0.1 with kind = \"open\""), "{text}");
    let text = refused(other_with(&["targets.walk_m_sqrt_s=4"]));
    assert!(text.contains("4.0 with targets.driving = \"roads\""), "{text}");
    let text = refused(other_with(&[walk, "targets.walk_m_sqrt_s=-1"]));
    assert!(text.contains("a finite number from 0 on"), "{text}");
    let text = refused(other_with(&[
        "map.size_m=[100,100]",
        "targets.driving=static",
        "targets.count=1000",
    ]));
    assert!(text.contains("of 1000 targets found room"), "{text}");
}

#[test]
fn the_guarantee_is_not_given_for_what_it_does_not_cover() {
    let text = refused(load_with(&["targets.driving=random-walk"]));
    assert!(text.contains("`targets.driving` cannot be `random-walk`"), "{text}");
    assert!(text.contains("targets.driving=random-walk\n"), "with its place: {text}");
    let text = refused(load_with(&["agents.vehicle=fixed-wing"]));
    assert!(text.contains("`agents.vehicle` cannot be `fixed-wing`"), "{text}");
    assert!(load_with(&["map.kind=open", "targets.driving=static"]).is_ok());
}

#[test]
fn a_mission_without_labels_may_have_a_coarse_camera() {
    let coarse = ["camera.columns=40", "camera.rows=30"];
    let text = refused(load_with(&coarse));
    assert!(text.contains("too coarse"), "{text}");
    let loaded = other_with(&coarse).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let deep = other_with(&["camera.d_max_m=10000", "camera.tilt_deg=90"]).unwrap();
    assert!(deep.warnings.is_empty(), "{:?}", deep.warnings);
    assert!(refused(other_with(&["camera.aperture_deg=180"])).contains("below 180"));
}
