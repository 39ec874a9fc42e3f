use std::collections::BTreeSet;
use std::path::PathBuf;

use mcap::{MessageStream, Summary};
use serde_json::Value;

use super::*;
use crate::flight::{self, RunOptions};
use crate::record::{RecordOptions, Recorder};
use crate::run_folder::Destination;
use crate::set_membership::SetMembership;
use crate::show::read::load;
use crate::testing::{Scratch, scratch, small_mission};

/// Flies a mission and returns where its recording is.
pub(in crate::show) fn recorded(base: &Scratch, loaded: Loaded, period_s: f64) -> PathBuf {
    let destination = Destination::Numbered(base.join("run"));
    let mut recorder =
        Recorder::create(&loaded, &RecordOptions { destination, quiet: true }).unwrap();
    let mission = SetMembership::new(&loaded.scenario);
    let folder = recorder.partial_folder().to_owned();
    let mut recording = Recording::create(&folder, mission, &loaded, period_s).unwrap();
    let options = RunOptions::default();
    let outcome = flight::run(loaded, &options, &mut recorder, &mut recording).unwrap();
    let bytes = recording.finish().unwrap();
    let file = recorder.finish(outcome).unwrap().folder.join(FILE);
    assert_eq!(file.metadata().unwrap().len(), bytes);
    file
}

#[test]
fn viewers_find_what_they_know_and_times_increase() {
    let base = scratch("viewers");
    let bytes = std::fs::read(recorded(&base, small_mission(5.0), 1.0)).unwrap();
    let mut schemas = BTreeSet::new();
    let (mut last_ns, mut map_times) = (0, Vec::new());
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        assert!(message.log_time >= last_ns && message.publish_time == message.log_time);
        last_ns = message.log_time;
        let channel = &message.channel;
        let schema = channel.schema.as_ref().expect("every channel has a schema");
        schemas.insert((channel.topic.clone(), schema.name.clone(), schema.encoding.clone()));
        if channel.topic == "/map" {
            map_times.push(message.log_time);
        }
    }
    assert_eq!(map_times, (0..=5).map(|s| s * 1_000_000_000).collect::<Vec<u64>>());
    for (topic, name, encoding) in [
        ("/map", "foxglove.GeoJSON", "protobuf"),
        ("/map/town", "foxglove.GeoJSON", "protobuf"),
        ("/scene", "foxglove.SceneUpdate", "protobuf"),
        ("/scene/town", "foxglove.SceneUpdate", "protobuf"),
        ("/tf", "foxglove.FrameTransforms", "protobuf"),
        ("/fix/1", "foxglove.LocationFix", "protobuf"),
        ("/metrics", "csat.TruthMetrics", "jsonschema"),
        ("view/1/pose", "csat.ViewPose", "jsonschema"),
        ("truth/town", "csat.TruthTown", "jsonschema"),
        ("truth/layers", "csat.TruthLayers", "jsonschema"),
    ] {
        let wanted = (topic.to_owned(), name.to_owned(), encoding.to_owned());
        assert!(schemas.contains(&wanted), "{wanted:?} of {schemas:#?}");
    }
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let attachment = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).unwrap();
    assert_eq!(attachment.name, "scenario.resolved.toml");
    assert_eq!(attachment.media_type, "application/toml");
    assert_eq!(&*attachment.data, small_mission(5.0).scenario.to_toml().as_bytes());
    let facts = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap().metadata;
    assert_eq!((facts["name"].as_str(), facts["seed"].as_str()), ("city", "1"));
    assert_eq!(facts["version"], env!("CARGO_PKG_VERSION"));
}

#[test]
fn equal_missions_have_equal_recordings() {
    let base = scratch("equal");
    let [a, b] = [(); 2].map(|()| std::fs::read(recorded(&base, small_mission(5.0), 1.0)).unwrap());
    assert!(a == b, "{} and {} bytes", a.len(), b.len());
}

#[test]
fn the_first_and_the_last_step_are_there_whatever_the_period() {
    let base = scratch("periods");
    for (period_s, expected) in [
        (0.1, vec![0.0, 0.5, 1.0, 1.5, 2.0, 2.5]),
        (1.0, vec![0.0, 1.0, 2.0, 2.5]),
        (60.0, vec![0.0, 2.5]),
    ] {
        let film = load(&recorded(&base, small_mission(2.5), period_s)).unwrap();
        let poses = film.documents.iter().filter(|r| r.document.topic == "view/0/pose");
        assert_eq!(poses.map(|r| r.time_s()).collect::<Vec<f64>>(), expected);
    }
}

#[test]
fn a_full_disk_is_named_with_the_file() {
    let base = scratch("full");
    let path = base.join(FILE);
    std::os::unix::fs::symlink("/dev/full", path.with_extension("mcap.tmp")).unwrap();
    let loaded = small_mission(1.0);
    let mission = SetMembership::new(&loaded.scenario);
    let error = Recording::create(&base, mission, &loaded, 1.0).err().unwrap().to_string();
    let expected = format!("cannot write `{}`: No space left on device", path.display());
    assert!(error.starts_with(&expected), "{error}");
    assert!(!path.exists());
}

#[test]
fn lives_are_told_as_they_end_and_begin_and_the_dead_show_nothing() {
    let base = scratch("lives");
    let mut loaded = small_mission(4.0);
    // Between recorded steps, too.
    let outage = r#"[[outage]]
agent = 1
from_s = 1.5
until_s = 3.5
kind = "crash""#;
    loaded.scenario.netem = toml::from_str(outage).unwrap();
    let film = load(&recorded(&base, loaded, 1.0)).unwrap();
    let bodies = |topic: &str| {
        let of_topic = film.documents.iter().filter(|r| r.document.topic == topic);
        of_topic.map(|r| serde_json::from_str(&r.document.body).unwrap()).collect::<Vec<Value>>()
    };
    let lives = bodies("truth/lives");
    let told =
        lives.iter().map(|l| (l["event"].as_str().unwrap(), &l["time_s"], &l["incarnation"]));
    let expected = [("crashed", &1.5.into(), &0.into()), ("restarted", &3.5.into(), &1.into())];
    assert_eq!(told.collect::<Vec<(&str, &Value, &Value)>>(), expected);
    let poses = bodies("view/1/pose");
    let seen = poses.iter().map(|p| (p["time_s"].as_f64().unwrap(), &p["incarnation"]));
    let expected = [(0.0, &0.into()), (1.0, &0.into()), (4.0, &1.into())];
    assert_eq!(seen.collect::<Vec<(f64, &Value)>>(), expected);
    assert_eq!(bodies("truth/metrics")[2]["alive"], serde_json::json!([true, false]));
}
