//! Ground stations in scenarios: where they may be, which agents they are, and what walls are to them.

use super::tests::{load_with, set_mistake};

const STATION: &str = "stations=[{x_m=0,y_m=0,z_m=2}]";

#[test]
fn a_station_needs_a_place() {
    for (set, message, expected) in [
        ("stations=[{x_m=0,y_m=0}]", "`stations[0]` lacks the key `z_m`", ""),
        ("stations=[{x_m=0,y_m=0,z_m=2,kind=1}]", "unknown key `kind` in [stations]", "`x_m`"),
        ("stations=3", "`stations` cannot be 3", "a list"),
        ("stations={x_m=0,y_m=0,z_m=2}", "`stations` cannot be a table", "`[[stations]]`"),
        ("agents.start={x_m=0,y_m=0}", "`agents.start` cannot be a table", "`[[agents.start]]`"),
        (
            "stations=[{x_m=0,y_m=0,z_m=2},{x_m=0,y_m=1251,z_m=2}]",
            "stations[1] cannot have y_m = 1251",
            "-1250 m to 1250 m",
        ),
        ("stations=[{x_m=0,y_m=0,z_m=-1}]", "stations[0] cannot have z_m = -1", "0 m to 1000 m"),
        ("stations=[{x_m=nan,y_m=0,z_m=1}]", "stations[0] cannot have x_m = NaN", "-1250 m to"),
    ] {
        let mistake = set_mistake(&[set]);
        assert!(mistake.contains(message) && mistake.contains(expected), "{set}: {mistake}");
    }
    let many = format!("stations=[{}]", ["{x_m=0,y_m=0,z_m=2}"; 65].join(","));
    let mistake = set_mistake(&[&many]);
    assert!(mistake.contains("65 stations beside 4 UAVs\n"), "{mistake}");
    assert!(mistake.contains("expected at most 64, and at most 1024 agents in all"), "{mistake}");
}

#[test]
fn a_building_is_no_place_for_a_station() {
    let world = load_with("helsinki-17", &[]).unwrap().world;
    let highest =
        world.obstacles().iter().max_by(|a, b| a.height_m.total_cmp(&b.height_m)).unwrap();
    let corner = highest.rings().next().unwrap()[0];
    let at =
        |z_m: f64| format!("stations=[{{x_m={:?},y_m={:?},z_m={z_m:?}}}]", corner[0], corner[1]);
    let inside = load_with("helsinki-17", &[&at(2.0)]).unwrap_err().mistakes[0].to_string();
    assert!(inside.contains(&format!("is inside a building, {}", highest.name)), "{inside}");
    assert!(inside.contains("--> --set"), "{inside}");
    let roof_m = highest.height_m;
    assert!(inside.contains(&format!("or its roof: z_m above {roof_m} m")), "{inside}");
    assert!(load_with("helsinki-17", &[&at(roof_m + 2.0)]).is_ok());
}

#[test]
fn stations_are_agents_after_the_uavs() {
    let outage = "netem.outage=[{agent=4,from_s=1}]";
    assert!(load_with("city", &["stations=[{x_m=-260,y_m=0,z_m=2}]", outage]).is_ok());
    let mistake = set_mistake(&[outage]);
    assert!(mistake.contains("an agent below 4, agents.count and stations, got 4"), "{mistake}");
    let groups = "netem.partition=[{groups=[[0],[5]]}]";
    let mistake = set_mistake(&["stations=[{x_m=-260,y_m=0,z_m=2}]", groups]);
    assert!(mistake.contains("an agent below 5, agents.count and stations, got 5"), "{mistake}");
}

/// A loss behind buildings that was asked for and that no link can have.
#[test]
fn walls_that_stand_in_no_way_are_told() {
    let walls = "netem.radio.propagation={obstruction_db=60}";
    let warnings = |sets: &[&str]| {
        let loaded = load_with("helsinki-17", sets).unwrap();
        loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let [told] = &warnings(&[walls])[..] else { panic!("one warning") };
    let expected = "`netem.radio.propagation.obstruction_db` can have no effect: there are no ground \
                    stations, and the highest building, ";
    assert!(told.contains(expected) && told.contains("--> --set"), "{told}");
    let none: [String; 0] = [];
    assert_eq!(warnings(&[walls, STATION]), none, "a station is behind walls");
    assert_eq!(warnings(&["netem.radio.propagation={obstruction_db=0}"]), none);
    assert_eq!(warnings(&["netem.radio.propagation={}"]), none, "nobody asked for it");
    let flat = &["map.built_share=0", walls, "stations=[{x_m=-260,y_m=0,z_m=2}]"];
    let told = load_with("city", flat).unwrap().warnings;
    assert!(told[0].to_string().contains("there are no buildings"), "{told:?}");
}
