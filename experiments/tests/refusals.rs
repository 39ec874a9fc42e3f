//! Bad input, and systems that refuse: exit codes, messages, and nothing half-written.

mod common;

use std::path::Path;
use std::process::Command;

use common::{SMALL, csat, names, scratch, small_run, text};

/// The bad files that the cases below name.
fn write_bad_files(folder: &Path) {
    let collection = |members: &str| format!("{{\"type\": \"FeatureCollection\", {members}}}");
    let building = |coordinates: &str| {
        collection(&format!(
            "\"features\": [{{\"type\": \"Feature\", \"id\": \"way/7\", \"properties\": \
             {{\"building\": \"yes\"}}, \"geometry\": {coordinates}}}]"
        ))
    };
    let projected = "{\"type\": \"Polygon\", \"coordinates\": [[[385000, 6671000], [385010, \
                     6671000], [385010, 6671010], [385000, 6671000]]]}";
    // One line with a fault far from its ends.
    let long = building(projected).replacen("way/7\",", &format!("{}\"", "7".repeat(5000)), 1);
    let degrees =
        "{\"type\": \"Polygon\", \"coordinates\": [[[24, 60], [25, 60], [25, 61], [24, 60]]]}";
    let plain = building(degrees).replace("\"building\": \"yes\"", "");
    let name =
        "\"crs\": {\"type\": \"name\", \"properties\": {\"name\": \"EPSG:3067\"}}, \"features\"";
    let crs = building(projected).replacen("\"features\"", name, 1);
    let files = [
        ("syntax.toml", "seed = = 1\n".to_owned()),
        ("unknown.toml", "[agents]\nspeed = 3\n".to_owned()),
        ("type.toml", "seed = 'one'\n".to_owned()),
        ("both.toml", "[map]\nkind = 'generated'\nfile = 'empty.geojson'\n".to_owned()),
        ("cut.geojson", "{\"type\": ".to_owned()),
        ("topology.geojson", "{\"type\": \"Topology\"}".to_owned()),
        ("long.geojson", long),
        ("plain.geojson", plain),
        ("crs.geojson", crs),
        ("projected.geojson", building(projected)),
        ("typo.geojson", building("{\"type\": \"Polygone\", \"coordinates\": []}")),
        ("center.geojson", collection("\"center\": \"Helsinki\", \"features\": []")),
        ("empty.geojson", collection("\"features\": []")),
    ];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    std::fs::write(folder.join("latin1.toml"), b"# caf\xe9\nseed = 1\n").unwrap();
    std::fs::create_dir(folder.join("folder")).unwrap();
}

/// Arguments after `run` or `check`, what is wrong, and where.
const MISTAKES: &[(&[&str], &str, &str)] = &[
    (&["hellsinki-05"], "there is no scenario `hellsinki-05`", "did you mean `helsinki-05`?"),
    (&["folder"], "cannot read the scenario `folder`", "expected a TOML file"),
    (&["latin1.toml"], "cannot read the scenario `latin1.toml`", "UTF-8"),
    (&["syntax.toml"], "not TOML: ", "--> syntax.toml:1:"),
    (&["unknown.toml"], "unknown key `speed` in [agents]", "--> unknown.toml:2:1"),
    (&["type.toml"], "`seed` cannot be \"one\"", "--> type.toml:1:8"),
    (&["both.toml"], "`map.file` cannot be `", "--> both.toml:3:8"),
    (&["--set", "agents.count"], "this is not an assignment", " | agents.count\n"),
    (&["--set", "agents.count=many"], "`agents.count` cannot be \"many\"", "a whole number"),
    (&["--set", "agents.count=0"], "`agents.count` cannot be 0", "from 1 to 1024"),
    (&["--set", "guidance.criterion=str9"], "`guidance.criterion` cannot be `str9`", "`str3`"),
    (&["--set", "guidance.criterion=str9"], "`guidance.criterion` cannot be `str9`", "`lawnmower`"),
    (&["--set", "guidance.str4.beem=9"], "unknown key `beem`", "did you mean `beam`?"),
    (&["--set", "netem.radio.loss.p=2"], "netem.radio.loss", "got 2"),
    (&["--set", "map.size_m=[10, 10]"], "`map.size_m` cannot be [10, 10]", "from 20 to"),
    (&["--set", "map.built_share=0.9"], "map.built_share: got 0.9", "expected at most"),
    (&["--set", "map.file=no.geojson"], "there is no map `no.geojson`", "--> --set"),
    (&["--set", "map.file=folder"], "cannot read the map `folder`", "a GeoJSON file"),
    (
        &["--set", "map.file=cut.geojson"],
        "the map cut.geojson is not JSON: EOF",
        "--> cut.geojson:1:9",
    ),
    (&["--set", "map.file=long.geojson"], "the map long.geojson is not JSON: ", "long.geojson:1:5"),
    (&["--set", "map.file=topology.geojson"], "topology.geojson: got a Topology", "Collection"),
    (&["--set", "map.file=projected.geojson"], "projected.geojson: 1 feature(s) have", "degrees"),
    (&["--set", "map.file=crs.geojson"], "crs.geojson: crs: the file is in EPSG:3067", "ogr2ogr"),
    (&["--set", "map.file=plain.geojson"], "1 polygon(s) without a `building` tag", "map.untagged"),
    (&["--set", "map.untagged=ignore"], "`map.untagged` cannot be set with kind", "\"geojson\""),
    (&["--set", "map.untagged=houses"], "`map.untagged`", "`ignore`"),
    (&["cut.geojson"], "`cut.geojson` is JSON", "`--set map.file=cut.geojson`"),
    (&["--set", "map.file=typo.geojson"], "typo.geojson: feature 0 (way/7)", "RFC 7946"),
    (&["--set", "map.file=center.geojson"], "center.geojson: center: got \"Helsinki\"", "degrees"),
    (
        &["--set", "map.file=empty.geojson"],
        "0 of 8 cars found room on 0 m",
        "a map with more roads",
    ),
    (
        &["--set", "map.size_m=[120, 120]", "--set", "targets.count=900"],
        "of 900 cars found room",
        "targets.count=900",
    ),
    (
        &["--set", "camera.columns=24", "--set", "camera.rows=18"],
        "24 x 18 pixels are too coarse",
        "min_pixels",
    ),
    (&["--set", "agents.altitude_m=40"], "`agents.altitude_m` cannot be 40", "highest building"),
];

#[test]
fn every_class_of_mistake_is_exit_code_2_and_says_where() {
    let base = scratch();
    write_bad_files(base.path());
    let before = names(base.path());
    for (arguments, what, place) in MISTAKES {
        for command in ["check", "run"] {
            let output = csat(base.path(), &[&[command], *arguments].concat());
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
            assert_eq!(text(&output.stdout), "", "{arguments:?}");
            assert!(said.starts_with("error: "), "{arguments:?}: {said}");
            assert!(said.lines().all(|line| line.chars().count() < 600), "{arguments:?}: {said}");
            assert!(said.contains(what) && said.contains(place), "{arguments:?}: {said}");
            // Nobody expects a check to run anything.
            let is_flight = command == "run";
            assert_eq!(said.ends_with(": nothing was run\n"), is_flight, "{arguments:?}: {said}");
        }
    }
    assert_eq!(names(base.path()), before, "nothing was run");
}

#[test]
fn what_cannot_become_a_run_folder_is_refused_before_the_flight() {
    let base = scratch();
    std::fs::create_dir(base.path().join("taken")).unwrap();
    std::fs::create_dir(base.path().join("empty")).unwrap();
    std::fs::write(base.path().join("taken/mine"), "precious").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("empty", base.path().join("link")).unwrap();
    let before = names(base.path());
    for (out, reason) in [
        ("taken", "exists and is not empty: a run never overwrites anything"),
        ("taken/mine", "is not a folder"),
        #[cfg(unix)]
        ("link", "is not a folder"),
        (".", "exists and is not empty"),
        ("empty/..", "exists and is not empty"),
        ("nowhere/..", "has no name of its own that a run folder could get"),
    ] {
        let output = small_run(base.path(), &["--out", out]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{out}: {said}");
        assert_eq!(text(&output.stdout), "", "{out}");
        assert!(said.starts_with(&format!("error: `{out}` {reason}")), "{said}");
        assert!(said.ends_with("\n  = expected with --out a folder that is new or empty\n"));
    }
    assert_eq!(names(base.path()), before);
    assert_eq!(common::read(&base.path().join("taken/mine")), "precious");
    let output = small_run(base.path(), &["--out", "empty"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(names(base.path()), before, "no pieces beside it");
}

#[test]
fn arguments_that_read_otherwise_are_explained() {
    let base = scratch();
    let cases: [(&[&str], &str); 4] = [
        (&["run", "--record", "5"], "did you mean `--record=5`?"),
        (&["run", "--seed", "-1"], "invalid value '-1' for '--seed <N>'"),
        (&["plot", "nosuch"], "expected the folder of a finished run"),
        (&["sweep", "--merge", "nosuch"], "error: there is no sweep in `nosuch`"),
    ];
    for (arguments, hint) in cases {
        let output = csat(base.path(), arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(hint), "{arguments:?}: {said}");
        assert!(!said.contains('\u{1b}'), "no colours in a file: {said}");
    }
    assert_eq!(names(base.path()), [""; 0]);
}

#[test]
fn a_place_where_nothing_can_be_written_is_named() {
    let base = scratch();
    std::fs::write(base.path().join("file"), "").unwrap();
    // Nobody, not even root, writes below a file or into /proc.
    let refused =
        "error: `file` is not a folder\n  = expected with --out a folder that is new or empty\n";
    let output = small_run(base.path(), &["--out", "file/out"]);
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(2), refused));
    let output = csat(base.path(), &["spawn", "--out", "file/out"]);
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(2), refused));
    for command in ["run", "spawn"] {
        let output = csat(base.path(), &[command, "--out", "/proc/csat/out"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.starts_with("error: cannot create `/proc/csat`: "), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    assert_eq!(names(base.path()), ["file"]);
}

/// The folder of a run that failed: hidden, and whatever in it has its final name is whole.
fn check_pieces(folder: &Path, said: &str) {
    let left = names(folder);
    assert_eq!(left.len(), 1, "{left:?}");
    assert!(left[0].starts_with(".out.partial-"), "{left:?}");
    assert!(said.contains(&left[0]), "{said}");
    let pieces = names(&folder.join(&left[0]));
    for whole in ["metrics.csv", "summary.json", "view.json", "map.svg", "metrics.svg"] {
        assert!(!pieces.iter().any(|p| p == whole), "{whole} in {pieces:?}");
    }
    assert!(pieces.iter().any(|p| p == "metrics.csv.tmp"), "{pieces:?}");
}

#[cfg(unix)]
#[test]
fn a_limit_on_file_sizes_names_the_file() {
    let base = scratch();
    // Blocks of 512 bytes (sh) or 1024 (bash); without the trap the system kills the process.
    let shell = "trap '' XFSZ; ulimit -f 8; exec \"$CSAT\" \"$@\"";
    let longer = ["--set", "run.duration_s=60", "--out", "out"];
    let output = Command::new("sh")
        .args([&["-c", shell, "csat", "run"], SMALL, &longer[..]].concat())
        .env("CSAT", env!("CARGO_BIN_EXE_csat"))
        .current_dir(base.path())
        .output()
        .expect("sh starts");
    let said = text(&output.stderr);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(1), String::new()), "{said}");
    assert!(said.contains("metrics.csv") && said.contains("File too large"), "{said}");
    check_pieces(base.path(), &said);
}

/// A real file system of 128 kB, where mounting one is allowed.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_names_the_file() {
    let base = scratch();
    // The name space of its own takes the mount along when it ends.
    let shell = "mount -t tmpfs -o size=128k tmpfs . 2>/dev/null || exit 77; cd \"$PWD\" && \
                 \"$CSAT\" \"$@\"; code=$?; ls -A; ls -A .out.partial-*; exit $code";
    let longer = ["--set", "run.duration_s=600", "--out", "out"];
    let output = Command::new("unshare")
        .args([&["--mount", "sh", "-c", shell, "csat", "run"], SMALL, &longer[..]].concat())
        .env("CSAT", env!("CARGO_BIN_EXE_csat"))
        .current_dir(base.path())
        .output();
    let Some(output) =
        output.ok().filter(|o| o.status.code() != Some(77) && !o.stderr.starts_with(b"unshare:"))
    else {
        common::skipped("no right to mount a small disk here; /dev/full and ulimit are tested");
        return;
    };
    let (said, left) = (text(&output.stderr), text(&output.stdout));
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("metrics.csv") && said.contains("No space left on device"), "{said}");
    assert!(left.contains("metrics.csv.tmp\n") && !left.contains("summary.json"), "{left}");
    assert!(!left.lines().any(|name| name == "out"), "{left}");
}
