//! The `csat` command as others use it: exit codes, streams, folders.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A new empty folder.
fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("csat-cli-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn csat(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_csat"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("csat starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn bad_input_is_exit_code_2_and_one_message_per_mistake() {
    let folder = scratch("bad");
    std::fs::write(
        folder.join("my.toml"),
        "[camera]\ncolums = 1\nrows = 'x'\n[agents]\ncount = 0\n",
    )
    .unwrap();
    for command in ["check", "run"] {
        let output = csat(&folder, &[command, "my.toml", "--set", "run.period_s=-1"]);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert_eq!(text(&output.stdout), "");
        assert_eq!(errors.matches("error: ").count(), 4, "{errors}");
        for place in ["--> my.toml:2:1", "--> my.toml:3:8", "--> my.toml:5:9", "--> --set"] {
            assert!(errors.contains(place), "{place} in {errors}");
        }
        assert!(errors.ends_with("4 mistakes: nothing was run\n"), "{errors}");
    }
    assert!(!folder.join("runs").exists());
}

#[test]
fn usage_errors_are_exit_code_2() {
    let folder = scratch("usage");
    for arguments in [
        &["fly"][..],
        &["run", "--seed", "-3"],
        &["run", "--seed", "9223372036854775808"],
        &["run", "--threads", "0"],
        &["plot"],
    ] {
        assert_eq!(csat(&folder, arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn check_works_from_any_folder() {
    let folder = scratch("check");
    for scenario in ["city", "helsinki-05", "helsinki-17"] {
        let output = csat(&folder, &["check", scenario]);
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(said.starts_with(&format!("{scenario}: no mistakes")), "{said}");
        assert!(said.contains("4 UAVs, 8 targets"), "{said}");
    }
}

#[test]
fn a_folder_that_holds_something_is_refused() {
    let folder = scratch("taken");
    std::fs::create_dir(folder.join("out")).unwrap();
    std::fs::write(folder.join("out/mine"), "precious").unwrap();
    let output = csat(&folder, &["run", "--out", "out"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        text(&output.stderr),
        "error: `out` exists and is not empty: a run never overwrites anything\n  = expected with \
         --out a folder that is new or empty\n"
    );
    assert_eq!(std::fs::read_to_string(folder.join("out/mine")).unwrap(), "precious");
}

#[test]
fn plot_names_what_is_missing() {
    let folder = scratch("plot");
    let output = csat(&folder, &["plot", "nowhere"]);
    assert_eq!(output.status.code(), Some(1));
    let errors = text(&output.stderr);
    assert!(errors.starts_with("error: cannot read `nowhere/view.json`"), "{errors}");
}
