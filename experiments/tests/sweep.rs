//! `csat sweep`: the same files however they come about.

mod common;

use std::fs;
use std::path::Path;
use std::process::Output;

use common::fleet::{end, process, signal, wait_until};
use common::{SMALL, command, csat, json, names, read, scratch, text};

/// Three ranges and two seeds of a mission that takes a moment.
const SWEEP: &[&str] = &["city", "--vary", "netem.radio.range_m=20,60,inf", "--seeds", "1..2"];

fn sweep(folder: &Path, arguments: &[&str]) -> Output {
    csat(folder, &[&["sweep"], SMALL, arguments].concat())
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = sweep(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    text(&output.stdout)
}

fn results(folder: &Path) -> [String; 4] {
    ["sweep.json", "sweep.csv", "sweep_means.csv", "report.html"]
        .map(|name| read(&folder.join(name)))
}

/// The files of runs without what a clock says.
fn runs(folder: &Path) -> Vec<(String, serde_json::Value)> {
    let folder = folder.join("runs");
    let timeless = |name: String| {
        let mut run = json(&folder.join(&name));
        for clock in ["wall_s", "realtime_factor", "timing_ms"] {
            let summary = run["summary"].as_object_mut().expect(&name);
            assert!(summary.remove(clock).is_some(), "{clock}");
        }
        (name, run)
    };
    names(&folder).into_iter().map(timeless).collect()
}

fn refused(folder: &Path, arguments: &[&str], messages: &[&str]) {
    let output = sweep(folder, arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    for message in messages {
        assert!(said.contains(message), "{arguments:?}: {message} in {said}");
    }
}

#[test]
fn jobs_resumption_and_shards_change_nothing() {
    let base = scratch();
    let said = done(base.path(), &[SWEEP, &["--jobs", "1", "--out", "one"]].concat());
    assert_eq!(
        said,
        "city: 6 runs: 6 flown, 0 with violations, 0 failed, 0 missing\none/report.html\n"
    );
    let one = base.path().join("one");
    assert_eq!(names(&one), ["report.html", "runs", "sweep.csv", "sweep.json", "sweep_means.csv"]);
    let expected = (results(&one), runs(&one));
    assert_eq!(expected.1.len(), 6);
    assert!(expected.1[0].0 == "01-range_m-20-seed1.json", "{}", expected.1[0].0);
    assert!(expected.0[3].contains("perfect links (dashed)"));
    let check = |name: &str| {
        let folder = base.path().join(name);
        assert_eq!((results(&folder), runs(&folder)), expected, "{name}");
    };

    done(base.path(), &[SWEEP, &["--jobs", "2", "--out", "two"]].concat());
    check("two");

    // What an interruption may leave: runs missing, a piece of one, an old report.
    for name in ["02-range_m-60-seed1.json", "03-range_m-inf-seed2.json"] {
        fs::remove_file(base.path().join("two/runs").join(name)).unwrap();
    }
    let piece = base.path().join("two/.partial/1of1/02-range_m-60-seed1/.run.partial-1");
    fs::create_dir_all(piece).unwrap();
    fs::write(base.path().join("two/report.html"), "old").unwrap();
    done(base.path(), &[SWEEP, &["--resume", "--out", "two"]].concat());
    check("two");
    assert!(!base.path().join("two/.partial").exists());

    // Shards of one folder: the last one concludes.
    for (shard, says) in [("2/3", "2 of 6 runs"), ("1/3", "4 of 6 runs"), ("3/3", "6 flown")] {
        let said = done(base.path(), &[SWEEP, &["--shard", shard, "--out", "shared"]].concat());
        assert!(said.contains(says), "{said}");
        assert_eq!(base.path().join("shared/report.html").exists(), shard == "3/3");
    }
    check("shared");

    for (shard, out) in [("1/2", "a"), ("2/2", "b")] {
        done(base.path(), &[SWEEP, &["--shard", shard, "--out", out]].concat());
    }
    let part = csat(base.path(), &["sweep", "--merge", "b"]);
    assert!(text(&part.stdout).contains("3 flown, 0 with violations, 0 failed, 3 missing"));
    assert!(text(&part.stderr).contains("missing: "));
    assert!(read(&base.path().join("b/report.html")).contains("3 run(s) missing"));
    assert_eq!(csat(base.path(), &["sweep", "--merge", "a", "b"]).status.code(), Some(0));
    check("a");
}

/// Else the second would remove, as a dead process's, what the first has under way.
#[test]
fn two_processes_do_not_fly_the_same_sweep() {
    let base = scratch();
    let week = ["--seeds", "1", "--out", "out", "--resume", "--set", "run.duration_s=600000"];
    let sweep = [&["city", "--vary", "agents.speed_m_s=4,5"], &week[..]].concat();
    let child = process(base.path(), &[&["sweep"], SMALL, &sweep].concat());
    wait_until("a mission flies", || {
        base.path().join("out/.partial/1of1/01-speed_m_s-4-seed1").exists()
    });
    let expected = ["error: another process is flying the sweep in `out`", "--out"];
    refused(base.path(), &sweep, &expected);
    signal(child.id(), "-INT");
    let output = end(child);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert_eq!(names(&base.path().join("out")), ["runs", "sweep.json"]);
}

#[test]
fn folders_are_numbered_kept_and_not_mixed_up() {
    let base = scratch();
    let small = &["city", "--vary", "agents.speed_m_s=4,5", "--seeds", "3"][..];
    let said = done(base.path(), &[small, &["--keep-runs", "--json"]].concat());
    let counts: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!((&counts["runs"], &counts["flown"]), (&2.into(), &2.into()));
    let kept = base.path().join("sweeps/city-speed_m_s/folders/01-speed_m_s-4-seed3");
    assert!(names(&kept).contains(&"map.svg".to_owned()));
    assert_eq!(json(&kept.join("summary.json"))["seed"], 3);
    done(base.path(), small);
    assert_eq!(names(&base.path().join("sweeps")), ["city-speed_m_s", "city-speed_m_s-2"]);
    let out = ["--out", "sweeps/city-speed_m_s"];
    refused(base.path(), &[small, &out].concat(), &["holds a sweep", "--resume"]);
    let other = ["city", "--vary", "agents.speed_m_s=4,6", "--seeds", "3", "--resume"];
    refused(
        base.path(),
        &[&other[..], &out].concat(),
        &[
            "holds another sweep",
            "--vary: `agents.speed_m_s=4,5` there, `agents.speed_m_s=4,6` here",
        ],
    );
    let fewer = ["--set", "run.duration_s=6", "--resume"];
    refused(base.path(), &[small, &fewer, &out].concat(), &["--set: `"]);
    refused(base.path(), &[small, &["--out", "."]].concat(), &["not empty: `sweeps` is in it"]);
    let shard = ["--shard", "1/2", "--out", "sweeps/city-speed_m_s"];
    refused(
        base.path(),
        &[small, &shard].concat(),
        &["shard 1/2 has flown `01-speed_m_s-4-seed3`"],
    );
    assert!(done(base.path(), &[small, &["--resume"]].concat()).contains("2 flown"));
    assert_eq!(names(&base.path().join("sweeps")).len(), 2);
}

#[test]
fn mistakes_of_all_combinations_are_told_before_anything_flies() {
    let base = scratch();
    let seeds = ["--seeds", "1..2"];
    let vary = |arguments: &[&'static str]| {
        let mut all = vec!["city"];
        arguments.iter().for_each(|a| all.extend(["--vary", a]));
        all.extend(seeds);
        all
    };
    refused(
        base.path(),
        &vary(&["agents.speed_m_s=0,5", "netem.radio.range_m=5,-1"]),
        &[
            " | agents.speed_m_s=0\n",
            "--> --vary",
            " = in the combination agents.speed_m_s=0, netem.radio.range_m=5 and 1 other combination",
            "netem.radio.range_m=-1",
            "2 mistakes: nothing was run",
        ],
    );
    refused(base.path(), &vary(&["agents.cont=1,2"]), &["unknown key `cont`", "did you mean"]);
    refused(base.path(), &vary(&["agents.speed_m_s=2,2"]), &["`2` is there twice"]);
    refused(base.path(), &vary(&["agents.speed_m_s=2", "agents.speed_m_s=3"]), &["varies twice"]);
    refused(base.path(), &vary(&["agents.speed_m_s=5,"]), &["a value is missing"]);
    refused(base.path(), &vary(&["targets.count=2,3"]), &["`--set targets.count=2` does nothing"]);
    refused(base.path(), &vary(&["map.kind=generated,'generated'"]), &["is there twice"]);
    let seeds_and_shard = ["city", "--seeds", "5..1", "--shard", "5/4", "--out", "x"];
    refused(base.path(), &seeds_and_shard, &["no seed in it", "no shard `5/4`", "2 mistakes"]);
    for shard in ["0/3", "x"] {
        let arguments = ["city", "--seeds", "1", "--shard", shard, "--out", "x"];
        refused(base.path(), &arguments, &["there is no shard"]);
    }
    refused(base.path(), &["citty", "--seeds", "1"], &["did you mean `city`?"]);
    for usage in [&["city"][..], &["city", "--seeds", "1", "--shard", "1/2"]] {
        refused(base.path(), usage, &["required"]);
    }
    assert_eq!(names(base.path()), Vec::<String>::new());
}

/// A folder that cannot be made stands for whatever fails only when it is flown.
#[test]
fn a_run_that_fails_is_a_result_and_is_flown_again() {
    let base = scratch();
    let small = &["city", "--vary", "agents.speed_m_s=4,5", "--seeds", "1..2", "--jobs", "1"][..];
    let keep = &["--keep-runs", "--out", "out"][..];
    done(base.path(), &[small, keep].concat());
    let out = base.path().join("out");
    let expected = results(&out);
    let again = || {
        for name in names(&out.join("runs")) {
            fs::remove_file(out.join("runs").join(name)).unwrap();
        }
        fs::remove_dir_all(out.join("folders")).unwrap();
        fs::create_dir(out.join("folders")).unwrap();
        fs::write(out.join("folders/02-speed_m_s-5-seed1"), "in the way").unwrap();
    };

    again();
    let output = sweep(base.path(), &[small, keep, &["--resume"]].concat());
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(text(&output.stdout).contains("3 flown, 0 with violations, 1 failed, 0 missing"));
    let replay = "csat run city --seed 1 --set run.duration_s=5 ";
    assert!(said.contains("FAILED: cannot remove `out/folders/02-speed_m_s-5-seed1`"), "{said}");
    assert!(said.contains(replay), "{said}");
    let record = json(&out.join("runs/02-speed_m_s-5-seed1.json"));
    assert!(record["summary"].is_null() && record["replay"].as_str().unwrap().contains(replay));
    let report = read(&out.join("report.html"));
    assert!(report.contains("1 run(s) failed") && report.contains(replay));

    again();
    let output = sweep(base.path(), &[small, keep, &["--resume", "--fail-fast"]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("1 flown, 0 with violations, 1 failed, 2 missing"));

    fs::remove_file(out.join("folders/02-speed_m_s-5-seed1")).unwrap();
    done(base.path(), &[small, keep, &["--resume"]].concat());
    assert_eq!(results(&out), expected);
}

/// Tables by their values, and a perfect link to compare with that no value gives.
#[test]
fn tables_vary_and_perfect_links_are_flown_for_comparison() {
    let base = scratch();
    let loss = "netem.radio.loss={model=\"iid\",p=0.1},most:{model=\"iid\",p=0.9}";
    let arguments = ["city", "--vary", loss, "--seeds", "1,4", "--out", "out"];
    done(base.path(), &arguments);
    let runs = names(&base.path().join("out/runs"));
    assert_eq!(
        runs,
        [
            "01-loss-iid-p-0.1-seed1.json",
            "01-loss-iid-p-0.1-seed4.json",
            "02-loss-most-seed1.json",
            "02-loss-most-seed4.json",
            "baseline01-seed1.json",
            "baseline01-seed4.json",
        ]
    );
    let baseline = json(&base.path().join("out/runs/baseline01-seed4.json"));
    let replay =
        baseline["replay"].as_str().unwrap().replacen("csat", env!("CARGO_BIN_EXE_csat"), 1);
    let flown = std::process::Command::new("sh")
        .args(["-c", &format!("{replay} --json --out again")])
        .current_dir(base.path())
        .output()
        .unwrap();
    let summary: serde_json::Value =
        serde_json::from_slice(&flown.stdout).unwrap_or_else(|e| panic!("{replay}: {e}"));
    assert_eq!(summary["digest"], baseline["summary"]["digest"]);
    let mut table = csv::Reader::from_path(base.path().join("out/sweep.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    for column in ["netem.radio.loss", "seed", "status", "unexplored_pct", "messages.dropped.loss"]
    {
        assert!(header.iter().any(|c| c == column), "{column} in {header:?}");
    }
    assert_eq!(table.records().count(), 6);
    let bare = [&arguments[..5], &["--no-baseline", "--out", "bare"]].concat();
    done(base.path(), &bare);
    assert_eq!(names(&base.path().join("bare/runs")).len(), 4);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_whole_runs_only_and_says_how_to_go_on() {
    use std::process::{Command, Stdio};
    let base = scratch();
    let arguments = ["city", "--seeds", "1..500", "--jobs", "2", "--out", "out"];
    let child = command(base.path(), &[&["sweep"], SMALL, &arguments].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let flown = || {
        let files = fs::read_dir(base.path().join("out/runs")).into_iter().flatten().flatten();
        files.filter(|file| file.path().extension().is_some_and(|e| e == "json")).count()
    };
    let begins = (0..3000).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(10));
        flown() > 1
    });
    assert!(begins, "the sweep does not begin");
    let kill = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains(" --seeds 1..500 ") && said.contains(" --resume --out out\n"), "{said}");
    let out = base.path().join("out");
    assert_eq!(names(&out), ["runs", "sweep.json"]);
    for (name, run) in runs(&out) {
        assert_eq!(run["summary"]["steps"], 10, "{name}");
        assert_eq!(run["summary"]["interrupted"], false, "{name}");
    }
    assert!(flown() < 500);
    let merged = csat(base.path(), &["sweep", "--merge", "out", "--json"]);
    let counts: serde_json::Value = serde_json::from_slice(&merged.stdout).unwrap();
    assert_eq!(counts["flown"], flown());
}
