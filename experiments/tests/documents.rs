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

/// The files that the comments of a source cite, with their lines: words that end as a document's or a
/// program's name does.
fn cited(source: &str) -> Vec<(usize, &str)> {
    let comments = (1..).zip(source.lines()).filter_map(|(number, line)| {
        let (_, comment) = line.split_once("//").filter(|(code, _)| !code.ends_with(':'))?;
        (!comment.contains("://")).then_some((number, comment))
    });
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let words = comments.flat_map(move |(number, comment)| {
        let words = comment.split(move |c| !is_part(c)).map(|word| word.trim_end_matches('.'));
        words.map(move |word| (number, word.trim_start_matches("./")))
    });
    let is_file = |word: &str| {
        let stem = word.rsplit_once('.').filter(|(_, end)| ["md", "rs", "sh", "py"].contains(end));
        stem.is_some_and(|(stem, _)| stem.ends_with(|c: char| c.is_ascii_alphanumeric()))
    };
    words.filter(|(_, word)| is_file(word)).collect()
}

/// A comment may name a file from the root, from its crate, from its crate's sources, or from its folder.
#[test]
fn files_that_comments_cite_exist() {
    let mut complaints = Vec::new();
    let mut count = 0;
    for krate in
        ["agent", "experiments", "flight", "mission", "netem", "peer", "proto", "tests", "world"]
    {
        let home = root().join(krate);
        for path in sources(&home) {
            let source = read(&path);
            for (line, cite) in cited(&source) {
                let folders = [root(), root().join("docs"), home.clone(), home.join("src")];
                let near = path.parent().into_iter().map(Path::to_owned);
                count += 1;
                if !folders.into_iter().chain(near).any(|folder| folder.join(cite).exists()) {
                    complaints.push(format!("{}:{line}: there is no `{cite}`", name_of(&path)));
                }
            }
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert!(count > 50, "{count} files are cited");
}

/// The Rust sources below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder of sources").flatten();
    let mut all: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    all.sort();
    let below = |path: PathBuf| match path.is_dir() {
        true => sources(&path),
        false => vec![path],
    };
    let files = all.into_iter().filter(|path| !path.ends_with("target")).flat_map(below);
    files.filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

#[test]
fn cited_files_are_found() {
    let source = "let a = 1; // see docs/links.md, (`x/y.rs`).\n//! `a.toml`, https://b.md\nlet b = \"c.md\";";
    assert_eq!(cited(source), [(1, "docs/links.md"), (1, "x/y.rs")]);
}

#[test]
fn links_and_anchors_are_found() {
    let document = "# One `two`, three\n[a](b.md#c) `[x](y)` ![p](q.png)\n```\n# no\n[n](o)\n```\n\
                    ## One two, three\n<img src=\"r.png\">\n";
    let targets: Vec<String> = links(document).into_iter().map(|(_, target)| target).collect();
    assert_eq!(targets, ["b.md#c", "q.png", "r.png"]);
    assert_eq!(anchors(document), ["one-two-three", "one-two-three-1"]);
}
