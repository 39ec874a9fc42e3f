//! How a command ends: its exit code, and what it says when something must never have happened.

use std::path::Path;

use csat_world::truth::Promise;

use crate::scenario::missions::kind;
use crate::summary::Summary;

/// All is well.
pub const DONE: u8 = 0;
/// Something failed, such as a full disk.
pub const FAILED: u8 = 1;
/// Bad input: nothing was run.
pub const BAD_INPUT: u8 = 2;
/// The mission flew and what it must never do happened.
pub const VIOLATED: u8 = 3;
/// The user ended the mission early; its folder is whole up to there.
pub const INTERRUPTED: u8 = 130;

/// How a finished mission ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// Exit code.
    pub code: u8,
    /// What to say on stderr.
    pub alarm: Option<String>,
}

/// Judges a mission that was recorded in `folder`. Ended early or not, a violation counts most.
pub fn verdict(summary: &Summary, folder: &Path) -> Verdict {
    let Summary { violations, checked, scenario, seed, interrupted, .. } = summary;
    if *violations == 0 {
        return Verdict { code: if *interrupted { INTERRUPTED } else { DONE }, alarm: None };
    }
    let times = if *violations == 1 { "once".to_owned() } else { format!("{violations} times") };
    let folder = folder.display();
    let broken = checked.iter().filter(|(_, checked)| checked.violations > 0);
    let broken: Vec<&str> =
        broken.map(|(promise, _)| words_of(&summary.mission, promise)).collect();
    let broken = if broken.is_empty() { "see below".to_owned() } else { broken.join(", ") };
    let alarm = format!(
        "VIOLATED {times}: what is guaranteed did not hold in {scenario}, seed {seed}: {broken}\n  = see \
         the lines \"violation\" of `{folder}/events.jsonl`\n  = fly it again with `csat run \
         {folder}/scenario.resolved.toml`"
    );
    Verdict { code: VIOLATED, alarm: Some(alarm) }
}

/// What happens when a promise is broken, in words.
fn words_of<'a>(mission: &str, promise: &'a str) -> &'a str {
    let of_world = Promise::ALL.into_iter().find(|p| p.key() == promise).map(Promise::broken);
    let of_mission = || {
        let promises = kind(mission)?.promises.iter();
        promises.clone().find(|p| p.key == promise).map(|p| p.broken)
    };
    of_world.or_else(of_mission).unwrap_or(promise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::summary as sample;

    fn judge(violations: u64, interrupted: bool) -> Verdict {
        let summary = Summary { violations, interrupted, ..sample() };
        verdict(&summary, Path::new("runs/city-seed7"))
    }

    #[test]
    fn a_calm_mission_is_done_and_an_interrupted_one_says_so() {
        assert_eq!(judge(0, false), Verdict { code: 0, alarm: None });
        assert_eq!(judge(0, true), Verdict { code: 130, alarm: None });
    }

    #[test]
    fn a_violation_is_loud_and_says_how_to_see_it_again() {
        for interrupted in [false, true] {
            let Verdict { code, alarm } = judge(2, interrupted);
            assert_eq!(code, 3);
            let alarm = alarm.unwrap();
            assert!(alarm.starts_with("VIOLATED 2 times: "), "{alarm}");
            for part in [
                "city, seed 7",
                "`runs/city-seed7/events.jsonl`",
                "`csat run runs/city-seed7/scenario.resolved.toml`",
            ] {
                assert!(alarm.contains(part), "{alarm}");
            }
        }
        assert!(judge(1, false).alarm.unwrap().starts_with("VIOLATED once: "));
    }

    #[test]
    fn what_was_broken_is_named() {
        let counts = r#"{"guarantee": {"checks": 9, "violations": 0},
            "building_distance": {"checks": 4, "violations": 2}}"#;
        let checked = serde_json::from_str(counts).unwrap();
        let summary = Summary { violations: 2, checked, ..sample() };
        let alarm = verdict(&summary, Path::new("out")).alarm.unwrap();
        let first = "VIOLATED 2 times: what is guaranteed did not hold in city, seed 7: a UAV too close \
                     to a building\n";
        assert!(alarm.starts_with(first), "{alarm}");
    }
}
