//! Every example of README.md and docs/**/*.md runs.
//!
//! In ```` ```console ```` blocks, lines that start with `$ csat ` or `$ cargo run --release -- ` are
//! run in one folder per document, missions cut to three seconds (those of sweeps, too), and
//! `csat watch` ended after as long. `# exit 2` behind the command or on a line after it says which
//! exit code is right (0 otherwise). Output shown must come in this order and have the same words;
//! numbers may differ, and `...` stands for any lines. ```` ```toml ```` blocks must pass
//! `csat check`.

#![cfg(unix)]

mod common;

use std::path::Path;
use std::process::Command;

use common::docs::{blocks, documents, name_of};
use common::{csat, read, scratch, text};

/// Files that examples speak of without showing them.
fn write_fixtures(folder: &Path) {
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/helsinki-05.geojson");
    for name in ["my-town.geojson", "other.geojson"] {
        std::fs::copy(&map, folder.join(name)).unwrap();
    }
    std::fs::write(folder.join("my.toml"), "seed = 3\n").unwrap();
    std::fs::write(folder.join("town.toml"), "[agents]\ncount = 6\nspeed = 3\n").unwrap();
    let bin = folder.join(".bin");
    std::fs::create_dir(&bin).unwrap();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_csat"), bin.join("csat")).unwrap();
}

/// A command and the output shown under it.
#[derive(Debug, Default)]
struct Example {
    line: usize,
    command: String,
    exit: i32,
    shown: Vec<(usize, String)>,
}

fn examples(document: &str) -> Vec<Example> {
    let mut examples: Vec<Example> = Vec::new();
    for (first, lines) in blocks(document, "console") {
        let mut current: Option<Example> = None;
        let mut continued = false;
        for (line, content) in (first..).zip(lines) {
            let prompt = content.strip_prefix("$ ");
            if let (true, Some(example)) = (continued, &mut current) {
                example.command += content;
            } else if let Some(command) = prompt {
                examples.extend(current.take());
                let command = command.replacen("cargo run --release --", "csat", 1);
                let example = Example { line, command, ..Example::default() };
                current = Some(example).filter(|e| e.command.starts_with("csat "));
            } else if let Some(example) = &mut current {
                match exit_code(content) {
                    Some(code) if content.starts_with('#') => example.exit = code,
                    _ => example.shown.push((line, content.to_owned())),
                }
            }
            continued = false;
            if let Some(example) = &mut current
                && example.shown.is_empty()
            {
                continued = example.command.ends_with('\\');
                example.command.truncate(example.command.trim_end_matches('\\').len());
                example.exit = exit_code(&example.command).unwrap_or(example.exit);
            }
        }
        examples.extend(current);
    }
    examples
}

fn exit_code(line: &str) -> Option<i32> {
    let (_, code) = line.split_once("# exit ")?;
    code.split_whitespace().next()?.parse().ok()
}

/// The command with missions of three seconds.
fn shortened(command: &str) -> String {
    let ends = [" |", " >", " 2>", " #", " &&", " ;"];
    let end = ends.iter().filter_map(|e| command.find(e)).min().unwrap_or(command.len());
    let (head, tail) = command.split_at(end);
    let flies = ["csat run", "csat spawn", "csat world", "csat sweep"];
    let flies = flies.iter().any(|c| head.starts_with(c)) && !head.contains("--merge");
    if flies && !head.contains("--help") {
        format!("{head} --set run.duration_s=3{tail}")
    } else if head.starts_with("csat watch") {
        // It shows until it is told to end.
        format!("{head} & watch=$!; sleep 3; kill $watch; wait $watch")
    } else {
        command.to_owned()
    }
}

/// What is left of a line of output when numbers do not count.
fn shape(line: &str) -> String {
    let mut shape = String::new();
    let mut rest = line;
    while let Some(c) = rest.chars().next() {
        let word = rest.find(|c: char| !c.is_alphanumeric()).unwrap_or(rest.len());
        let is_digest = word == 16 && rest[..word].chars().all(|c| c.is_ascii_hexdigit());
        let number = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        if is_digest || c.is_ascii_digit() {
            let taken = if is_digest { word } else { rest[..number].trim_end_matches('.').len() };
            shape.push('#');
            rest = &rest[taken..];
        } else if word > 0 {
            // A word with digits in it is a word, as `d_max` and `U0` are; `seed7` is one and a number.
            let letters = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len()).max(1);
            shape += &rest[..letters];
            rest = &rest[letters..];
        } else {
            shape.push(c);
            rest = &rest[c.len_utf8()..];
        }
    }
    // What a mission of three seconds may say otherwise than one of 300.
    let mut words = shape.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some(start) = words.find(", # dropped (")
        && let Some(length) = words[start..].find(')')
    {
        words.replace_range(start..=start + length, "");
    }
    [
        ("(all after # s)", "(not all)"),
        ("(first after # s)", "(not first)"),
        ("error -", "error # m"),
        ("radius -", "radius # m"),
        ("seed#-#", "seed#"),
    ]
    .iter()
    .fold(words, |words, (from, to)| words.replace(from, to))
}

/// The first line shown that the output lacks.
fn first_missing<'a>(shown: &'a [(usize, String)], output: &str) -> Option<&'a (usize, String)> {
    let mut lines = output.lines().map(shape);
    let says = |line: &str| !matches!(line.trim(), "" | "..." | "…");
    shown.iter().find(|(_, line)| {
        let wanted = shape(line);
        says(line) && !lines.by_ref().any(|line| line == wanted)
    })
}

/// Runs one example; the complaint if it does not do as shown.
fn run(folder: &Path, example: &Example) -> Result<(), String> {
    let command = shortened(&example.command);
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", &format!("{{ {command}\n}} 2>&1")])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", folder.join(".bin").display()))
        .output()
        .map_err(|e| e.to_string())?;
    let said = text(&output.stdout) + &text(&output.stderr);
    let code = output.status.code();
    if code != Some(example.exit) {
        return Err(format!(
            "exit code {code:?}, expected {}, of `{command}`:\n{said}",
            example.exit
        ));
    }
    match first_missing(&example.shown, &said) {
        None => Ok(()),
        Some((line, shown)) => Err(format!(
            "line {line} is not in what `{command}` says (as `{}`, in this order):\n  shown: \
             {shown}\n{said}",
            shape(shown)
        )),
    }
}

#[test]
fn every_example_of_the_documents_runs() {
    let mut complaints = Vec::new();
    for document in documents() {
        let name = name_of(&document);
        let content = read(&document);
        let folder = scratch();
        write_fixtures(folder.path());
        for example in examples(&content) {
            if let Err(complaint) = run(folder.path(), &example) {
                complaints.push(format!("{name}:{}: {complaint}", example.line));
            }
        }
        for (line, lines) in blocks(&content, "toml") {
            std::fs::write(folder.path().join("block.toml"), lines.join("\n")).unwrap();
            let output = csat(folder.path(), &["check", "block.toml"]);
            if output.status.code() != Some(0) {
                complaints.push(format!("{name}:{line}: {}", text(&output.stderr)));
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n\n"));
}

#[test]
fn examples_are_found_with_their_exit_codes_and_outputs() {
    let document = "```console\n$ csat check a.toml   # exit 2\nerror: x\n$ git status\nnothing\n\
                    $ cargo run --release -- run city \\\n    --seed 2 | head\nout 1\n...\n# exit 1\n\
                    ```\n```toml\nseed = 1\n```\n```\n$ csat ignored\n```\n";
    let found = examples(document);
    let [check, run] = &found[..] else { panic!("{found:?}") };
    assert_eq!((check.line, check.exit, check.shown.len()), (2, 2, 1));
    assert_eq!((run.line, run.exit, run.shown.len()), (6, 1, 2));
    assert_eq!(shortened(&run.command), "csat run city     --seed 2 --set run.duration_s=3 | head");
    assert_eq!(blocks(document, "toml"), [(13, vec!["seed = 1"])]);
    assert_eq!(shortened("csat sweep --merge a b"), "csat sweep --merge a b");
    assert!(shortened("csat watch flown").ends_with("kill $watch; wait $watch"));
}

#[test]
fn shapes_are_words_without_their_numbers() {
    let line = "city seed 1: 300 s flown in 11.9 s (25.2x real time)";
    assert_eq!(shape(line), shape("city seed 7:  3 s flown in 0.25 s (12x real time)"));
    assert_ne!(shape(line), shape("town seed 1: 300 s flown in 11.9 s (25.2x real time)"));
    assert_eq!(shape("MB; digest 0123456789abcdef"), "MB; digest #");
    assert_eq!(shape("2 sent, 1 dropped (loss 1), 3 MB"), shape("12 sent, 0.3 MB"));
    assert_eq!(shape("runs/city-seed1"), shape("runs/city-seed1-2"));
    assert_eq!(shape("identified 8/8 (all after 94 s)"), shape("identified 0/8 (not all)"));
    let shown = [(1, "a 1".to_owned()), (2, "...".to_owned()), (3, "c 3".to_owned())];
    assert_eq!(first_missing(&shown, "a 2\nb\nc 4\n"), None);
    assert_eq!(first_missing(&shown, "c 2\nb\na 4\n").map(|s| s.0), Some(3));
}
