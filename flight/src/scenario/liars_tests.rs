//! Agents that lie or are mistaken: what is refused, and what is warned of.

use super::tests::{load_with, set_mistake, warning};

const LIAR: &str = "faults.liar=[{agent=2,from_s=5,kind=phantom}]";

#[test]
fn a_wrong_kind_of_lie_is_one_mistake_at_its_place() {
    for (kind, found) in
        [("3", "`3`"), ("true", "`true`"), ("[1]", "`[1]`"), ("\"bribe\"", "`bribe`")]
    {
        let said = set_mistake(&[&format!("faults.liar=[{{agent=0,kind={kind}}}]")]);
        let start = format!("error: `faults.liar[0].kind` cannot be {found}\n");
        assert!(said.starts_with(&start), "{said}");
        assert!(said.contains("expected one of `clear`, `phantom`, `misidentify`"), "{said}");
    }
    let two = "faults.liar=[{agent=0,kind=clear},{agent=\"x\",kind=3}]";
    let mistakes = load_with("city", &[two]).unwrap_err().mistakes;
    let said: Vec<&str> = mistakes.iter().map(|mistake| mistake.message.as_str()).collect();
    let expected =
        ["`faults.liar[1].agent` cannot be \"x\"", "`faults.liar[1].kind` cannot be `3`"];
    assert_eq!(said, expected);
}

#[test]
fn more_liars_than_are_allowed_for_are_a_warning() {
    let said = warning(&[LIAR]);
    let start = "warning: 1 liar in `faults.liar`, more than exchange.liars = 0: the guarantee does not hold\n";
    assert!(said.starts_with(start), "{said}");
    assert!(said.contains("expected at most 0, or a larger exchange.liars"), "{said}");
    assert_eq!(warning(&[LIAR, "exchange.liars=1"]), "");
    let two = "faults.liar=[{agent=2,kind=phantom},{agent=1,kind=clear}]";
    assert!(warning(&[two, "exchange.liars=1"]).contains("2 liars in `faults.liar`, more than"));
}

#[test]
fn lies_that_nobody_hears_are_a_warning() {
    let start = "warning: no agent hears a lie: `exchange.mode` is `none`\n";
    for set in [LIAR, "exchange.liars=1"] {
        let said = warning(&[set, "exchange.mode=none"]);
        assert!(said.starts_with(start) && said.matches("warning").count() == 1, "{said}");
    }
    assert_eq!(warning(&["exchange.mode=none"]), "");
}

#[test]
fn a_lie_after_the_end_is_a_warning() {
    let said = warning(&[LIAR, "run.duration_s=4.5"]);
    let start = "warning: `faults.liar[0].from_s` = 5 s is after the mission's end, 4.5 s\n";
    assert!(said.starts_with(start) && said.contains(" = UAV 2 does not lie\n"), "{said}");
    assert_eq!(said.matches("warning").count(), 1, "it breaks no guarantee: {said}");
    assert!(!warning(&[LIAR, "run.duration_s=5"]).contains("after the mission's end"));
}

#[test]
fn one_car_is_taken_for_no_other() {
    for (count, is_wrong) in [(0, true), (1, true), (2, false)] {
        let count = format!("targets.count={count}");
        let sets = ["camera.misidentify=0.1", &count];
        if is_wrong {
            let said = set_mistake(&sets);
            let start = format!(
                "error: `camera.misidentify` cannot be 0.1 with {}",
                count.replace('=', " = ")
            );
            assert!(said.starts_with(&start), "{said}");
            assert!(said.contains("2 cars or more to be taken for each other"), "{said}");
        } else {
            let said = warning(&sets);
            let start = "warning: with `camera.misidentify` = 0.1 and exchange.liars = 0 the guarantee does not hold\n";
            assert!(said.starts_with(start) && said.matches("warning").count() == 1, "{said}");
            assert_eq!(warning(&["camera.misidentify=0.1", &count, "exchange.liars=1"]), "");
        }
    }
}

/// Cameras that identify no targets: one mistake, whatever else the mission demands of them.
#[test]
fn a_mission_without_labels_refuses_mistaken_cameras_once() {
    for mission in ["tisdale", "clearing"] {
        let mistakes = load_with(mission, &["camera.misidentify=0.1"]).unwrap_err().mistakes;
        let [only] = &mistakes[..] else { panic!("{mistakes:?}") };
        assert!(only.message.contains("whose cameras identify no targets"), "{only}");
    }
}

/// Serde would take the elements of a list for the fields of a table.
#[test]
fn a_list_is_no_liar() {
    for (value, index) in [("[[1,5,clear]]", 0), ("[[]]", 0), ("[{agent=1,kind=clear},[2]]", 1)] {
        let said = set_mistake(&[&format!("faults.liar={value}")]);
        let start = format!("error: `faults.liar[{index}]` cannot be a list");
        assert!(said.starts_with(&start) && said.contains("expected a table"), "{said}");
    }
}
