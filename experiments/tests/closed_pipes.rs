//! Readers that have seen enough (`csat keys | head -1`): every command ends quietly, with the exit
//! code of what it did.

mod common;

use std::path::Path;
use std::process::Stdio;

use common::{SMALL, command, names, scratch, small_run, text};

/// A pipe that has lost its reader.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

/// The exit code with standard output and standard error closed, and with only one of them.
fn codes(folder: &Path, arguments: &[&str]) -> [Option<i32>; 3] {
    let run = |stdout: Stdio, stderr: Stdio| {
        let mut command = command(folder, arguments);
        command.stdout(stdout).stderr(stderr).status().expect("csat starts").code()
    };
    [run(closed(), closed()), run(closed(), Stdio::null()), run(Stdio::null(), closed())]
}

#[test]
fn a_closed_pipe_changes_no_exit_code() {
    let base = scratch();
    let folder = base.path();
    std::fs::write(folder.join("wrong.toml"), "[camera]\nrows = 'x'\n[agents]\ncount = 0\n")
        .unwrap();
    assert_eq!(small_run(folder, &["--out", "flown", "--record"]).status.code(), Some(0));
    let sweep = ["sweep", "city", "--vary", "agents.speed_m_s=4,5", "--seeds", "1"];
    let cases: Vec<(Vec<&str>, i32)> = vec![
        (vec!["--help"], 0),
        (vec!["run", "--no-such-flag"], 2),
        (vec!["check", "wrong.toml"], 2),
        (vec!["check", "city"], 0),
        // It warns, too.
        ([&["check"], SMALL].concat(), 0),
        (vec!["run", "wrong.toml"], 2),
        ([&["run"], SMALL].concat(), 0),
        ([&["run", "--json"], SMALL].concat(), 0),
        (vec!["run", "--out", "flown"], 2),
        ([&sweep[..], SMALL].concat(), 0),
        (vec!["sweep", "--merge", "nosuch"], 2),
        (vec!["plot", "flown"], 0),
        (vec!["plot", "nosuch"], 2),
        (vec!["replay", "nosuch"], 2),
        (vec!["echo", "a//b"], 2),
        (vec!["keys"], 0),
        (vec!["keys", "no.such"], 2),
        (vec!["scenarios", "city"], 0),
        (vec!["completions", "zsh"], 0),
        (vec!["man"], 0),
    ];
    for (arguments, code) in cases {
        assert_eq!(codes(folder, &arguments), [Some(code); 3], "{arguments:?}");
    }
    // What was flown is whole: a run folder each.
    let runs = names(&folder.join("runs"));
    assert_eq!(runs.len(), 6, "{runs:?}");
    assert!(runs.iter().all(|run| run.starts_with("city-seed1")), "{runs:?}");
}

/// The log of the program's libraries goes to standard error, too.
#[test]
fn a_log_to_a_closed_pipe_is_dropped() {
    let base = scratch();
    let mut command = command(base.path(), &[&["run"], SMALL].concat());
    let output = command.env("RUST_LOG", "trace").stderr(closed()).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).ends_with("runs/city-seed1\n"));
}
