use geojson::{FeatureCollection, GeometryValue};
use serde_json::Value;

use crate::set_membership::SetMembership;
use crate::testing::small_mission;
use csat_mission::documents::{AgentStep, Document, Encoding, agent_documents, links};
use csat_mission::engine::{Engine, StepTrace};
use csat_mission::fleet::Passage;
use csat_mission::mission::Detail;
use csat_mission::mission::Mission;
use csat_netem::fate::{Delivery, Fate, Reason, Sent};
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::region::Region;
use csat_proto::time::SimTime;
use csat_proto::time::Step;

/// The mission and its last step, of which agents told all.
fn flown(steps: u32) -> (SetMembership, StepTrace<SetMembership>) {
    let loaded = small_mission(f64::from(steps) * 0.5);
    let mission = SetMembership::new(&loaded.scenario);
    let seed = loaded.scenario.seed;
    let mut engine = Engine::new(mission.clone(), loaded.world, &loaded.scenario.netem, seed);
    for _ in 0..steps {
        engine.step();
    }
    let Ok(trace) = engine.try_step(Detail::Full);
    (mission, trace)
}

fn of_agent(
    mission: &SetMembership,
    trace: &StepTrace<SetMembership>,
    index: usize,
) -> Vec<Document> {
    let step = AgentStep::of(&trace.flown[index], Incarnation(2), trace.step, 6.0).unwrap();
    let step = AgentStep { passages: &trace.passages, ..step };
    agent_documents(mission, &step, &mission.picture(step.report))
}

fn find<'a>(documents: &'a [Document], topic: &str) -> &'a Document {
    documents.iter().find(|d| d.topic == topic).unwrap_or_else(|| panic!("no {topic}"))
}

/// Area and corners of a MultiPolygon whose rings are closed and turned the right way.
fn measure(geometry: &GeometryValue) -> (f64, usize) {
    let GeometryValue::MultiPolygon { coordinates } = geometry else {
        panic!("{}", geometry.type_name())
    };
    let (mut area_m2, mut corners) = (0.0, 0);
    for polygon in coordinates {
        for (index, ring) in polygon.iter().enumerate() {
            assert_eq!(ring.first(), ring.last());
            assert!(ring.len() >= 4);
            let sides = ring.windows(2).map(|s| s[0][0] * s[1][1] - s[0][1] * s[1][0]);
            let signed = sides.sum::<f64>() / 2.0;
            assert_eq!(signed > 0.0, index == 0, "outer rings counter-clockwise, holes clockwise");
            area_m2 += signed;
            corners += ring.len() - 1;
        }
    }
    (area_m2, corners)
}

/// What is shown of a set is its own outline, moved by some millimetres.
fn assert_is(geometry: &GeometryValue, region: &Region) {
    let (area_m2, corners) = measure(geometry);
    let allowed_m2 = 0.5 + 0.01 * region.area_m2();
    assert!((area_m2 - region.area_m2()).abs() < allowed_m2, "{area_m2} of {}", region.area_m2());
    assert!(corners < 2 * region.vertex_count() + 8, "{corners} of {}", region.vertex_count());
}

#[test]
fn every_topic_is_there_and_says_whose_and_when() {
    let (mission, trace) = flown(12);
    for index in 0..2 {
        let documents = of_agent(&mission, &trace, index);
        let mut names: Vec<&str> = documents.iter().map(|d| d.topic.as_str()).collect();
        names.sort_unstable();
        let expected = [
            "hidden",
            "links",
            "obstacles",
            "oem",
            "plan",
            "pose",
            "stats",
            "targets",
            "unexplored",
        ];
        assert_eq!(names, expected.map(|name| format!("view/{index}/{name}")));
        for document in &documents {
            let value: Value = serde_json::from_str(&document.body).unwrap();
            assert_eq!(value["agent"], index, "{}", document.topic);
            assert_eq!((&value["incarnation"], &value["step"]), (&2.into(), &12.into()));
            assert_eq!(value["time_s"], 6.0);
            let is_geojson = document.encoding == Encoding::GeoJson;
            assert_eq!(value["type"] == "FeatureCollection", is_geojson);
        }
    }
}

#[test]
fn sets_are_the_agents_own() {
    let (mission, trace) = flown(40);
    let report = trace.flown[0].report.as_ref().unwrap();
    let documents = of_agent(&mission, &trace, 0);
    let collection = |name: &str| {
        let text = &find(&documents, &format!("view/0/{name}")).body;
        text.parse::<FeatureCollection>().unwrap().features
    };
    let unexplored = collection("unexplored");
    assert_is(&unexplored[0].geometry.as_ref().unwrap().value, &report.unexplored);
    let properties = unexplored[0].properties.as_ref().unwrap();
    assert!((properties["area_m2"].as_f64().unwrap() - report.unexplored.area_m2()).abs() < 1e-3);
    let obstacles = collection("obstacles");
    assert_is(&obstacles[0].geometry.as_ref().unwrap().value, &report.obstacle_margin);
    let targets = collection("targets");
    assert!(!targets.is_empty(), "the small mission finds a target in 20 s");
    for (feature, (target, set)) in targets.iter().zip(&report.targets) {
        assert_is(&feature.geometry.as_ref().unwrap().value, set);
        let properties = feature.properties.as_ref().unwrap();
        assert_eq!(properties["target"], target.0);
        assert_eq!(properties["detected"], report.detected.contains(target));
    }
    let maps = report.maps.as_ref().unwrap();
    let hidden: Value = serde_json::from_str(&find(&documents, "view/0/hidden").body).unwrap();
    let runs = hidden["runs"].as_array().unwrap().iter();
    let cells: u64 = runs.map(|run| run[2].as_u64().unwrap() - run[1].as_u64().unwrap()).sum();
    assert_eq!(cells, u64::from(maps.hidden.count()));
}

#[test]
fn maps_are_left_out_unless_they_were_told() {
    let (mission, mut trace) = flown(2);
    trace.flown[0].report.as_mut().unwrap().maps = None;
    let documents = of_agent(&mission, &trace, 0);
    assert_eq!(documents.len(), 7);
    assert!(documents.iter().all(|d| !d.topic.ends_with("hidden") && !d.topic.ends_with("oem")));
    trace.flown[0].report = None;
    assert!(AgentStep::of(&trace.flown[0], Incarnation(0), trace.step, 1.0).is_none());
}

#[test]
fn links_are_counted_by_what_became_of_messages() {
    let passage = |src: u16, dst: u16, first: Result<f64, Reason>, is_corrupted: bool| {
        let sent = Sent {
            src: AgentId(src),
            dst: AgentId(dst),
            incarnation: Incarnation(0),
            channel: ChannelId(0),
            sequence: 0,
            time: SimTime::from_seconds(3.0),
            bytes: 10,
            src_p_world: [0.0; 3],
            dst_p_world: [1.0; 3],
        };
        let at = |delay_s: f64| Delivery {
            at: SimTime::from_seconds(3.0 + delay_s),
            corrupted: is_corrupted,
        };
        Passage { sent, bytes: [].into(), fate: Fate { first: first.map(at), duplicate: None } }
    };
    let passages = [
        passage(1, 0, Ok(0.25), false),
        passage(1, 0, Ok(0.75), false),
        passage(1, 0, Ok(1.0), true),
        passage(2, 0, Err(Reason::Range), false),
        passage(2, 1, Err(Reason::Range), false),
    ];
    let step = AgentStep {
        agent: AgentId(0),
        incarnation: Incarnation(0),
        step: Step(6),
        time_s: 3.0,
        report: &(),
        passages: &passages,
        bytes_sent: 0,
    };
    assert_eq!(
        links(&step).body,
        r#"{"agent":0,"incarnation":0,"step":6,"time_s":3.0,"heard":["#.to_owned()
            + r#"{"src":1,"channel":0,"outcome":"corrupted","count":1,"delay_s":1.0},"#
            + r#"{"src":1,"channel":0,"outcome":"delivered","count":2,"delay_s":0.5},"#
            + r#"{"src":2,"channel":0,"outcome":"range","count":1}]}"#
    );
}
