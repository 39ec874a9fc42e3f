//! What csat tells of itself: shipped scenarios, keys, shell completions, manual pages.

use std::path::Path;

use anyhow::Context;
use clap::CommandFactory;
use clap_complete::Shell;

use crate::cli::Cli;
use crate::scenario::{keys, shipped, similar};
use crate::verdict::{BAD_INPUT, DONE};
use csat_peer::tell;

use super::common::say;

/// `csat scenarios`.
pub fn scenarios(name: Option<&str>) -> anyhow::Result<u8> {
    let Some(name) = name else {
        let width = shipped::scenario_names().map(str::len).max().unwrap_or_default();
        let line = |s: &shipped::Shipped| format!("{:width$}  {}\n", s.name, s.summary());
        say(&shipped::SCENARIOS.iter().map(line).collect::<String>())?;
        return Ok(DONE);
    };
    // The parser has let no other name through.
    let text = shipped::scenario(name).map_or("", |shipped| shipped.text);
    say(text)?;
    Ok(DONE)
}

/// `csat keys`.
pub fn keys(prefix: &str, json: bool) -> anyhow::Result<u8> {
    let found = keys::keys(prefix);
    if found.is_empty() {
        tell!("error: no key begins with `{prefix}`\n  = `csat keys` lists all");
        let paths: Vec<String> = keys::paths().collect();
        if let Some(guess) = similar(prefix, paths.iter().map(String::as_str)) {
            tell!("  = did you mean `{guess}`?");
        }
        return Ok(BAD_INPUT);
    }
    if json {
        say(&(serde_json::to_string_pretty(&found)? + "\n"))?;
    } else {
        say(&found.iter().map(keys::Key::describe).collect::<String>())?;
    }
    Ok(DONE)
}

/// `csat completions`.
pub fn completions(shell: Shell) -> anyhow::Result<u8> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "csat", &mut script);
    say(&String::from_utf8(script)?)?;
    Ok(DONE)
}

/// `csat man`.
pub fn man(out: Option<&Path>) -> anyhow::Result<u8> {
    let Some(out) = out else {
        let mut page = Vec::new();
        clap_mangen::Man::new(Cli::command()).render(&mut page)?;
        say(&String::from_utf8(page)?)?;
        return Ok(DONE);
    };
    let written =
        std::fs::create_dir_all(out).and_then(|()| clap_mangen::generate_to(Cli::command(), out));
    written.with_context(|| format!("cannot write manual pages into `{}`", out.display()))?;
    Ok(DONE)
}
