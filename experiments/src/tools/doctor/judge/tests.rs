use std::collections::BTreeMap;

use super::super::finding::Level;
use super::*;
use crate::tools::keys::key_expression;
use crate::tools::rates::Traffic;

/// A run in which all is well.
fn well() -> Run {
    let topics = BTreeMap::from([("clock".to_owned(), Traffic { messages: 20, bytes: 4000 })]);
    Run {
        run: 1,
        world: true,
        agents: [0, 1].into(),
        expected: Some(2),
        orders: 20,
        step: Some(7),
        topics,
        viewed: [0, 1].into(),
        ..Run::default()
    }
}

fn shown(run: &Run) -> Vec<(Level, String)> {
    super::run(run, 2.0).into_iter().map(|f| (f.level, f.text)).collect()
}

#[test]
fn a_run_that_flies_is_well() {
    let expected = [
        "the world and all 2 agents are alive",
        "the clock ticks: 10.0 orders/s, at step 7",
        "published: clock 10.0/s 2.0 kB/s",
        "UAVs 0, 1 show what they know",
    ];
    assert_eq!(shown(&well()), expected.map(|text| (Level::Ok, text.to_owned())));
    let unknown = Run { expected: None, ..well() };
    assert!(shown(&unknown)[0].1.ends_with("UAVs 0, 1 are alive; how many it has is unknown"));
}

#[test]
fn what_is_wrong_with_a_run_is_named() {
    let none = BTreeSet::new;
    for (run, level, text) in [
        (Run { agents: [1].into(), ..well() }, Level::Warning, "processes of UAV 0 are gone"),
        (
            Run { agents: none(), orders: 0, ..well() },
            Level::Problem,
            "the world waits: processes of UAVs 0, 1 are missing",
        ),
        (Run { orders: 0, ..well() }, Level::Problem, "the clock is silent: no order within 2.0 s"),
        (
            Run { agents: none(), expected: None, ..well() },
            Level::Warning,
            "the world is alive, but no agent",
        ),
        (Run { world: false, ..well() }, Level::Problem, "UAVs 0, 1 alive, but no world"),
        (
            Run { world: false, agents: none(), ..well() },
            Level::Warning,
            "something is published, but no process of it is alive",
        ),
        (Run { viewed: none(), ..well() }, Level::Warning, "no `view/**` within 2.0 s"),
        (Run { viewed: [0].into(), ..well() }, Level::Warning, "UAV 1 showed nothing"),
        (
            Run { world: false, ended: Some("enough".into()), ..well() },
            Level::Note,
            "it ended while it was listened to: enough",
        ),
    ] {
        let findings = super::run(&run, 2.0);
        let found = findings.iter().find(|f| f.text.starts_with(text));
        let found = found.unwrap_or_else(|| panic!("{text}: {findings:?}"));
        assert_eq!(found.level, level, "{found}");
        assert!(found.advice.is_some() || level == Level::Note, "{found}");
    }
}

#[test]
fn nobody_there_is_told_from_another_number() {
    let other = Run { run: 3, ..well() };
    let finding = nobody(Some(9), &[other], 2).to_string();
    assert!(
        finding.contains("run 9 is not here; got 3") && finding.contains("--run 3"),
        "{finding}"
    );
    let finding = nobody(None, &[], 2).to_string();
    assert!(finding.contains("no run of csat among 2 connected processes"), "{finding}");
    assert!(nobody(Some(9), &[], 1).text.starts_with("no run 9 of csat"));
}

#[test]
fn sessions_without_others_are_problems() {
    let places = Places { connect: vec!["tcp/a:1".into()], ..Places::default() };
    assert_eq!(session("z", 3, &places, false).text, "z, connected to 3 processes");
    let alone = session("z", 0, &places, false);
    assert!(
        alone.level == Level::Problem && alone.to_string().contains("access control"),
        "{alone}"
    );
    let alone = session("z", 0, &Places::default(), false).to_string();
    assert!(alone.contains("others need --connect"), "{alone}");
    let alone = session("z", 0, &places, true).to_string();
    assert!(alone.ends_with("no endpoint takes connections, see above"), "{alone}");
    assert!(other_tools(&places).text.contains("--connect tcp/a:1 subscribe"));
    assert!(other_tools(&Places::default()).text.contains("--connect tcp/HOST:PORT"));
    let finding = unopened("cannot open", "expected others").to_string();
    assert!(finding.ends_with("cannot open\n  = expected others"), "{finding}");
    assert_eq!(missed(0), None);
    assert!(missed(2).unwrap().text.starts_with("2 samples"));
}

#[test]
fn keys_that_nobody_says_are_explained() {
    let heard: BTreeSet<String> =
        ["csat/1/clock", "csat/1/view/0/pose", "csat/1/view/1/pose"].map(String::from).into();
    for (given, level, text) in [
        ("clock", Level::Ok, "`csat/*/clock` is heard: `csat/1/clock`"),
        ("view/*/pose", Level::Ok, "`csat/1/view/0/pose` and 1 more"),
        ("view/7/pose", Level::Problem, "though csat has such keys"),
        ("csat/2/clock", Level::Problem, "nearest is `csat/1/clock`"),
        ("view/0/poses", Level::Problem, "nearest is `csat/1/view/0/pose`"),
        ("nonsense/and/more", Level::Problem, "docs/topics.md lists"),
        ("alive/*", Level::Warning, "csat echo --alive 'csat/*/alive/*'"),
        ("join/0", Level::Warning, "a Zenoh `get`"),
        ("oem/0", Level::Problem, "csat has no such key"),
        ("view/0/oem", Level::Problem, "nobody flies or shows it now; "),
        ("truth/lives", Level::Warning, "when an agent begins or ends"),
    ] {
        let finding = key(&key_expression(Some(given)).unwrap(), &heard, 2.0);
        assert_eq!(finding.level, level, "{given}: {finding}");
        assert!(finding.to_string().contains(text), "{given}: {finding}");
    }
}
