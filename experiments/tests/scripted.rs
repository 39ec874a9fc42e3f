//! Missions that begin where the user says, with cars that do what the user says.

mod common;

use std::path::Path;

use common::{SMALL, csat, json, names, read, scratch, text};

const TRACKS: &str = "\
# Car 0 drives east and then north, car 1 arrives at 2 s, car 2 is parked.
target,time_s,x_m,y_m
0,0,-20,-30
0,3,-17,-30
1,2,30,20
0,5,-17,-28.5

1,6,30,16.5
2,0,50,-50
";

/// A town without buildings, so that any place will do.
const OPEN: &[&str] = &["--set", "map.built_share=0", "--set", "targets.count=3"];

fn digest(folder: &Path) -> String {
    json(&folder.join("summary.json"))["digest"].as_str().unwrap().to_owned()
}

#[test]
fn cars_follow_their_tracks_in_one_process_and_in_many_and_again() {
    let base = scratch();
    let folder = base.path();
    std::fs::write(folder.join("cars.csv"), TRACKS).unwrap();
    let tracks = ["--set", "targets.tracks=cars.csv"];
    let fly = |command: &str, out: &str| {
        let output = csat(folder, &[&[command, "--out", out], SMALL, OPEN, &tracks].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    };
    fly("run", "flown");
    let view = json(&folder.join("flown/view.json"));
    // By step of half a second.
    for (target, step, location) in [
        (0, 0, [-20.0, -30.0]),
        (0, 3, [-18.5, -30.0]),
        (0, 10, [-17.0, -28.5]),
        (1, 4, [30.0, 20.0]),
        (1, 10, [30.0, 17.375]),
        (2, 10, [50.0, -50.0]),
    ] {
        assert_eq!(view["targets"][target][step], serde_json::json!(location), "{target} {step}");
    }
    assert_eq!(json(&folder.join("flown/summary.json"))["violations"], 0);
    fly("spawn", "spawned");
    assert_eq!(digest(&folder.join("spawned")), digest(&folder.join("flown")));
    // The folder has all that it takes, wherever it goes and whatever becomes of the file.
    assert_eq!(read(&folder.join("flown/tracks.csv")), TRACKS);
    std::fs::remove_file(folder.join("cars.csv")).unwrap();
    std::fs::create_dir(folder.join("elsewhere")).unwrap();
    std::fs::rename(folder.join("flown"), folder.join("elsewhere/flown")).unwrap();
    let again = csat(folder, &["run", "elsewhere/flown/scenario.resolved.toml", "--out", "again"]);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    assert_eq!(digest(&folder.join("again")), digest(&folder.join("spawned")));
    let driving = csat(folder, &[&["run", "--out", "driving"], SMALL, OPEN].concat());
    assert_eq!(driving.status.code(), Some(0));
    assert_ne!(digest(&folder.join("driving")), digest(&folder.join("again")));
}

/// A building of about 11 m x 22 m around the middle.
const YARD: &str = r#"{"type": "FeatureCollection", "center": [24.94, 60.17], "features": [
    {"type": "Feature", "id": "way/7", "properties": {"building": "yes"}, "geometry":
    {"type": "Polygon", "coordinates": [[[24.9399, 60.1699], [24.9401, 60.1699],
    [24.9401, 60.1701], [24.9399, 60.1701], [24.9399, 60.1699]]]}}]}"#;

/// Rows, and what is said of them.
const BREACHES: &[(&str, &[&str])] = &[
    (
        "0,0,-40,30\n0,10,-29,30\n",
        &["car 0 drives at 1.100 m/s", "--> cars.csv:3:1", "v_max_m_s = 1"],
    ),
    (
        "0,0,-40,0\n0,90,40,0\n",
        &["within 0.000 m of the building", "way/7", "--> cars.csv:3:1", "2.5 m"],
    ),
    (
        "0,0,-40,-70\n0,9,-40,-74\n",
        &["leaves the region at (-40, -74)", "--> cars.csv:3:1", "±72.5 m"],
    ),
    (
        "0,0,-40,30\n1,0,40,34\n0,80,40,30\n1,80,-40,34\n",
        &["car 1 comes within 4.000 m of car 0 at 40.000 s", "--> cars.csv:5:1", "8 m"],
    ),
    ("0,5,-40,30\n0,5,-40,31\n", &["car 0 is here at 5 s, after a row at 5 s", "--> cars.csv:3:1"]),
    (
        "0,0,-40,30\n2,0,40,30\n",
        &["there is a car 2, and none with the number 1", "--> cars.csv:3:1"],
    ),
    ("0,0,-40,north\n", &["a row cannot be `0,0,-40,north`", "--> cars.csv:2:1"]),
    ("0,0,-40\n", &["a row cannot be `0,0,-40`", "--> cars.csv:2:1", "three numbers"]),
    ("0,-1,-40,30\n", &["`time_s` cannot be -1", "--> cars.csv:2:1"]),
];

#[test]
fn every_breach_of_the_model_is_named_before_anything_flies() {
    let base = scratch();
    let folder = base.path();
    std::fs::write(folder.join("yard.geojson"), YARD).unwrap();
    let town = ["--set", "map.file=yard.geojson", "--set", "map.size_m=[150, 150]"];
    let tracks = ["--set", "targets.tracks=cars.csv"];
    for command in ["check", "run"] {
        for (rows, parts) in BREACHES {
            std::fs::write(folder.join("cars.csv"), format!("target,time_s,x_m,y_m\n{rows}"))
                .unwrap();
            let output = csat(folder, &[&[command], &town[..], &tracks].concat());
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{rows}{said}");
            assert_eq!(said.matches("error: ").count(), 1, "{rows}{said}");
            for part in *parts {
                assert!(said.contains(part), "{part} in {said}");
            }
        }
    }
    assert_eq!(names(folder), ["cars.csv", "yard.geojson"], "nothing was run");
}

#[test]
fn files_and_counts_that_do_not_fit_are_refused() {
    let base = scratch();
    let folder = base.path();
    std::fs::write(folder.join("cars.csv"), "target,time_s,x_m,y_m\n0,0,-40,30\n").unwrap();
    std::fs::write(folder.join("columns.csv"), "car,t,x,y\n0,0,-40,30\n").unwrap();
    let many: String = (0..99).map(|k| format!("0,{k},{},0\n", 5 * (k % 2))).collect();
    std::fs::write(folder.join("many.csv"), format!("target,time_s,x_m,y_m\n{many}")).unwrap();
    std::fs::write(folder.join("own.toml"), "[targets]\ntracks = \"cars.csv\"\ncount = 2\n")
        .unwrap();
    let open = ["--set", "map.built_share=0"];
    let cases: [(&[&str], &[&str]); 6] = [
        (
            &["--set", "targets.tracks=cars.csv", "--set", "targets.driving=evasive"],
            &["`targets.driving` cannot be `evasive` with targets.tracks", "--> --set"],
        ),
        (&["--set", "targets.tracks=no.csv"], &["cannot read the tracks `no.csv`", "--> --set"]),
        (
            &["--set", "targets.tracks=columns.csv"],
            &["columns `car,t,x,y`", "target,time_s,x_m,y_m"],
        ),
        (&["--set", "targets.tracks=many.csv"], &["drives at 5.000 m/s", "78 more of 98 mistakes"]),
        (
            &["own.toml"],
            &["`targets.count` cannot be 2", "1, the number of cars", "--> own.toml:3:9"],
        ),
        (
            &["--set", "targets.tracks=cars.csv", "--set", "targets.count=3"],
            &["`targets.count` cannot be 3", "--> --set"],
        ),
    ];
    for (arguments, parts) in cases {
        let output = csat(folder, &[&["check"], arguments, &open].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        for part in parts {
            assert!(said.contains(part), "{part} in {said}");
        }
    }
    // The city's own number of cars is not beside the tracks of the command line.
    let output =
        csat(folder, &[&["check", "city", "--set", "targets.tracks=cars.csv"], &open[..]].concat());
    assert!(text(&output.stdout).contains("1 target,"), "{}", text(&output.stderr));
}

#[test]
fn uavs_start_where_the_scenario_says() {
    let base = scratch();
    let folder = base.path();
    let start = |out: &str, start: &str| {
        let set = format!("agents.start={start}");
        let output = csat(folder, &[&["run", "--out", out, "--set", &set], SMALL].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let view = json(&folder.join(out).join("view.json"));
        [0, 1].map(|uav| view["uavs"][uav]["path"][0].clone())
    };
    let each = start("each", "[{x_m=10,y_m=-20,yaw_deg=90},{x_m=30,y_m=40}]");
    assert_eq!(each, [serde_json::json!([10.0, -20.0]), serde_json::json!([30.0, 40.0])]);
    assert_eq!(
        start("base", "[{x_m=-5,y_m=6.5}]"),
        [(); 2].map(|()| serde_json::json!([-5.0, 6.5]))
    );
    let resolved = ["run", "each/scenario.resolved.toml", "--out", "again"];
    assert_eq!(csat(folder, &resolved).status.code(), Some(0));
    assert_eq!(digest(&folder.join("again")), digest(&folder.join("each")));
    for (start, parts) in [
        ("[{x_m=1,y_m=1},{x_m=2,y_m=2}]", ["2 poses for 4 UAVs", "one that is the base of all"]),
        ("[{x_m=2000,y_m=1}]", ["`agents.start[0].x_m` cannot be 2000", "from -1250 to 1250 m"]),
        ("[{x_m=0,y_m=nan}]", ["`agents.start[0].y_m` cannot be NaN", "--> --set"]),
        ("[{x_m=0,y_m=0,yaw_deg=361}]", ["`agents.start[0].yaw_deg` cannot be 361", "-360 to 360"]),
        ("[{x_m=0}]", ["lacks the key `y_m`", "--> --set"]),
        ("[{x_m=0,y_m=0,z_m=9}]", ["unknown key `z_m`", "expected one of `x_m`"]),
    ] {
        let output = csat(folder, &["check", "--set", &format!("agents.start={start}")]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        for part in parts {
            assert!(said.contains(part), "{part} in {said}");
        }
    }
}
