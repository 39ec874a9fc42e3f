//! `csat reproduce`: the published tables beside ours.

mod common;

use std::fs;
use std::path::Path;
use std::process::Output;

use common::{SMALL, csat, json, names, read, scratch, text};

fn reproduce(folder: &Path, arguments: &[&str]) -> Output {
    csat(folder, &[&["reproduce"], arguments].concat())
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = reproduce(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// A reproduction that takes a moment: two seeds of the small mission.
fn small<'a>(what: &'a str, arguments: &[&'a str]) -> Vec<&'a str> {
    [&[what, "--seeds", "1..2"], SMALL, arguments].concat()
}

/// All tables but that of computing times.
fn timeless(tables: &str) -> String {
    let parts = tables.split("\n\n").filter(|table| !table.starts_with("Computing time"));
    parts.collect::<Vec<_>>().join("\n\n")
}

fn stands_alone(page: &str) {
    let bare = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for fetch in ["http:", "https:", "url(", "<script", "<link", "<img", "src=", "NaN"] {
        assert!(!bare.contains(fetch), "{fetch}");
    }
}

#[test]
fn chapter5_makes_its_tables_and_figures_and_resumes() {
    let base = scratch();
    let said = done(base.path(), &small("chapter5", &["--jobs", "1", "--out", "out"]));
    for theirs in ["thesis table 5.3", "22.06 ± 2.35", "38.06", "74.38 ± 9.25", "< 150", "2.1500"]
    {
        assert!(said.contains(theirs), "{theirs} in {said}");
    }
    assert!(said.contains("\n10 missions: 0 violations of "), "{said}");
    assert!(said.ends_with(" checks, 0 inconsistencies\nout/report.html\n"));
    // Two missions of five seconds are not what was published.
    let banner = "Not the published setting: 2 missions instead of 10; run.duration_s=5; ";
    assert_eq!(said.matches(banner).count(), 7, "one for each table: {said}");
    assert!(!said.contains('*'), "{said}");
    let out = base.path().join("out");
    let files = ["folders", "report.html", "runs", "sweep.csv", "sweep.json", "sweep_means.csv"];
    let more = ["sweep_pairs.csv", "tables.json", "tables.txt"];
    assert_eq!(names(&out), [&files[..], &more].concat());
    assert_eq!(names(&out.join("runs")).len(), 10);
    let tables = read(&out.join("tables.txt"));
    assert!(said.starts_with(&tables));
    let page = read(&out.join("report.html"));
    stands_alone(&page);
    assert_eq!(page.matches("<figure>").count(), 11);
    assert_eq!(page.matches(banner).count(), 8, "one for each table, and one for the page");
    assert!(!page.contains("class=\"differs\"") && !page.contains(" *</td>"));
    assert!(page.contains("csat reproduce chapter5 --seeds 1,2 --set run.duration_s=5"));

    // What an interruption may leave.
    let is_lost =
        |name: &String| name.starts_with("criterion-kappa-str2-") && name.ends_with("-seed2.json");
    let lost = names(&out.join("runs")).into_iter().find(is_lost).unwrap();
    fs::remove_file(out.join("runs").join(lost)).unwrap();
    fs::remove_file(out.join("report.html")).unwrap();
    let refused = reproduce(base.path(), &small("chapter5", &["--out", "out"]));
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("--resume"));
    let output = reproduce(base.path(), &small("chapter5", &["--resume", "--out", "out"]));
    let said = text(&output.stderr);
    // One run is flown again; what the scenario is warned of comes before.
    assert_eq!(said.lines().filter(|line| line.contains("/10  ")).count(), 1, "{said}");
    assert_eq!(timeless(&read(&out.join("tables.txt"))), timeless(&tables));
    assert!(out.join("report.html").exists());
    let same = text(&csat(base.path(), &["compare", "out", "out"]).stdout);
    assert!(same.contains("digests: 10 equal of 10 runs in common"), "{same}");
    let other = reproduce(base.path(), &small("table1", &["--resume", "--out", "out"]));
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("holds another sweep"));
}

#[test]
fn table1_is_told_as_json() {
    let base = scratch();
    let said = done(base.path(), &small("table1", &["--duration", "3", "--json"]));
    let tables: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(tables[0]["source"], "paper, table I");
    let [name, cells] = tables[0]["rows"][2].as_array().unwrap().as_slice() else { panic!() };
    assert_eq!((name, &cells[0]["theirs"]["mean"][0]), (&"kappa1".into(), &19.1.into()));
    assert!(cells[0]["ours"]["mean"].as_f64().is_some_and(|v| v > 0.0 && v <= 100.0));
    let banner = tables[0]["not_published"].as_str().unwrap();
    assert!(banner.contains("run.duration_s=3"), "{banner}");
    let out = base.path().join("reproductions/table1");
    let sweep = read(&out.join("sweep.json"));
    assert!(sweep.contains("targets.obstacle_distance_m=3"));
    assert!(sweep.contains("run.duration_s=3"));
}

#[test]
fn chapter4_needs_no_missions() {
    let base = scratch();
    let few = &["chapter4", "--seeds", "1..2", "--jobs", "1"];
    let said = done(base.path(), &[&few[..], &["--out", "out"]].concat());
    assert!(said.contains("thesis §4.7.2") && said.contains("91.70"), "{said}");
    assert!(said.contains("Not the published setting: 2 looks instead of 100. "), "{said}");
    let out = base.path().join("out");
    assert_eq!(names(&out), ["report.html", "tables.json", "tables.txt"]);
    stands_alone(&read(&out.join("report.html")));
    let again = reproduce(base.path(), &[&few[..], &["--out", "out"]].concat());
    assert_eq!(again.status.code(), Some(2), "{}", text(&again.stderr));
    let before = read(&out.join("report.html"));
    done(base.path(), &[&few[..], &["--out", "out", "--resume"]].concat());
    assert_eq!(read(&out.join("report.html")), before);
    let more = ["chapter4", "--seeds", "3..4", "--jobs", "1", "--out", "other"];
    done(base.path(), &more);
    let compared = text(&csat(base.path(), &["compare", "out", "other"]).stdout);
    assert!(
        compared.starts_with("a: out\nb: other\n") && compared.contains("  b - a\n"),
        "{compared}"
    );
    let same = text(&csat(base.path(), &["compare", "out", "out"]).stdout);
    assert!(same.contains(": all numbers are equal\n") && !same.contains("b - a"), "{same}");
}

#[test]
fn chapter6_makes_its_tables() {
    let base = scratch();
    let few = ["chapter6", "--seeds", "1..2", "--jobs", "1", "--out", "out"];
    let said = done(base.path(), &few);
    assert!(said.contains("thesis §6.6.3") && said.contains("82.20"), "{said}");
    stands_alone(&read(&base.path().join("out/report.html")));
}

#[test]
fn clearing_makes_its_tables_and_figures_and_resumes() {
    let base = scratch();
    let small = [
        &["clearing", "--seeds", "1..2", "--duration", "300", "--out", "out"][..],
        &["--set", "map.size_m=[240, 240]", "--set", "map.road_spacing_m=75"],
        &["--set", "agents.count=5"],
    ]
    .concat();
    let said = done(base.path(), &small);
    for words in ["Gagliardi et al. VI", "edge search number, at least", "most cleaners at a time"]
    {
        assert!(said.contains(words), "{words} in {said}");
    }
    let banner = "Not the published setting: 2 missions instead of 10; map.size_m=[240, 240]; ";
    assert_eq!(said.matches(banner).count(), 2, "one for each table: {said}");
    assert!(said.contains("\n2 missions: 0 violations of "), "{said}");
    let out = base.path().join("out");
    let files = ["folders", "report.html", "runs", "sweep.csv", "sweep.json", "sweep_means.csv"];
    assert_eq!(names(&out), [&files[..], &["tables.json", "tables.txt"]].concat());

    let tables = json(&out.join("tables.json"));
    let rows = tables[1]["rows"].as_array().unwrap();
    let row =
        |name: &str| rows.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("{name}"));
    let [first, all] = row("UAVs that never were cleaner")[1].as_array().unwrap().as_slice() else {
        panic!("{rows:?}")
    };
    assert_eq!(first["theirs"], serde_json::json!({ "value": 1.0 }));
    let [least, greatest] = [0, 1].map(|end| all["ours"]["range"][end].as_f64().unwrap());
    assert!(least <= greatest && first["ours"].get("range").is_none(), "{rows:?}");
    let setting = tables[0]["rows"][0].clone();
    let uavs = &setting[1][0];
    assert_eq!((&uavs["ours"]["mean"], &uavs["theirs"]["value"]), (&5.0.into(), &8.0.into()));

    let page = read(&out.join("report.html"));
    stands_alone(&page);
    for title in ["(figure 8)", "(figure 10a)", "(figure 10b)", "(figure 10a, black)"] {
        assert!(page.contains(title), "{title}");
    }
    let is_first = |name: &&String| name.ends_with("-seed1");
    let folders = names(&out.join("folders"));
    let first = folders.iter().find(is_first).unwrap();
    let summary = json(&out.join("folders").join(first).join("summary.json"));
    let mut phases = 0;
    for phase in ["split", "encounter", "merge"] {
        let has_happened = summary[format!("{phase}s")].as_u64() > Some(0);
        assert_eq!(page.contains(&format!("The first {phase}, ")), has_happened, "{phase}");
        phases += usize::from(has_happened);
    }
    assert_eq!(page.matches("<figure>").count(), 4 + phases);
    assert!(summary["splits"].as_u64() > Some(0), "{summary}");

    done(base.path(), &[&small[..], &["--resume"]].concat());
    assert_eq!(read(&out.join("report.html")), page);
}

#[test]
fn bad_input_runs_nothing() {
    let base = scratch();
    for (arguments, message) in [
        (&["chapter7"][..], "chapter5"),
        (&["chapter5", "--seeds", "5..1"], "--seeds: `5..1` has no seed in it"),
        (&["chapter5", "--set", "guidance.kappa=2"], "`guidance.kappa` varies"),
        (&["chapter5", "--set", "seed=2"], "the seeds are those of --seeds"),
        (&["table1", "--duration", "0"], "run.duration_s"),
        (&["clearing", "--set", "guidance.kappa=2"], "guidance"),
        (&["clearing", "--set", "seed=2"], "the seeds are those of --seeds"),
        (&["chapter4", "--duration", "5"], "chapter4 has no missions"),
        (&["chapter4", "--set", "camera.columns=0"], "camera.columns"),
        (&["chapter6", "--duration", "5"], "chapter6 has no missions"),
    ] {
        let output = reproduce(base.path(), arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(message), "{arguments:?}: {said}");
    }
    assert!(names(base.path()).is_empty(), "{:?}", names(base.path()));
}
