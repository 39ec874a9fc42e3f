//! A mission that shows itself: the documents of `docs/topics.md`, without a network.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use csat_experiments::engine::{Engine, StepTrace};
use csat_experiments::metrics::{Coverage, StepRecord};
use csat_experiments::plug::Mission;
use csat_experiments::scenario::{self, Loaded, Request};
use csat_experiments::set_membership::SetMembership;
use csat_experiments::view::{Knowledge, Shapes, View};
use csat_experiments::watch::feed::Document;
use serde_json::{Value, json};

/// Flies a shipped scenario and writes down what it shows.
pub fn fly(name: &str, sets: &[&str], mut show: impl FnMut(Document)) {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    let loaded = scenario::load(Request { scenario: Some(name), sets: &sets, seed: None })
        .unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let mut say = |topic: String, time_s: f64, body: Value| {
        show(Document { topic, time_s, body: body.to_string().into() });
    };
    say("truth/town".to_owned(), 0.0, town(&loaded));
    let Loaded { scenario, world, .. } = loaded;
    let mission = SetMembership::new(&scenario);
    let mut engine = Engine::new(mission.clone(), world, &scenario.netem, scenario.seed);
    let mut coverage = Coverage::new(scenario.ground(), 1.0);
    let mut incarnations = vec![0; engine.seats().len()];
    for step in 0..=scenario.steps() {
        let time_s = f64::from(step) * scenario.run.period_s;
        let trace = engine.step();
        let stamp = |mut body: Value| {
            body["step"] = step.into();
            body["time_s"] = time_s.into();
            body
        };
        for (agent, event) in &trace.lives {
            let mut body = json!(event);
            body["agent"] = json!(agent);
            incarnations[usize::from(agent.0)] = body["incarnation"].as_u64().unwrap();
            say("truth/lives".to_owned(), time_s, stamp(body));
        }
        let locations: Vec<_> = engine.world().targets().iter().map(|t| t.location).collect();
        let rows = measure(&mission, &mut engine, &mut coverage, &locations);
        let poses = engine.world().poses();
        for (agent, seat) in engine.seats().iter().enumerate().filter(|(_, s)| s.is_alive()) {
            let footprint = mission.watched(&seat.agent).footprint;
            let pose = json!({"agent": agent, "incarnation": incarnations[agent],
                "p_world": poses[agent].p_world, "yaw_rad": poses[agent].yaw_rad,
                "footprint": footprint});
            let detected = mission.watched(&seat.agent).detected;
            let detected: Vec<u16> = detected.iter().map(|t| t.0).collect();
            let mut said = sets_of(&mission.view(&seat.agent), &detected);
            said.push(("pose", pose));
            said.push(("plan", plan(&poses[agent].p_world, poses[agent].yaw_rad)));
            let row = rows.iter().find(|r| usize::from(r.agent) == agent).unwrap();
            let tally = mission.tally(&seat.agent);
            said.push((
                "stats",
                json!({"identified": row.identified,
                "unexplored_pct": row.unexplored_pct, "hidden_pct": row.hidden_pct,
                "oem_iou_pct": row.oem_iou_pct, "vertices": row.vertices,
                "bytes_sent": row.bytes_sent, "rejected": tally.rejected,
                "withheld": tally.withheld}),
            ));
            said.push(("links", links(&trace, agent)));
            for (name, body) in said {
                say(format!("view/{agent}/{name}"), time_s, stamp(body));
            }
        }
        let targets: Vec<Value> = locations
            .iter()
            .enumerate()
            .map(|(j, l)| json!({"target": j, "location": l}))
            .collect();
        say("truth/targets".to_owned(), time_s, stamp(json!({"targets": targets})));
        let alive: Vec<bool> = engine.seats().iter().map(|s| s.is_alive()).collect();
        let violations = engine.monitor().counts().total();
        say("truth/metrics".to_owned(), time_s, stamp(metrics(&rows, &alive, violations)));
    }
}

/// Flies and keeps everything.
pub fn documents(name: &str, sets: &[&str]) -> Vec<Document> {
    let mut documents = Vec::new();
    fly(name, sets, |document| documents.push(document));
    documents
}

/// Writes documents down as `recording.mcap` in a folder.
pub fn record(folder: &Path, documents: &[Document]) {
    let file = std::fs::File::create(folder.join("recording.mcap")).unwrap();
    let options = mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4));
    let mut writer = options.create(std::io::BufWriter::new(file)).unwrap();
    let mut channels = BTreeMap::new();
    for Document { topic, time_s, body } in documents {
        let id = 1 + channels.len() as u16;
        let channel = channels.entry(topic).or_insert_with(|| {
            Arc::new(mcap::Channel {
                id,
                topic: topic.clone(),
                schema: None,
                message_encoding: "json".to_owned(),
                metadata: BTreeMap::new(),
            })
        });
        let log_time = (time_s * 1e9) as u64;
        let data = Cow::Borrowed(body.as_bytes());
        let message = mcap::Message {
            channel: channel.clone(),
            sequence: 0,
            log_time,
            publish_time: log_time,
            data,
        };
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
}

fn town(loaded: &Loaded) -> Value {
    let view = View::of_town(loaded);
    let buildings = view.obstacles.iter().map(|b| {
        json!({"type": "Feature", "geometry": {"type": "Polygon", "coordinates": b.rings},
            "properties": {"kind": "building", "height_m": b.height_m}})
    });
    let roads = view.roads.iter().map(|line| {
        json!({"type": "Feature", "geometry": {"type": "LineString", "coordinates": line},
            "properties": {"kind": "road"}})
    });
    let scenario = &loaded.scenario;
    json!({"type": "FeatureCollection", "features": buildings.chain(roads).collect::<Vec<_>>(),
        "size_m": view.size_m, "scenario": view.scenario, "seed": view.seed,
        "agents": scenario.agents.count, "targets": scenario.targets.count,
        "duration_s": scenario.run.duration_s, "period_s": scenario.run.period_s,
        "attribution": view.attribution})
}

fn feature(shapes: &Shapes, properties: Value) -> Value {
    json!({"type": "Feature", "properties": properties,
        "geometry": {"type": "MultiPolygon", "coordinates": shapes}})
}

fn collection(features: Vec<Value>) -> Value {
    json!({"type": "FeatureCollection", "features": features})
}

fn sets_of(knowledge: &Knowledge, detected: &[u16]) -> Vec<(&'static str, Value)> {
    let targets = knowledge.targets.iter().map(|(j, shapes)| {
        feature(shapes, json!({"kind": "target", "target": j, "detected": detected.contains(j)}))
    });
    vec![
        ("targets", collection(targets.collect())),
        (
            "unexplored",
            collection(vec![feature(&knowledge.unexplored, json!({"kind": "unexplored"}))]),
        ),
        (
            "obstacles",
            collection(vec![feature(&knowledge.obstacle_margin, json!({"kind": "obstacles"}))]),
        ),
        ("hidden", json!(knowledge.hidden)),
        ("oem", json!(knowledge.oem)),
    ]
}

fn plan([x, y, z]: &[f64; 3], yaw_rad: f64) -> Value {
    let poses = (1..=4).map(|i| {
        let yaw = yaw_rad + 0.2 * f64::from(i);
        let along = 10.0 * f64::from(i);
        json!({"p_world": [x + along * yaw.cos(), y + along * yaw.sin(), z], "yaw_rad": yaw})
    });
    json!({"poses": poses.collect::<Vec<_>>()})
}

fn links<E>(trace: &StepTrace<E>, agent: usize) -> Value {
    let mut heard: BTreeMap<(u16, &str), u64> = BTreeMap::new();
    for passage in trace.passages.iter().filter(|p| usize::from(p.sent.dst.0) == agent) {
        for copy in passage.fate.copies() {
            let outcome = match copy {
                Ok(delivery) if delivery.corrupted => "corrupted",
                Ok(_) => "delivered",
                Err(reason) => reason.name(),
            };
            *heard.entry((passage.sent.src.0, outcome)).or_default() += 1;
        }
    }
    let heard = heard.into_iter().map(|((src, outcome), count)| {
        json!({"src": src, "channel": 0, "outcome": outcome, "count": count})
    });
    json!({"heard": heard.collect::<Vec<_>>()})
}

fn measure(
    mission: &SetMembership,
    engine: &mut Engine<SetMembership>,
    coverage: &mut Coverage,
    locations: &[[f64; 2]],
) -> Vec<StepRecord> {
    let mut rows = Vec::new();
    for (agent, seat) in engine.seats_mut().iter_mut().enumerate().filter(|(_, s)| s.is_alive()) {
        let mut row = StepRecord {
            agent: agent as u16,
            bytes_sent: seat.bytes_sent,
            ..StepRecord::default()
        };
        mission.measure(&mut seat.agent, locations, &mut row);
        let watched = mission.watched(&seat.agent);
        if let Some(ground) = watched.clear_ground {
            coverage.add(&watched.footprint, ground);
        }
        rows.push(row);
    }
    let covered = coverage.finish_step();
    rows.iter_mut().for_each(|row| row.set_coverage(covered));
    rows
}

fn metrics(rows: &[StepRecord], alive: &[bool], violations: u64) -> Value {
    let mean = |of: &dyn Fn(&StepRecord) -> Option<f64>| {
        let values: Vec<f64> = rows.iter().filter_map(of).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    json!({
        "unexplored_pct": mean(&|r| Some(r.unexplored_pct)),
        "hidden_pct": mean(&|r| Some(r.hidden_pct)),
        "explored_pct": mean(&|r| Some(r.explored_pct)),
        "localization_error_m": mean(&|r| r.localization_error_m),
        "target_radius_m": mean(&|r| r.target_radius_m),
        "oem_iou_pct": mean(&|r| r.oem_iou_pct),
        "identified": mean(&|r| Some(f64::from(r.identified))),
        "identified_union": rows.iter().map(|r| r.identified).max(),
        "bytes_sent": mean(&|r| Some(r.bytes_sent as f64)),
        "violations": violations,
        "alive": alive,
    })
}
