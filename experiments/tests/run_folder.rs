//! What a mission leaves behind (docs/outputs.md).

mod common;

use std::path::Path;

use common::{SMALL, csat, json, names, read, scratch, small_run, text};

const FILES: [&str; 10] = [
    "csat.log",
    "events.jsonl",
    "links.csv",
    "map.svg",
    "metrics.csv",
    "metrics.svg",
    "provenance.json",
    "scenario.resolved.toml",
    "summary.json",
    "view.json",
];

#[test]
fn every_promised_file_is_there_and_can_be_read() {
    let base = scratch();
    let output = small_run(base.path(), &["--seed", "3"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    // The warning itself, and no bar where nobody sees it.
    let warned = text(&output.stderr);
    assert!(warned.starts_with("warning: 96 x 72 pixels are coarse"), "{warned}");
    assert!(warned.ends_with("cars are surely identified up to 91 m ahead\n"), "{warned}");
    let log = read(&base.path().join("runs/city-seed3/csat.log"));
    assert_eq!(log.trim_end(), warned.trim_end());
    let said = text(&output.stdout);
    assert!(said.starts_with("city seed 3: 5 s flown in "), "{said}");
    assert!(said.ends_with("\nruns/city-seed3\n"), "{said}");
    assert_eq!(names(&base.path().join("runs")), ["city-seed3"]);
    let folder = base.path().join("runs/city-seed3");
    assert_eq!(names(&folder), FILES);
    check_tables(&folder);
    let provenance = json(&folder.join("provenance.json"));
    for key in ["version", "git_revision", "git_dirty", "rustc", "arguments", "seed", "machine"] {
        assert!(provenance.get(key).is_some(), "{key}");
    }
    assert_eq!(provenance["arguments"][1], "run");
    assert_eq!(provenance["seed"], 3);
    for picture in ["map.svg", "metrics.svg"] {
        let svg = read(&folder.join(picture));
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{picture}");
        assert!(!svg.contains("NaN"), "{picture}");
    }
    let view = read(&folder.join("view.json"));
    assert_eq!(view.lines().count(), 1, "compact");
    let view = json(&folder.join("view.json"));
    assert_eq!(view["uavs"].as_array().map(Vec::len), Some(2));
    assert_eq!(view["uavs"][0]["path"].as_array().map(Vec::len), Some(11));
}

/// `metrics.csv` and `events.jsonl`.
fn check_tables(folder: &Path) {
    let mut metrics = csv::Reader::from_path(folder.join("metrics.csv")).unwrap();
    let header = metrics.headers().unwrap().clone();
    for column in ["step", "time_s", "agent", "unexplored_pct", "hidden_pct", "oem_iou_pct"] {
        assert!(header.iter().any(|c| c == column), "{column} in {header:?}");
    }
    let rows: Vec<csv::StringRecord> = metrics.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 11 * 2, "one row per step and agent, step 0 included");
    let events = read(&folder.join("events.jsonl"));
    assert!(events.contains("dentified"), "{events}");
    for line in events.lines() {
        let event: serde_json::Value = serde_json::from_str(line).expect(line);
        assert!(event.get("event").is_some() && event.get("step").is_some(), "{line}");
    }
}

#[test]
fn the_resolved_scenario_flies_the_same_mission() {
    let base = scratch();
    let first = small_run(base.path(), &["--out", "a", "--json", "--seed", "4"]);
    let again = csat(base.path(), &["run", "a/scenario.resolved.toml", "--out", "b", "--json"]);
    let digest = |bytes: &[u8]| {
        let summary: serde_json::Value = serde_json::from_slice(bytes).unwrap();
        summary["digest"].as_str().unwrap().to_owned()
    };
    assert_eq!(digest(&first.stdout), digest(&again.stdout));
    let other = small_run(base.path(), &["--out", "c", "--json", "--seed", "5"]);
    assert_ne!(digest(&first.stdout), digest(&other.stdout));
}

/// The folder holds the town that was flown over, under the name of the mission, however the file is
/// edited later and wherever the folder goes.
#[test]
fn a_town_of_ones_own_is_kept_with_its_run() {
    let base = scratch();
    let town = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/helsinki-05.geojson");
    let mine = base.path().join("mine.geojson");
    std::fs::copy(town, &mine).unwrap();
    let sets = ["--set", "map.file=mine.geojson", "--set", "map.size_m=[300, 300]"];
    let first = small_run(base.path(), &[&sets[..], &["--out", "first"]].concat());
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    let resolved = read(&base.path().join("first/scenario.resolved.toml"));
    assert!(resolved.contains("file = \"map.geojson\"\n"), "{resolved}");
    std::fs::remove_file(mine).unwrap();
    std::fs::create_dir(base.path().join("elsewhere")).unwrap();
    std::fs::rename(base.path().join("first"), base.path().join("elsewhere/moved")).unwrap();
    let again = csat(base.path(), &["run", "elsewhere/moved/scenario.resolved.toml"]);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    assert_eq!(names(&base.path().join("runs")), ["city-seed1"]);
    let digest =
        |folder: &str| json(&base.path().join(folder).join("summary.json"))["digest"].clone();
    assert_eq!(digest("elsewhere/moved"), digest("runs/city-seed1"));
}

#[test]
fn json_is_the_summary_with_the_folder_and_nothing_else() {
    let base = scratch();
    let output = small_run(base.path(), &["--json", "--out", "deep/er/out"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(
        text(&output.stderr).starts_with("warning: 96 x 72 pixels"),
        "for people, not programs"
    );
    let said = text(&output.stdout);
    let mut summary: serde_json::Value = serde_json::from_str(&said).unwrap();
    let folder = summary.as_object_mut().unwrap().remove("folder");
    assert_eq!(folder, Some("deep/er/out".into()));
    assert_eq!(summary, json(&base.path().join("deep/er/out/summary.json")));
    check_summary(&summary);
    assert_eq!(summary["steps"], 10);
    assert_eq!(summary["sim_s"], 5.0);
    assert_eq!(summary["interrupted"], false);
    assert_eq!(summary["violations"], 0);
}

/// Keys that outside checks rely on.
fn check_summary(summary: &serde_json::Value) {
    let numbers = ["seed", "agents", "targets", "steps", "violations", "inconsistencies"];
    let more = ["identified", "bytes_sent", "wall_s", "sim_s", "realtime_factor"];
    for key in numbers.iter().chain(&more) {
        assert!(summary[key].is_number(), "{key}: {summary}");
    }
    for key in ["scenario", "digest"] {
        assert!(summary[key].is_string(), "{key}: {summary}");
    }
    assert!(summary.get("all_identified_s").is_some());
    let shares =
        ["unexplored_pct", "hidden_pct", "explored_pct", "footprint_pct", "ground_seen_pct"];
    for means in [summary, &summary["final"]] {
        for key in shares {
            let share = means[key].as_f64().unwrap_or_else(|| panic!("{key}: {means}"));
            assert!((0.0..=100.0).contains(&share), "{key}: {share}");
        }
        for key in ["localization_error_m", "target_radius_m", "oem_iou_pct"] {
            assert!(means.get(key).is_some(), "{key}: {means}");
        }
    }
    let messages = &summary["messages"];
    assert!(messages["dropped"].is_object());
    for key in ["sent", "delivered", "duplicated"] {
        assert!(messages[key].is_number(), "{key}");
    }
    for stage in ["render", "sense", "estimate", "fuse", "guidance"] {
        for key in ["median", "p95", "max"] {
            assert!(summary["timing_ms"][stage][key].is_number(), "{stage} {key}");
        }
    }
}

#[test]
fn any_number_of_threads_flies_the_same_mission() {
    let base = scratch();
    let digests: Vec<String> = ["1", "2", "5"]
        .map(|threads| {
            let output = small_run(base.path(), &["--json", "--threads", threads]);
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            summary["digest"].as_str().unwrap().to_owned()
        })
        .to_vec();
    assert!(digests.iter().all(|d| *d == digests[0] && d.len() == 16), "{digests:?}");
    let runs = names(&base.path().join("runs"));
    assert_eq!(runs, ["city-seed1", "city-seed1-2", "city-seed1-3"], "a run overwrites nothing");
    let provenance = json(&base.path().join("runs/city-seed1-2/provenance.json"));
    assert_eq!(provenance["machine"]["threads"], 2);
}

#[test]
fn the_pictures_of_a_run_can_be_drawn_again() {
    let base = scratch();
    small_run(base.path(), &["--out", "out"]);
    let folder = base.path().join("out");
    let pictures = ["map.svg", "metrics.svg"];
    let before = pictures.map(|picture| read(&folder.join(picture)));
    for picture in pictures {
        std::fs::remove_file(folder.join(picture)).unwrap();
    }
    let output = csat(base.path(), &["plot", "out"]);
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
    assert_eq!(text(&output.stdout), "out/map.svg\nout/metrics.svg\n");
    assert!(pictures.map(|picture| read(&folder.join(picture))) == before, "other pictures");
    assert_eq!(names(&folder), FILES);
}

#[test]
fn what_another_agent_knows_can_be_drawn() {
    let base = scratch();
    small_run(base.path(), &["--out", "out"]);
    let folder = base.path().join("out");
    for (agent, name) in [("1", "map-agent-1.svg"), ("all", "map-agents.svg")] {
        let output = csat(base.path(), &["plot", "out", "--agent", agent]);
        assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
        assert_eq!(text(&output.stdout), format!("out/{name}\n"));
        assert!(read(&folder.join(name)).contains("UAV 1"));
    }
    let before = names(&folder);
    for (agent, expected) in [
        ("9", "error: --agent: got 9, expected `all` or an agent from 0 to 1"),
        (
            "x",
            "error: invalid value 'x' for '--agent <N|all>': expected the index of an agent, or all",
        ),
        ("-1", "error: "),
    ] {
        let output = csat(base.path(), &["plot", "out", "--agent", agent]);
        let said = text(&output.stderr);
        assert_eq!(
            (output.status.code(), text(&output.stdout)),
            (Some(2), String::new()),
            "{said}"
        );
        assert!(said.starts_with(expected), "{said}");
    }
    assert_eq!(names(&folder), before);
}

#[test]
fn plot_says_what_is_wrong_with_a_folder() {
    let base = scratch();
    small_run(base.path(), &["--out", "out"]);
    let summary = base.path().join("out/summary.json");
    let metrics = base.path().join("out/metrics.csv");
    let expect = |folder: &str, start: &str| {
        let output = csat(base.path(), &["plot", folder]);
        let said = text(&output.stderr);
        assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), String::new()));
        assert!(said.starts_with(&format!("error: cannot read `{start}")), "{said}");
        assert!(said.ends_with("; expected the folder of a finished run\n"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    };
    let map_before = read(&base.path().join("out/map.svg"));
    expect("nowhere", "nowhere/view.json`");
    expect("out/summary.json", "out/summary.json/view.json`");
    let rows = read(&metrics);
    std::fs::write(&metrics, rows.replacen("\n0,", "\nzero,", 1)).unwrap();
    expect("out", "out/metrics.csv`");
    std::fs::write(&metrics, "").unwrap();
    expect("out", "out/metrics.csv`");
    std::fs::write(&summary, "{ \"scenario\": 5 }").unwrap();
    expect("out", "out/summary.json`");
    std::fs::remove_file(&summary).unwrap();
    expect("out", "out/summary.json`");
    assert!(read(&base.path().join("out/map.svg")) == map_before, "nothing is drawn by halves");
}

/// The realistic way to read a stream that somebody stops reading.
#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let base = scratch();
    let shell = "\"$CSAT\" \"$@\" | true; exit \"${PIPESTATUS[0]}\"";
    let arguments = [&["-c", shell, "csat", "run"], SMALL].concat();
    let output = std::process::Command::new("bash")
        .args(arguments)
        .env("CSAT", env!("CARGO_BIN_EXE_csat"))
        .current_dir(base.path())
        .output()
        .expect("bash starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(!text(&output.stderr).contains("panic"), "{}", text(&output.stderr));
    assert_eq!(names(&base.path().join("runs/city-seed1")), FILES);
}

/// What links damage is not believed, often and by everybody: the terminal gets the sum, the log the rest.
#[test]
fn messages_that_are_not_believed_are_summed_up() {
    let base = scratch();
    let output = small_run(base.path(), &["--set", "netem.radio.corruption=0.5", "--out", "out"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    assert!(!said.contains("dropped") && !said.contains("checksum"), "{said}");
    let rejected = json(&base.path().join("out/summary.json"))["messages"]["rejected"].clone();
    // One that is damaged in its first bytes is no envelope at all.
    let rejected = rejected.as_object().expect("some were damaged");
    let count: u64 = rejected.values().filter_map(serde_json::Value::as_u64).sum();
    let reasons: Vec<String> = rejected.iter().map(|(why, n)| format!("{why} {n}")).collect();
    assert!(rejected.contains_key("checksum") && count > 5, "{reasons:?}");
    let sum = format!(" ({count} not believed: {}; see csat.log)", reasons.join(", "));
    assert!(text(&output.stdout).contains(&sum), "{}", text(&output.stdout));
    let log = read(&base.path().join("out/csat.log"));
    assert!(log.contains("dropped") && log.contains("checksum"), "{log}");
}
