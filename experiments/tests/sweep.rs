//! `csat sweep`: the same files however they come about.

mod common;

use std::fs;

use common::fleet::{end, process, signal, wait_until};
use common::sweeps::{FILES, done, refused, results, run_file, run_name, run_path, runs, sweep};
use common::{SMALL, command, csat, json, names, read, scratch, text};

/// Three ranges and two seeds of a mission that takes a moment.
const SWEEP: &[&str] = &["city", "--vary", "netem.radio.range_m=20,60,inf", "--seeds", "1..2"];

#[test]
fn jobs_resumption_and_shards_change_nothing() {
    let base = scratch();
    let said = done(base.path(), &[SWEEP, &["--jobs", "1", "--out", "one"]].concat());
    assert_eq!(
        said,
        "city: 6 runs: 6 flown, 0 with violations, 0 failed, 0 missing\none/report.html\n"
    );
    let one = base.path().join("one");
    assert_eq!(names(&one), FILES);
    let expected = (results(&one), runs(&one));
    assert_eq!(expected.1.len(), 6);
    assert_eq!(expected.1[0].0, run_file(&one, "range_m-20-", 1));
    assert!(expected.0[4].contains("perfect links (dashed)"));
    let check = |name: &str| {
        let folder = base.path().join(name);
        assert_eq!((results(&folder), runs(&folder)), expected, "{name}");
    };

    done(base.path(), &[SWEEP, &["--jobs", "2", "--out", "two"]].concat());
    check("two");

    // What an interruption may leave: runs missing, a piece of one, an old report.
    for (values, seed) in [("range_m-60-", 1), ("range_m-inf-", 2)] {
        fs::remove_file(run_path(&base.path().join("two"), values, seed)).unwrap();
    }
    let piece = base.path().join("two/.partial/1of1/range_m-60-0-seed1/.run.partial-1");
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
        let flying = fs::read_dir(base.path().join("out/.partial/1of1")).into_iter().flatten();
        flying.flatten().any(|e| e.file_name().to_string_lossy().starts_with("speed_m_s-4-"))
    });
    let mut more = sweep.clone();
    more[2] = "agents.speed_m_s=4,5,6";
    more.extend(["--shard", "2/2"]);
    let expected = ["error: another process is flying in `out`", "let the sweep grow"];
    refused(base.path(), &more, &expected);
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
    let first = base.path().join("sweeps/city-speed_m_s");
    let kept = first.join("folders").join(run_name(&first, "speed_m_s-4-", 3));
    assert!(names(&kept).contains(&"map.svg".to_owned()));
    assert_eq!(json(&kept.join("summary.json"))["seed"], 3);
    done(base.path(), small);
    assert_eq!(names(&base.path().join("sweeps")), ["city-speed_m_s", "city-speed_m_s-2"]);
    let out = ["--out", "sweeps/city-speed_m_s"];
    refused(base.path(), &[small, &out].concat(), &["holds a sweep", "--resume"]);
    let other = [small, &["--set", "run.duration_s=6", "--resume"], &out].concat();
    let expected = ["holds another sweep", "run.duration_s: `5.0` there, `6.0` here"];
    refused(base.path(), &other, &expected);
    let other = ["city", "--vary", "exchange.mode=facts,none", "--seeds", "3", "--resume"];
    let expected = "one must vary all keys of the other";
    refused(base.path(), &[&other[..], &out].concat(), &["holds another sweep", expected]);
    refused(base.path(), &[small, &["--out", "."]].concat(), &["not empty: `sweeps` is in it"]);
    let shard = ["--shard", "1/2", "--out", "sweeps/city-speed_m_s"];
    refused(base.path(), &[small, &shard].concat(), &["shard 1/2 has flown `speed_m_s-4-"]);
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
    let in_the_way = run_name(&out, "speed_m_s-5-", 1);
    let again = || {
        for name in names(&out.join("runs")) {
            fs::remove_file(out.join("runs").join(name)).unwrap();
        }
        fs::remove_dir_all(out.join("folders")).unwrap();
        fs::create_dir(out.join("folders")).unwrap();
        fs::write(out.join("folders").join(&in_the_way), "in the way").unwrap();
    };

    again();
    let output = sweep(base.path(), &[small, keep, &["--resume"]].concat());
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(text(&output.stdout).contains("3 flown, 0 with violations, 1 failed, 0 missing"));
    let replay = "csat run city --seed 1 --set run.duration_s=5 ";
    let failed = format!("FAILED: cannot remove `out/folders/{in_the_way}`");
    assert!(said.contains(&failed), "{said}");
    assert!(said.contains(replay), "{said}");
    let record = json(&run_path(&out, "speed_m_s-5-", 1));
    assert!(record["summary"].is_null() && record["replay"].as_str().unwrap().contains(replay));
    let report = read(&out.join("report.html"));
    assert!(report.contains("1 run(s) failed") && report.contains(replay));

    again();
    let output = sweep(base.path(), &[small, keep, &["--resume", "--fail-fast"]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("1 flown, 0 with violations, 1 failed, 2 missing"));

    fs::remove_file(out.join("folders").join(&in_the_way)).unwrap();
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
    let out = base.path().join("out");
    assert_eq!(names(&out.join("runs")).len(), 6);
    for values in ["loss-iid-p-0.1-", "loss-most-", "baseline-"] {
        [1, 4].iter().for_each(|seed| assert!(run_file(&out, values, *seed).contains(values)));
    }
    let baseline = json(&run_path(&out, "baseline-", 4));
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

#[test]
fn differences_are_from_what_the_user_names() {
    let base = scratch();
    let vary = ["city", "--vary", "agents.speed_m_s=4,5", "--vary", "exchange.mode=facts,none"];
    let rest = ["--seeds", "1..3", "--out", "out"];
    let against = |value: &'static str| [&vary[..], &rest, &["--against", value]].concat();
    refused(
        base.path(),
        &against("exchange.mode=snapshot"),
        &["error: --against: `exchange.mode` has no"],
    );
    refused(
        base.path(),
        &against("perfect=1"),
        &["`perfect` does not vary; expected a value of `agents"],
    );
    assert_eq!(names(base.path()), [""; 0]);
    done(base.path(), &against("exchange.mode=none"));
    let out = base.path().join("out");
    let compared = || {
        let mut table = csv::Reader::from_path(out.join("sweep_pairs.csv")).unwrap();
        let row =
            |row: csv::StringRecord| (row[1].to_owned(), row[2].to_owned(), row[5].to_owned());
        let rows = table.records().map(Result::unwrap).filter(|row| &row[4] == "unexplored_pct");
        rows.map(row).collect::<Vec<_>>()
    };
    let expected = [("4", "facts", "3"), ("5", "facts", "3")];
    let expected = expected.map(|(a, b, n)| (a.to_owned(), b.to_owned(), n.to_owned()));
    assert_eq!(compared(), expected);
    let report = read(&out.join("report.html"));
    assert!(report.contains("exchange.mode=none (dashed)") && report.contains("--against"));
    // Looked at again from elsewhere, without a flight.
    let again = csat(base.path(), &["sweep", "--merge", "out", "--against", "agents.speed_m_s=5"]);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    assert_eq!(compared().iter().map(|(speed, ..)| speed.as_str()).collect::<Vec<_>>(), ["4", "4"]);
    let wrong = csat(base.path(), &["sweep", "--merge", "out", "--against", "x=1"]);
    assert_eq!(wrong.status.code(), Some(2), "{}", text(&wrong.stderr));
}

/// On a terminal, which `script` makes, each run has its line as it ends, and the time left shows.
#[test]
fn a_terminal_shows_each_run_and_the_time_left() {
    let base = scratch();
    let csat = env!("CARGO_BIN_EXE_csat");
    let small: String = SMALL.iter().map(|argument| format!(" '{argument}'")).collect();
    let sweep = format!("{csat} sweep city{small} --seeds 1..3 --jobs 1 --out out");
    let made = std::process::Command::new("script")
        .args(["--quiet", "--return", "--command", &sweep, "typescript"])
        .stdin(std::process::Stdio::null())
        .current_dir(base.path())
        .output();
    let Ok(output) = made else {
        common::skipped("there is no `script` to make a terminal with");
        return;
    };
    let shown =
        String::from_utf8_lossy(&fs::read(base.path().join("typescript")).unwrap()).into_owned();
    assert_eq!(output.status.code(), Some(0), "{shown}");
    for seed in 1..=3 {
        let line = format!("{seed}/3  the scenario as it is, seed {seed}: identified ");
        assert!(shown.contains(&line), "{line} in {shown}");
    }
    assert!(shown.contains("left after the first run") && shown.contains("  left 0s"), "{shown}");
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
