//! What documents point to exists: files, pictures, headings, and code that they quote.

mod common;

use std::path::{Path, PathBuf};

use common::docs::{blocks, documents, name_of, root};
use common::read;

/// A link: line number (from 1) and target.
type Link = (usize, String);

/// The targets of all links and pictures, those in code excepted.
fn links(document: &str) -> Vec<Link> {
    let mut links = Vec::new();
    let mut in_code = false;
    for (number, line) in prose(document) {
        // Code may go on in the next line of a paragraph.
        in_code &= !line.trim().is_empty();
        let mut text = String::new();
        for (index, piece) in line.split('`').enumerate() {
            in_code ^= index > 0;
            text += if in_code { "" } else { piece };
        }
        for (opening, closing) in [("](", ')'), ("src=\"", '"')] {
            let targets = text.split(opening).skip(1).filter_map(|rest| rest.split_once(closing));
            links.extend(targets.map(|(target, _)| (number, target.to_owned())));
        }
    }
    links
}

/// The lines outside of fenced blocks, numbered from 1.
fn prose(document: &str) -> Vec<(usize, &str)> {
    let mut fenced = false;
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(document.lines()) {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            lines.push((number, line));
        }
    }
    lines
}

/// The anchors that GitHub gives to the headings of a document.
fn anchors(document: &str) -> Vec<String> {
    let mut anchors: Vec<String> = Vec::new();
    for (_, line) in prose(document) {
        let title = line.trim_start_matches('#');
        if title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let kept = title.trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.collect::<String>().to_lowercase().replace(' ', "-");
        let repeats = anchors.iter().filter(|a| **a == anchor).count();
        anchors.push(if repeats == 0 { anchor } else { format!("{anchor}-{repeats}") });
    }
    anchors
}

/// What is wrong with a link of a document, if anything.
fn complaint(document: &Path, target: &str) -> Option<String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return None;
    }
    let (path, anchor) = target.split_once('#').map_or((target, None), |(p, a)| (p, Some(a)));
    let file: PathBuf = match path {
        "" => document.to_owned(),
        path => document.parent().unwrap_or(Path::new("")).join(path),
    };
    if !file.exists() {
        return Some(format!("there is no `{path}`"));
    }
    let anchor = anchor.filter(|_| file.extension().is_some_and(|e| e == "md"))?;
    let known = anchors(&read(&file));
    (!known.iter().any(|a| a == anchor)).then(|| format!("`{path}` has no heading `#{anchor}`"))
}

#[test]
fn every_link_points_to_something() {
    let mut complaints = Vec::new();
    for document in documents() {
        for (line, target) in links(&read(&document)) {
            let complaint = complaint(&document, &target);
            complaints.extend(complaint.map(|c| format!("{}:{line}: {c}", name_of(&document))));
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// A quote names its source in its first line, `// path`. The quote's pieces between lines of `...`
/// stand there, in this order.
#[test]
fn quoted_code_is_the_code_that_is_compiled() {
    let mut complaints = Vec::new();
    for document in documents() {
        let content = read(&document);
        for (line, quote) in blocks(&content, "rust") {
            let here = format!("{}:{line}", name_of(&document));
            let Some(path) = quote.first().and_then(|first| first.strip_prefix("// ")) else {
                complaints.push(format!("{here}: the first line names no file"));
                continue;
            };
            let Ok(source) = std::fs::read_to_string(root().join(path)) else {
                complaints.push(format!("{here}: there is no `{path}`"));
                continue;
            };
            let mut rest = source.as_str();
            for piece in quote[1..].split(|line| line.trim() == "// ...") {
                let piece = piece.join("\n");
                match rest.split_once(piece.as_str()) {
                    Some((_, after)) => rest = after,
                    None => complaints.push(format!("{here}: not in `{path}`:\n{piece}")),
                }
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn links_and_anchors_are_found() {
    let document = "# One `two`, three\n[a](b.md#c) `[x](y)` ![p](q.png)\n```\n# no\n[n](o)\n```\n\
                    ## One two, three\n<img src=\"r.png\">\n";
    let targets: Vec<String> = links(document).into_iter().map(|(_, target)| target).collect();
    assert_eq!(targets, ["b.md#c", "q.png", "r.png"]);
    assert_eq!(anchors(document), ["one-two-three", "one-two-three-1"]);
}
