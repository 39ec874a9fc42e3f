use std::fs;

use super::super::recording::tests::recorded;
use super::*;
use crate::testing::{scratch, small_mission};

#[test]
fn a_recording_reads_back_in_order() {
    let base = scratch("reads");
    let file = recorded(&base, small_mission(3.0), 1.0);
    let film = load(file.parent().unwrap()).unwrap();
    assert_eq!((film.run, film.scenario.as_str(), &film.warning), (RunId(1), "city", &None));
    assert_eq!(load(&file).unwrap(), film);
    let first = &film.documents[0].document;
    assert_eq!((first.topic.as_str(), first.encoding), ("truth/town", Encoding::GeoJson));
    assert!(film.documents.is_sorted_by_key(|recorded| recorded.time_ns));
    let topics: std::collections::BTreeSet<&str> =
        film.documents.iter().map(|r| r.document.topic.as_str()).collect();
    // Two agents' nine, the town, the layers, the columns, the cars and the metrics; nothing for viewers only.
    assert_eq!(topics.len(), 2 * 9 + 5, "{topics:?}");
    for Recorded { document, .. } in &film.documents {
        serde_json::from_str::<serde_json::Value>(&document.body).unwrap();
    }
}

#[test]
fn what_is_cut_off_is_read_as_far_as_it_is_whole() {
    let base = scratch("cut");
    let file = recorded(&base, small_mission(15.0), 0.5);
    let whole = load(&file).unwrap();
    let bytes = fs::read(&file).unwrap();
    let cut = base.join("cut.mcap");
    let mut counts = Vec::new();
    for share in [70, 40, 20] {
        fs::write(&cut, &bytes[..bytes.len() * share / 100]).unwrap();
        let film = load(&cut).unwrap();
        let count = film.documents.len();
        assert_eq!(film.documents, whole.documents[..count]);
        let warning = film.warning.unwrap();
        assert!(warning.contains("cut.mcap: MCAP file ended"), "{warning}");
        assert!(warning.contains(" s, which is whole"), "{warning}");
        counts.push(count);
    }
    assert!(counts.is_sorted_by(|a, b| a > b) && counts[2] > 0, "{counts:?}");
    // What a run leaves behind when it dies.
    let left = base.join("left");
    fs::create_dir(&left).unwrap();
    fs::rename(&cut, left.join("recording.mcap.tmp")).unwrap();
    assert_eq!(load(&left).unwrap().documents.len(), counts[2]);
}

#[test]
fn damage_is_noticed() {
    let base = scratch("damage");
    let file = recorded(&base, small_mission(15.0), 0.5);
    let (whole, bytes) = (load(&file).unwrap(), fs::read(&file).unwrap());
    let mut warnings = 0;
    for share in 3..8 {
        let mut damaged = bytes.clone();
        damaged[bytes.len() * share / 10] ^= 0x55;
        fs::write(&file, &damaged).unwrap();
        let film = load(&file).unwrap();
        // An index, which viewers use, has no part in what is read.
        assert!(film.warning.is_some() || film == whole, "{share}");
        warnings += u32::from(film.warning.is_some());
    }
    assert!(warnings > 0);
}

#[test]
fn mistakes_name_the_file_and_what_was_expected() {
    let base = scratch("mistakes");
    let error = |path: &Path| load(path).unwrap_err().to_string();
    assert_eq!(
        error(&base),
        format!(
            "{}: not found; expected a run flown with --record",
            base.join("recording.mcap").display()
        )
    );
    assert!(error(&base.join("nowhere")).ends_with("expected a run flown with --record"));
    let expected = "expected an MCAP file that `csat run --record` wrote";
    for (name, bytes) in [
        ("text", &b"this is text, and quite a lot of it"[..]),
        ("empty", b""),
        ("begun", b"\x89MCAP0\r\n"),
        ("short", b"\x89MCAP"),
    ] {
        let path = base.join(name);
        fs::write(&path, bytes).unwrap();
        let error = error(&path);
        assert!(error.contains(name) && error.ends_with(expected), "{error}");
    }
    let mut other = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    other.finish().unwrap();
    let path = base.join("other");
    fs::write(&path, other.into_inner().into_inner()).unwrap();
    assert!(error(&path).contains("it does not say which run it is of"), "{}", error(&path));
}
