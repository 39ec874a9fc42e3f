//! What csat tells of itself: scenarios, keys, completions, manual pages.

mod common;

use std::path::Path;
use std::process::Command;

use common::{csat, names, read, scratch, skipped, text};

/// What a command says that ends well.
fn said(folder: &Path, arguments: &[&str]) -> String {
    let output = csat(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{arguments:?}");
    text(&output.stdout)
}

#[test]
fn shipped_scenarios_are_listed_and_printed_to_begin_with() {
    let base = scratch();
    let list = said(base.path(), &["scenarios"]);
    assert_eq!(list.lines().count(), 9, "{list}");
    for line in list.lines() {
        let (name, summary) = line.split_once("  ").unwrap();
        assert!(summary.trim().split(' ').count() > 4, "a sentence: {line}");
        let printed = said(base.path(), &["scenarios", name]);
        std::fs::write(base.path().join("my.toml"), printed).unwrap();
        let own = said(base.path(), &["check", "my.toml"]);
        assert_eq!(
            own.replacen("my:", &format!("{name}:"), 1),
            said(base.path(), &["check", name])
        );
    }
    assert!(list.starts_with("city           The paper's setting: a generated town"), "{list}");
    let output = csat(base.path(), &["scenarios", "hellsinki-05"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("'helsinki-05'"));
}

#[test]
fn keys_are_listed_by_prefix() {
    let base = scratch();
    let all = said(base.path(), &["keys"]);
    let range = "netem.radio.range_m = inf   [m; a distance of at least 0 m (or inf)]";
    assert!(all.contains(range) && all.contains("\n    what is farther is lost\n"), "{all}");
    let agents = said(base.path(), &["keys", "agents"]);
    assert!(agents.starts_with("agents.count = 4   [a whole number from 1 to 1024]\n"), "{agents}");
    assert!(!agents.contains("netem"), "{agents}");
    let list: serde_json::Value =
        serde_json::from_str(&said(base.path(), &["keys", "targets.v", "--json"])).unwrap();
    assert_eq!(list.as_array().unwrap().len(), 1);
    assert_eq!((&list[0]["key"], &list[0]["unit"]), (&"targets.v_max_m_s".into(), &"m/s".into()));
    let output = csat(base.path(), &["keys", "agent.count"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("did you mean `agents.count`?"));
}

/// The words that bash offers after a line, once it has read what `csat completions` prints.
fn offered(words: &[&str]) -> Vec<String> {
    let script = "source <(\"$CSAT\" completions bash); COMP_WORDS=(\"$@\"); \
                  COMP_CWORD=$(($# - 1)); _csat csat \"${@: -1}\" \"${@: -2:1}\"; \
                  printf '%s\\n' \"${COMPREPLY[@]}\"";
    let output = Command::new("bash")
        .args([&["-c", script, "bash"], words].concat())
        .env("CSAT", env!("CARGO_BIN_EXE_csat"))
        .output()
        .expect("bash starts");
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout).lines().map(str::to_owned).collect()
}

#[test]
fn bash_completes_commands_flags_and_names() {
    if Command::new("bash").arg("--version").output().is_err() {
        return skipped("there is no bash here");
    }
    assert_eq!(offered(&["csat", "sc"]), ["scenarios"]);
    assert_eq!(offered(&["csat", "run", "--se"]), ["--set", "--seed"]);
    assert_eq!(offered(&["csat", "scenarios", "helsinki-1"]), ["helsinki-17"]);
    assert_eq!(offered(&["csat", "completions", "fi"]), ["fish"]);
}

#[test]
fn other_shells_get_their_scripts() {
    let base = scratch();
    for (shell, sign) in [("zsh", "#compdef csat"), ("fish", "complete"), ("elvish", "edit:")] {
        let script = said(base.path(), &["completions", shell]);
        assert!(script.contains(sign) && script.contains("csat"), "{shell}: {script}");
    }
    assert_eq!(csat(base.path(), &["completions", "tcsh"]).status.code(), Some(2));
}

/// The commands that the help lists.
fn commands(folder: &Path) -> Vec<String> {
    let help = said(folder, &["--help"]);
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let list = list.take_while(|line| !line.is_empty());
    let names = list.filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "help").map(str::to_owned).collect()
}

#[test]
fn what_is_installed_is_a_program_pages_and_completions() {
    let base = scratch();
    let script = common::docs::root().join("packaging/install.sh");
    let output = Command::new(script)
        .arg(env!("CARGO_BIN_EXE_csat"))
        .env("DESTDIR", base.path())
        .env("PREFIX", "/usr")
        .output()
        .expect("sh starts");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let root = base.path().join("usr");
    let installed = Command::new(root.join("bin/csat")).arg("--version").output().unwrap();
    assert!(text(&installed.stdout).starts_with("csat "));
    for (file, sign) in [
        ("bash-completion/completions/csat", "complete -F _csat"),
        ("zsh/site-functions/_csat", "#compdef csat"),
        ("fish/vendor_completions.d/csat.fish", "complete"),
    ] {
        assert!(read(&root.join("share").join(file)).contains(sign), "{file}");
    }
    let pages = root.join("share/man/man1");
    let mut expected: Vec<String> =
        commands(base.path()).iter().map(|name| format!("csat-{name}.1")).collect();
    expected.push("csat.1".to_owned());
    let written = names(&pages);
    for page in &expected {
        assert!(written.contains(page), "{page} in {written:?}");
    }
    let run = read(&pages.join("csat-run.1"));
    for part in [".TH csat-run 1", "KEY=VALUE", "Examples:"] {
        assert!(run.contains(part), "{part} in {run}");
    }
}

#[test]
fn flags_that_csat_does_not_have_lead_to_set() {
    let base = scratch();
    for (arguments, hint) in [
        (["run", "--agents", "6"], "use `--set agents.count=6`"),
        (["sweep", "--duration", "10"], "use `--set run.duration_s=10`"),
    ] {
        let output = csat(base.path(), &arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(hint) && !said.contains("as a value"), "{said}");
    }
}
