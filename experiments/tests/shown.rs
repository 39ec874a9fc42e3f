//! What people get to see of whole missions is valid: polygons by OGC Simple Features, documents by their
//! JSON Schemas. Judged here, and by shapely and jsonschema where Python has them.

mod common;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use common::{csat, json, scratch, text};
use geo::{Coord, LineString, Polygon, Validation};
use mcap::MessageStream;
use serde_json::{Value, json};

/// A message of a recording: its topic, its JSON Schema if it has one, and what it says.
struct Message {
    topic: String,
    schema: Option<Value>,
    body: Value,
}

/// The text of a `foxglove.GeoJSON` message, a protobuf of one string.
fn geojson_text(data: &[u8]) -> &[u8] {
    let length = data[1..].iter().position(|byte| byte & 0x80 == 0).expect("a length");
    &data[1 + length + 1..]
}

/// Everything JSON in a recording.
fn messages(recording: &Path) -> Vec<Message> {
    let bytes = std::fs::read(recording).unwrap();
    let mut schemas: BTreeMap<String, Value> = BTreeMap::new();
    let mut messages = Vec::new();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let topic = message.channel.topic.clone();
        let schema = message.channel.schema.as_ref().expect("a schema");
        if schema.encoding == "jsonschema" {
            let schema = schemas
                .entry(topic.clone())
                .or_insert_with(|| serde_json::from_slice(&schema.data).unwrap());
            let body = serde_json::from_slice(&message.data).unwrap();
            messages.push(Message { topic, schema: Some(schema.clone()), body });
        } else if schema.name == "foxglove.GeoJSON" {
            let body = serde_json::from_slice(geojson_text(&message.data)).unwrap();
            messages.push(Message { topic, schema: None, body });
        }
    }
    messages
}

/// What is wrong with a value by a schema of the kind that recordings have: types, properties, items
/// and what is required.
fn schema_flaw(schema: &Value, value: &Value) -> Option<String> {
    let is_right = match schema["type"].as_str().expect("every schema has a type") {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        other => panic!("viewers do not know the type {other}"),
    };
    if !is_right {
        return Some(format!("{value} is no {}", schema["type"]));
    }
    let required = schema["required"].as_array().into_iter().flatten();
    for name in required.map(|name| name.as_str().unwrap()) {
        if value.get(name).is_none() {
            return Some(format!("no `{name}`"));
        }
    }
    let properties = schema["properties"].as_object().into_iter().flatten();
    let mut members =
        properties.filter_map(|(name, of)| Some((name, schema_flaw(of, value.get(name)?)?)));
    if let Some((name, flaw)) = members.next() {
        return Some(format!("{name}: {flaw}"));
    }
    let items = schema.get("items")?;
    value.as_array()?.iter().find_map(|item| schema_flaw(items, item))
}

fn ring(positions: &Value) -> LineString {
    let number = |value: &Value| value.as_f64().expect("a number");
    let coord = |p: &Value| Coord { x: number(&p[0]), y: number(&p[1]) };
    LineString(positions.as_array().expect("a ring").iter().map(coord).collect())
}

fn polygon(rings: &Value) -> Polygon {
    let mut rings = rings.as_array().expect("a polygon").iter().map(ring);
    let outer = rings.next().expect("an outer ring");
    Polygon::new(outer, rings.collect())
}

/// The polygons of a GeoJSON document, feature by feature.
fn polygons(body: &Value) -> Vec<Vec<Polygon>> {
    let features = body["features"].as_array().into_iter().flatten();
    let shapes = features.filter_map(|feature| {
        let geometry = &feature["geometry"];
        let coordinates = &geometry["coordinates"];
        match geometry["type"].as_str()? {
            "Polygon" => Some(vec![polygon(coordinates)]),
            "MultiPolygon" => Some(coordinates.as_array()?.iter().map(polygon).collect()),
            _ => None,
        }
    });
    shapes.collect()
}

fn polygon_flaw(shapes: &[Polygon]) -> Option<String> {
    geo::MultiPolygon(shapes.to_vec()).check_validation().err().map(|flaw| flaw.to_string())
}

/// The sets and buildings of `view.json`, each as GeoJSON has it.
fn drawn(view: &Value) -> Vec<Value> {
    let closed = |ring: &Value| {
        let mut ring = ring.as_array().unwrap().clone();
        ring.push(ring[0].clone());
        Value::Array(ring)
    };
    let rings =
        |rings: &Value| Value::Array(rings.as_array().unwrap().iter().map(closed).collect());
    let shapes =
        |shapes: &Value| Value::Array(shapes.as_array().unwrap().iter().map(rings).collect());
    let buildings = view["obstacles"].as_array().unwrap().iter();
    let mut all: Vec<Value> = buildings.map(|b| json!([rings(&b["rings"])])).collect();
    let agents = view["agents"].as_array().unwrap().iter();
    for layer in agents.flat_map(|layers| layers.as_array().unwrap()) {
        let areas = layer["areas"].as_array().into_iter().flatten();
        all.extend(areas.map(|area| shapes(&area["shapes"])));
    }
    let feature = |shapes| json!({"geometry": {"type": "MultiPolygon", "coordinates": shapes}});
    all.into_iter().map(feature).collect()
}

const PYTHON: &str = "
import json, sys
import jsonschema, shapely
from shapely.geometry import shape
validators, polygons, messages = {}, 0, 0
for line in open(sys.argv[1]):
    message = json.loads(line)
    topic, schema, body = message['topic'], message['schema'], message['body']
    if schema is not None:
        if topic not in validators:
            jsonschema.Draft202012Validator.check_schema(schema)
            validators[topic] = jsonschema.Draft202012Validator(schema)
        validators[topic].validate(body)
        messages += 1
    for feature in body.get('features', []) if isinstance(body, dict) else []:
        if feature['geometry']['type'] in ('Polygon', 'MultiPolygon'):
            geometry = shape(feature['geometry'])
            assert geometry.is_valid, (topic, shapely.is_valid_reason(geometry))
            polygons += 1
print(messages, polygons)
";

/// Lets Python judge the same, if it can: as many messages and features as here.
fn judge_elsewhere(folder: &Path, messages: &[Message], expected: (usize, usize)) {
    let Some(python) = common::python(&["shapely", "jsonschema"], "shapely jsonschema") else {
        return;
    };
    let mut lines = String::new();
    for Message { topic, schema, body } in messages {
        let line = json!({ "topic": topic, "schema": schema, "body": body });
        writeln!(lines, "{line}").unwrap();
    }
    let file = folder.join("messages.jsonl");
    std::fs::write(&file, lines).unwrap();
    let output = Command::new(python).args(["-c", PYTHON]).arg(&file).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout).trim(), format!("{} {}", expected.0, expected.1));
}

/// Flies and records a mission, and judges all that is shown of it.
fn judge(sets: &[&str]) {
    let base = scratch();
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments = ["run", "city", "--record=1", "--out", "run", "--set", "run.duration_s=40"];
    let arguments: Vec<&str> = arguments.into_iter().chain(sets).collect();
    let flown = csat(base.path(), &arguments);
    assert_eq!(flown.status.code(), Some(0), "{}", text(&flown.stderr));
    let folder = base.path().join("run");
    let mut messages = messages(&folder.join("recording.mcap"));
    let features = drawn(&json(&folder.join("view.json")));
    let body = json!({ "features": features });
    messages.push(Message { topic: "view.json".to_owned(), schema: None, body });
    let (mut with_schema, mut features) = (0, 0);
    for Message { topic, schema, body } in &messages {
        if let Some(schema) = schema {
            with_schema += 1;
            if let Some(flaw) = schema_flaw(schema, body) {
                panic!("{topic}: {flaw}\n{body}");
            }
        }
        for shapes in polygons(body) {
            features += 1;
            if let Some(flaw) = polygon_flaw(&shapes) {
                panic!("{topic}: {flaw}\n{shapes:?}");
            }
        }
    }
    assert!(with_schema > 500 && features > 500, "{with_schema} {features}");
    judge_elsewhere(base.path(), &messages, (with_schema, features));
}

#[test]
fn what_is_shown_of_slow_cars_is_valid() {
    judge(&[]);
}

#[test]
fn what_is_shown_of_fast_cars_is_valid() {
    judge(&["targets.v_max_m_s=5"]);
}

/// Agents that are down, links that lose: what is not defined is absent.
#[test]
fn what_is_shown_in_a_storm_is_valid() {
    let crash = "netem.outage=[{agent=1,from_s=5,until_s=20,kind=\"crash\"}]";
    judge(&["netem.radio.range_m=100", crash, "targets.count=3"]);
}

#[test]
fn flaws_are_found() {
    let texts = json!({ "type": "array", "items": { "type": "string" } });
    let properties = json!({ "a": { "type": "number" }, "b": texts });
    let schema = json!({ "type": "object", "properties": properties, "required": ["a"] });
    assert_eq!(schema_flaw(&schema, &json!({"a": 1, "b": ["x"]})), None);
    assert_eq!(schema_flaw(&schema, &json!({"b": []})), Some("no `a`".to_owned()));
    assert_eq!(
        schema_flaw(&schema, &json!({"a": null})),
        Some("a: null is no \"number\"".to_owned())
    );
    assert!(schema_flaw(&schema, &json!({"a": 1, "b": [2]})).is_some());
    let bow = json!([[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]]);
    assert!(polygon_flaw(&[polygon(&bow)]).is_some());
}
