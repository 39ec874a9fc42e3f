//! A running fleet, watched with tools that people already have: zenoh-cli and Python.

#![cfg(unix)]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::docs::{blocks, root};
use common::fleet::{end, endpoint, expect_nobody, process, signal, spawn, wait_for_flight};
use common::{read, scratch, text};

/// A Python with Zenoh's tools and shapely.
fn python() -> Option<PathBuf> {
    let packages = "eclipse-zenoh==1.10.2 zenoh-cli shapely";
    common::python(&["zenoh", "zenoh_cli", "shapely"], packages).map(PathBuf::from)
}

/// Runs a command until it has written that many lines, or ends.
fn lines_of(command: &mut Command, wanted: usize) -> Vec<String> {
    use std::io::BufRead;
    let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
    let stdout = std::io::BufReader::new(child.stdout.take().unwrap());
    let lines = stdout.lines().map_while(Result::ok).take(wanted).collect();
    let _ = child.kill();
    let _ = child.wait();
    lines
}

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

/// zenoh-cli, about to be told what to do.
fn zenoh(python: &Path, endpoint: &str) -> Command {
    let mut command = Command::new(python.with_file_name("zenoh"));
    command.args(["--mode", "client", "--connect", endpoint]);
    command
}

/// What numpy is told in `docs/topics.md` reads a belief as it is published.
#[test]
fn numpy_reads_a_belief() {
    let packages = "eclipse-zenoh==1.10.2 numpy";
    let Some(python) = common::python(&["zenoh", "numpy"], packages) else { return };
    let topics = read(&root().join("docs/topics.md"));
    let [(_, lines)] = &blocks(&topics, "python")[..] else { panic!("one block of Python") };
    let script = format!(
        "import json, numpy, sys, zenoh\n\
         config = zenoh.Config()\n\
         config.insert_json5('mode', json.dumps('client'))\n\
         config.insert_json5('connect/endpoints', json.dumps([sys.argv[1]]))\n\
         session = zenoh.open(config)\n\
         truth = session.declare_subscriber('csat/1/truth/targets').recv()\n\
         beliefs = session.declare_subscriber('csat/1/view/0/belief')\n\
         for sample in beliefs:\n\
         \x20   {}\n\
         \x20   assert belief.shape == (24, 16), belief.shape\n\
         \x20   assert abs(belief.sum() - 100) < 0.01, belief.sum()\n\
         \x20   assert belief[row, column] == d['maximum'], d['maximum']\n\
         \x20   if d['maximum'] > 20: break\n\
         found = [o + d['cell_m'] * (i + 0.5) for o, i in zip(d['origin_m'], (column, row))]\n\
         [target] = json.loads(truth.payload.to_string())['targets']\n\
         assert numpy.hypot(*numpy.subtract(found, target['location'])) < 40, (found, target)\n\
         session.close()",
        lines.join("\n    ")
    );
    let (folder, endpoint) = (scratch(), endpoint());
    let start = "agents.start=[{x_m=-50,y_m=-150,yaw_deg=90},{x_m=50,y_m=-150,yaw_deg=90}]";
    let sets = ["run.duration_s=30000", "map.size_m=[200, 300]", start].map(|set| ["--set", set]);
    let arguments =
        [&["spawn", "tisdale", "--listen", &endpoint, "--out", "out"], sets.as_flattened()];
    let fleet = process(folder.path(), &arguments.concat());
    wait_for_flight(folder.path());
    let output = Command::new(python).args(["-c", &script, &endpoint]).output().unwrap();
    assert!(output.status.success(), "{script}\n{}", text(&output.stderr));
    signal(fleet.id(), "-INT");
    assert_eq!(end(fleet).status.code(), Some(130));
    expect_nobody(&endpoint);
}

#[test]
fn zenoh_cli_and_python_see_what_the_fleet_shows() {
    let Some(python) = python() else { return };
    let (folder, endpoint) = (scratch(), endpoint());
    let fleet = spawn(folder.path(), &endpoint, "30000", &["--seed", "3"]);
    wait_for_flight(folder.path());

    let mut subscribe = zenoh(&python, &endpoint);
    subscribe.args(["subscribe", "-k", "csat/*/view/*/unexplored", "--decoder", "json"]);
    let shown = lines_of(subscribe.args(["--line", "{value}"]), 4);
    let check = "import json, sys, shapely.geometry as g\n\
                 for line in sys.argv[1:]:\n\
                 \x20   [feature] = json.loads(line)['features']\n\
                 \x20   shape = g.shape(feature['geometry'])\n\
                 \x20   assert shape.is_valid and shape.area > 1, shape\n\
                 \x20   beyond = shape.area - feature['properties']['area_m2']\n\
                 \x20   assert -0.1 < beyond < 0.006 * shape.length + 0.1, beyond";
    assert_eq!(shown.len(), 4);
    let parsed = Command::new(&python).args(["-c", check]).args(&shown).output().unwrap();
    assert!(parsed.status.success(), "{}\n{shown:?}", text(&parsed.stderr));

    for (arguments, expected) in [
        (&["get", "-s", "csat/3/view/1/pose", "--decoder", "json"][..], "\"footprint\""),
        (&["get", "-s", "csat/3/truth/town", "--decoder", "json"], "\"building\""),
        (&["get", "-s", "csat/3/state/0/oem", "--decoder", "json"], "\"occupied\""),
        (&["liveliness", "get", "-k", "csat/*/alive/*"], "csat/3/alive/1"),
    ] {
        let output = zenoh(&python, &endpoint).args(arguments).output().unwrap();
        let said = text(&output.stdout);
        let found = said.contains(expected) || said.replace('\'', "\"").contains(expected);
        assert!(found, "{arguments:?}: {said}{}", text(&output.stderr));
    }

    let script = lines_of(Command::new(&python).arg(example("targets.py")).arg(&endpoint), 2);
    assert!(script.iter().all(|line| line.starts_with("car ")), "{script:?}");
    assert_eq!(script.len(), 2);
    signal(fleet.id(), "-INT");
    assert_eq!(end(fleet).status.code(), Some(130));
    expect_nobody(&endpoint);
}
