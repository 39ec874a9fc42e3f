//! `csat sweep --resume` and `--merge`: sweeps that grow, and files that are none.

mod common;

use std::fs;
use std::path::Path;

use common::fleet::{end, process};
use common::sweeps::{FILES, done, refused, results, run_path, runs, sweep};
use common::{SMALL, csat, json, names, read, scratch, text};

/// What a run's file says of the clock changes whenever it is flown.
fn as_written(folder: &Path) -> Vec<(String, String)> {
    let runs = folder.join("runs");
    names(&runs).into_iter().map(|name| (name.clone(), read(&runs.join(name)))).collect()
}

/// Each time, the tables and the report are those of a sweep that was asked for at once.
#[test]
fn a_sweep_grows_by_seeds_values_and_keys_and_flies_only_what_is_new() {
    let base = scratch();
    let ranges = |values: &str| format!("netem.radio.range_m={values}");
    let [few, more] = ["20,60", "20,40,60,inf"].map(ranges);
    let vary = |range: &str| vec!["city".to_owned(), "--vary".to_owned(), range.to_owned()];
    let mode = ["--vary", "exchange.mode=facts+repair,none"].map(str::to_owned);
    let steps: [(Vec<String>, &str, usize); 4] = [
        (vary(&few), "1..1", 3),
        (vary(&few), "1..2", 6),
        (vary(&more), "1..2", 8),
        ([vary(&more), mode.to_vec()].concat(), "1..2", 16),
    ];
    let mut flown: Vec<(String, String)> = Vec::new();
    for (arguments, seeds, count) in &steps {
        let mut arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        arguments.extend(["--seeds", seeds]);
        done(base.path(), &[&arguments[..], &["--resume", "--out", "out"]].concat());
        let now = as_written(&base.path().join("out"));
        assert_eq!(now.len(), *count, "{now:?}");
        let texts: Vec<&String> = now.iter().map(|(_, text)| text).collect();
        for (name, text) in &flown {
            assert!(texts.contains(&text), "{name} was flown again for {arguments:?}");
        }
        flown = now;
        done(base.path(), &[&arguments[..], &["--out", &format!("at-once-{count}")]].concat());
        let at_once = base.path().join(format!("at-once-{count}"));
        assert_eq!(results(&base.path().join("out")), results(&at_once), "{arguments:?}");
        assert_eq!(names(&base.path().join("out/runs")), names(&at_once.join("runs")));
    }
    // Runs of the default mode have no place among other modes.
    let other = ["city", "--vary", &more, "--vary", "exchange.mode=facts,none", "--seeds", "1"];
    done(base.path(), &["city", "--vary", &more, "--seeds", "1", "--out", "of-default"]);
    let other = [&other[..], &["--resume", "--out", "of-default"]].concat();
    let expected = "expected also the values that they have: exchange.mode=\"facts+repair\"";
    refused(base.path(), &other, &["netem.radio.range_m=20: not among the combinations", expected]);
    // A command for less flies nothing else, and forgets nothing.
    fs::remove_file(run_path(&base.path().join("out"), "range_m-60-mode-none-", 2)).unwrap();
    let less = ["city", "--vary", &more, "--seeds", "1", "--resume", "--out", "out"];
    assert!(done(base.path(), &less).contains("16 runs: 15 flown"));
}

/// As the parts of a job array do.
#[test]
fn parts_that_start_at_once_let_a_sweep_grow_once() {
    let base = scratch();
    let vary = ["city", "--vary", "agents.speed_m_s=4,5", "--seeds"];
    done(base.path(), &[&vary[..], &["1", "--out", "shared"]].concat());
    let part = |shard| {
        let rest = ["1..3", "--resume", "--out", "shared", "--shard", shard];
        process(base.path(), &[&["sweep"], SMALL, &vary, &rest].concat())
    };
    for child in ["1/3", "2/3", "3/3"].map(part) {
        let output = end(child);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    done(base.path(), &[&vary[..], &["1..3", "--out", "at-once"]].concat());
    let [shared, at_once] = ["shared", "at-once"].map(|name| base.path().join(name));
    assert_eq!((results(&shared), runs(&shared)), (results(&at_once), runs(&at_once)));
    assert_eq!(names(&shared), FILES);
}

#[test]
fn folders_of_several_machines_merge() {
    let base = scratch();
    for (seeds, speeds, out) in [("1,2", "4,5", "a"), ("3,4", "4,5", "b"), ("1..4", "6", "c")] {
        let speeds = format!("agents.speed_m_s={speeds}");
        done(base.path(), &["city", "--vary", &speeds, "--seeds", seeds, "--out", out]);
    }
    let said = csat(base.path(), &["sweep", "--merge", "a", "b", "c"]);
    assert_eq!(said.status.code(), Some(0), "{}", text(&said.stderr));
    assert!(text(&said.stdout).contains("12 runs: 12 flown"), "{}", text(&said.stdout));
    let all = ["city", "--vary", "agents.speed_m_s=4,5,6", "--seeds", "1..4", "--out", "at-once"];
    done(base.path(), &all);
    let [merged, at_once] = ["a", "at-once"].map(|name| base.path().join(name));
    assert_eq!((results(&merged), runs(&merged)), (results(&at_once), runs(&at_once)));

    let other = ["city", "--vary", "agents.speed_m_s=4,5", "--seeds", "5"];
    done(base.path(), &[&other[..], &["--set", "targets.v_max_m_s=2", "--out", "d"]].concat());
    let said = csat(base.path(), &["sweep", "--merge", "a", "d"]);
    assert_eq!(said.status.code(), Some(2));
    let said = text(&said.stderr);
    assert!(
        said.contains("`a` (there) and `d` (here) are different sweeps\n  = targets.v_max_m_s: `")
    );
}

#[test]
fn runs_of_another_version_count_only_when_asked_for() {
    let base = scratch();
    let one = ["city", "--vary", "agents.speed_m_s=4,5", "--seeds"];
    for (seeds, out) in [("1", "a"), ("2", "b")] {
        done(base.path(), &[&one[..], &[seeds, "--out", out]].concat());
    }
    let older = |name: &Path| {
        let mut value = json(name);
        value["build"]["version"] = "0.0.1".into();
        fs::write(name, value.to_string()).unwrap();
    };
    let a = base.path().join("a");
    older(&a.join("sweep.json"));
    for speed in [4, 5] {
        older(&run_path(&a, &format!("speed_m_s-{speed}-"), 1));
    }
    let resume = [&one[..], &["1,2", "--out", "a", "--resume"]].concat();
    refused(
        base.path(),
        &resume,
        &["csat: `0.0.1, revision ", "` here; --mix-versions takes both"],
    );
    let merge = ["sweep", "--merge", "a", "b"];
    assert_eq!(csat(base.path(), &merge).status.code(), Some(2));
    let mixed = csat(base.path(), &[&merge[..], &["--mix-versions"]].concat());
    assert_eq!(mixed.status.code(), Some(0), "{}", text(&mixed.stderr));
    let report = read(&a.join("report.html"));
    assert!(report.contains("<strong>mixed</strong><br/>0.0.1, revision "), "{report}");
}

/// What a full disk, a computer that failed or an editor may leave.
#[test]
fn a_file_that_is_no_run_is_flown_again_and_said() {
    let base = scratch();
    let small = ["city", "--vary", "agents.speed_m_s=4,5", "--seeds", "1..2", "--out", "out"];
    done(base.path(), &small);
    let out = base.path().join("out");
    let expected = (results(&out), runs(&out));
    let [empty, cut, other, whole] = [(4, 1), (4, 2), (5, 1), (5, 2)]
        .map(|(speed, seed)| run_path(&out, &format!("speed_m_s-{speed}-"), seed));
    fs::write(&empty, "").unwrap();
    fs::write(&cut, &read(&cut)[..100]).unwrap();
    fs::copy(&whole, &other).unwrap();
    let merged = csat(base.path(), &["sweep", "--merge", "out"]);
    assert!(text(&merged.stdout).contains("1 flown, 0 with violations, 0 failed, 3 missing"));
    let reasons = ["it is empty", "it is cut short: ", "it says that it is seed 2 of scenario "];
    let resumed = sweep(base.path(), &[&small[..], &["--resume"]].concat());
    for said in [text(&merged.stderr), text(&resumed.stderr)] {
        for reason in reasons {
            assert!(said.contains(&format!(".json` is no run: {reason}")), "{reason} in {said}");
        }
    }
    assert_eq!(text(&resumed.stderr).matches("; it is flown again\n").count(), 3);
    assert_eq!((results(&out), runs(&out)), expected);

    // JSON that holds no summary is none either.
    let whole_text = read(&whole);
    for (from, to, reason) in [
        ("\"unexplored_pct\": ", "\"unexplored_pct\": \"x\", \"was\": ", "its summary is none: "),
        ("\"summary\": ", "\"summary\": null, \"was\": ", "it has neither a summary nor why"),
    ] {
        fs::write(&whole, whole_text.replacen(from, to, 1)).unwrap();
        let resumed = sweep(base.path(), &[&small[..], &["--resume"]].concat());
        let said = text(&resumed.stderr);
        assert!(said.contains(&format!(".json` is no run: {reason}")), "{reason} in {said}");
        assert_eq!((results(&out), runs(&out)), expected);
    }

    // A manifest that is gone is made anew by the command; one that is cut is named.
    fs::write(out.join("sweep.json"), "{").unwrap();
    let again = [&small[..], &["--resume"]].concat();
    refused(base.path(), &again, &["out/sweep.json` is not the manifest", "without the file"]);
    fs::remove_file(out.join("sweep.json")).unwrap();
    let before = as_written(&out);
    done(base.path(), &again);
    assert_eq!((results(&out), as_written(&out)), (expected.0, before));
    fs::write(out.join("sweep.json"), "{\"format\": 1}").unwrap();
    refused(base.path(), &again, &["by another version of csat (format 1; this one reads 2)"]);
}
