//! Tells the program which revision it was built from.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if let Some(rustc) = output(&std::env::var("RUSTC").unwrap_or("rustc".into()), &["--version"]) {
        println!("cargo:rustc-env=CSAT_RUSTC={rustc}");
    }
    let Some(revision) = output("git", &["rev-parse", "HEAD"]) else { return };
    println!("cargo:rustc-env=CSAT_GIT_REVISION={revision}");
    if let Some(changes) = output("git", &["status", "--porcelain", "--untracked-files=no"]) {
        println!("cargo:rustc-env=CSAT_GIT_DIRTY={}", !changes.is_empty());
    }
    // Any commit, checkout or edit of a source can change the answers above.
    for file in ["HEAD", "logs/HEAD"] {
        if let Some(path) = output("git", &["rev-parse", "--git-path", file]) {
            watch(&path);
        }
    }
    for package in ["proto", "netem", "world", "agent", "mission", "peer", "flight", "experiments"]
    {
        watch(&format!("../{package}/src"));
    }
}

/// Cargo reruns the script for ever when it watches a file that does not exist.
fn watch(path: &str) {
    if Path::new(path).exists() {
        println!("cargo:rerun-if-changed={path}");
    }
}

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
