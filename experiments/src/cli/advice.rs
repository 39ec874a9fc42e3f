//! What was probably meant by arguments that the command line does not know.
//!
//! What a mission is has no flags of its own: every key of a scenario is set by `--set`. So a user who
//! writes `csat run --agents 6` is told `--set agents.count=6`.

use clap::Command;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::scenario::{keys, similar};

/// The most keys that are suggested.
const MAX_GUESSES: usize = 3;

/// The error of a command line with a hint at `--set`, where that is what was meant.
pub fn advise(cli: &Command, mut error: clap::Error, arguments: &[String]) -> clap::Error {
    let has_sets = |command: &Command| command.get_arguments().any(|a| a.get_id() == "sets");
    let command = arguments.iter().find_map(|name| cli.find_subcommand(name));
    if error.kind() != ErrorKind::UnknownArgument || !command.is_some_and(has_sets) {
        return error;
    }
    let Some(ContextValue::String(got)) = error.get(ContextKind::InvalidArg) else { return error };
    // Another flag of the same command may be alike, too.
    let is_alike = error.get(ContextKind::SuggestedArg).is_some();
    let hints = match got.strip_prefix("--") {
        Some(flag) => meant(flag, value_of(got, arguments), is_alike),
        None => torn(got),
    };
    if !hints.is_empty() {
        let hints = hints.into_iter().map(Into::into).collect();
        error.remove(ContextKind::SuggestedArg);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(hints));
    }
    error
}

/// What came with a flag, as `--flag value` or `--flag=value`.
fn value_of<'a>(flag: &str, arguments: &'a [String]) -> Option<&'a str> {
    let at = arguments.iter().position(|a| a.split('=').next() == Some(flag))?;
    match arguments[at].split_once('=') {
        Some((_, value)) => Some(value),
        None => arguments.get(at + 1).map(String::as_str).filter(|next| !next.starts_with("--")),
    }
}

/// `--set KEY=VALUE` for the keys that a flag may stand for; only for those that it names where
/// another flag is alike.
fn meant(flag: &str, value: Option<&str>, is_alike: bool) -> Vec<String> {
    // Missions may have keys of one path.
    let mut paths: Vec<String> = Vec::new();
    for path in keys::paths().filter(|path| !path.contains("[]")) {
        if !paths.contains(&path) {
            paths.push(path);
        }
    }
    let word = flag.replace('-', "_");
    let mut guesses = named(&word, &paths);
    if guesses.is_empty() && !is_alike {
        guesses = alike(&word, &paths);
    }
    let is_sure = guesses.len() == 1;
    let hint = |key: String| {
        let value = value.unwrap_or("VALUE");
        format!("{} `--set {key}={value}`", if is_sure { "use" } else { "perhaps" })
    };
    guesses.into_iter().map(hint).collect()
}

/// A key without its table and its unit.
fn bare(path: &str) -> &str {
    let name = path.rsplit('.').next().unwrap_or(path);
    let units = ["_m_s", "_bytes_s", "_m", "_s", "_deg", "_px", "_bytes", "_db", "_dbm"];
    units.iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name)
}

/// The keys that a flag names: by path, by name, by name without unit, or by a table that has a count.
fn named(word: &str, paths: &[String]) -> Vec<String> {
    let ways: [&dyn Fn(&str) -> bool; 4] = [
        &|path| path == word || path.replace('.', "_") == word,
        &|path| path.rsplit('.').next() == Some(word),
        &|path| bare(path) == word,
        &|path| path == format!("{word}.count") || path == format!("{word}s.count"),
    ];
    let found = ways.iter().map(|way| paths.iter().filter(|path| way(path)).cloned());
    let found = found.map(|found| found.take(MAX_GUESSES).collect::<Vec<_>>());
    found.into_iter().find(|found| !found.is_empty()).unwrap_or_default()
}

/// The keys whose names are like a flag.
fn alike(word: &str, paths: &[String]) -> Vec<String> {
    let Some(name) = similar(word, paths.iter().map(|path| bare(path))) else { return Vec::new() };
    paths.iter().filter(|path| bare(path) == name).take(MAX_GUESSES).cloned().collect()
}

/// `p=0.3}` without a `--set`: a shell has expanded `{model="iid",p=0.3}`.
fn torn(argument: &str) -> Vec<String> {
    let Some((key, _)) = argument.split_once('=') else { return Vec::new() };
    if keys::paths().any(|path| path == key || path.starts_with(&format!("{key}."))) {
        return vec![
            format!("use `--set {argument}`: each assignment needs a `--set` of its own"),
            "a shell splits {a,b}: put a table in single quotes, such as --set \
             'netem.radio.loss={model=\"iid\",p=0.3}'"
                .to_owned(),
        ];
    }
    Vec::new()
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::*;
    use crate::cli::Cli;

    fn said(line: &str) -> String {
        let arguments: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let error = Cli::try_parse_from(&arguments).unwrap_err();
        advise(&Cli::command(), error, &arguments).to_string()
    }

    #[test]
    fn flags_that_are_keys_are_set() {
        for (line, hint) in [
            ("csat run --agents 6", "use `--set agents.count=6`"),
            ("csat run --targets=3", "use `--set targets.count=3`"),
            ("csat check city --duration 10", "use `--set run.duration_s=10`"),
            ("csat spawn --criterion str4", "use `--set guidance.criterion=str4`"),
            ("csat sweep city --seeds 1 --range 100", "use `--set netem.radio.range_m=100`"),
            ("csat run --loss 0.3", "use `--set netem.radio.loss=0.3`"),
            ("csat run --agents.count 6", "use `--set agents.count=6`"),
            ("csat run --critereon str4", "use `--set guidance.criterion=str4`"),
            ("csat run --period 1", "perhaps `--set run.period_s=1`"),
            ("csat run --period 1", "perhaps `--set guidance.period_s=1`"),
            ("csat run --light-delay", "use `--set netem.radio.light_delay=VALUE`"),
        ] {
            let said = said(line);
            assert!(said.contains(hint), "{line}: {said}");
            assert!(!said.contains("as a value"), "{line}: {said}");
        }
    }

    #[test]
    fn other_mistakes_keep_their_own_hints() {
        assert!(said("csat run --sed 3").contains("a similar argument exists: '--seed'"));
        assert!(!said("csat run --xyzzy 3").contains("--set"));
        assert!(!said("csat plot --agents 6").contains("--set"), "it takes none");
        assert!(said("csat run --seed x").contains("invalid value 'x'"));
    }

    #[test]
    fn a_table_that_a_shell_took_apart_is_explained() {
        let torn = "csat run city --set netem.radio.loss=model=iid netem.radio.loss=p=0.3";
        let said = said(torn);
        assert!(said.contains("put a table in single quotes"), "{said}");
        let forgotten = super::tests::said("csat run city agents.count=6");
        assert!(forgotten.contains("use `--set agents.count=6`"), "{forgotten}");
    }
}
