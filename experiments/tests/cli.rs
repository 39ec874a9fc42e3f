//! The `csat` command as others use it: exit codes, streams, folders.

mod common;

use common::{csat, scratch, text};

#[test]
fn bad_input_is_exit_code_2_and_one_message_per_mistake() {
    let folder = scratch();
    std::fs::write(
        folder.path().join("my.toml"),
        "[camera]\ncolums = 1\nrows = 'x'\n[agents]\ncount = 0\n",
    )
    .unwrap();
    for command in ["check", "run"] {
        let output = csat(folder.path(), &[command, "my.toml", "--set", "run.period_s=-1"]);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert_eq!(text(&output.stdout), "");
        assert_eq!(errors.matches("error: ").count(), 4, "{errors}");
        for place in ["--> my.toml:2:1", "--> my.toml:3:8", "--> my.toml:5:9", "--> --set"] {
            assert!(errors.contains(place), "{place} in {errors}");
        }
        let end =
            if command == "run" { "\n4 mistakes: nothing was run\n" } else { "\n4 mistakes\n" };
        assert!(errors.ends_with(end), "{errors}");
    }
    assert!(!folder.path().join("runs").exists());
}

#[test]
fn usage_errors_are_exit_code_2() {
    let folder = scratch();
    for arguments in [
        &["fly"][..],
        &["run", "--seed", "-3"],
        &["run", "--seed", "9223372036854775808"],
        &["run", "--threads", "0"],
        &["plot"],
    ] {
        assert_eq!(csat(folder.path(), arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn check_works_from_any_folder() {
    let folder = scratch();
    for scenario in ["city", "helsinki-05", "helsinki-17"] {
        let output = csat(folder.path(), &["check", scenario]);
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(said.starts_with(&format!("{scenario}: no mistakes")), "{said}");
        assert!(said.contains("4 UAVs, 8 targets"), "{said}");
        let count = said.lines().nth(1).map(|line| line.split(' ').next().unwrap());
        assert_eq!(count, (scenario != "city").then_some("features:"), "{said}");
    }
}

/// The check of a map ends with what became of each feature, and the numbers add up.
#[test]
fn check_accounts_for_every_feature_of_a_map() {
    let folder = scratch();
    let output = csat(folder.path(), &["check", "helsinki-17"]);
    let said = text(&output.stdout);
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[1].starts_with("features: 162 = "), "{said}");
    let numbers = |line: &str| -> Vec<usize> {
        line.split(' ').filter_map(|word| word.parse().ok()).collect()
    };
    let [features, buildings, parts, roads, left_out] = numbers(lines[1])[..] else {
        panic!("{said}")
    };
    assert_eq!(features, buildings + parts + roads + left_out, "{said}");
    let reasons: usize = lines[2..].iter().map(|line| numbers(line)[0]).sum();
    assert_eq!(reasons, left_out, "{said}");
}
