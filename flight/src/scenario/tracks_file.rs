//! Reading the file of tracks that `targets.tracks` names.

use std::path::Path;

use csat_proto::ids::TargetId;
use csat_world::track::{Row, TrackError, Tracks, Waypoint};

use super::map_file;
use super::mistake::Mistake;
use super::model::Scenario;
use super::source::{Place, Site, Source, Sources};
use super::tree;

/// The columns of a file of tracks, in any order.
pub const COLUMNS: [&str; 4] = ["target", "time_s", "x_m", "y_m"];
/// The most cars.
const MAX_TARGETS: u16 = 1024;
/// The most rows that are complained about: a wrong unit makes every row a mistake.
const MAX_MISTAKES: usize = 20;

/// Tracks that were read.
#[derive(Debug, Clone, PartialEq)]
pub struct TracksText {
    /// The file's text.
    pub text: String,
    /// What it says.
    pub tracks: Tracks,
    /// Its index in [`Sources`].
    source: usize,
}

impl TracksText {
    /// The mistakes of rows: the first ones with their places, and how many more there are.
    pub fn mistakes(&self, errors: &[TrackError], sources: &Sources) -> Vec<Mistake> {
        complain(errors, self.source, sources)
    }
}

/// Reads the tracks of the scenario, makes `targets.tracks` mean the same from any folder, and takes
/// the number of targets from them, unless it is written beside them.
pub fn resolve(
    scenario: &mut Scenario,
    sources: &mut Sources,
    tree: &tree::Table,
    mistakes: &mut Vec<Mistake>,
) -> Option<TracksText> {
    let file = scenario.targets.tracks.clone()?.to_string_lossy().into_owned();
    let site = tree::exact(tree, "targets.tracks")?.value.clone();
    let read = read(&file, &site, sources).and_then(|(path, source)| {
        let errors = parse(&sources.get(source).text, source, sources);
        errors.map(|tracks| (path, source, tracks))
    });
    let (path, source, tracks) = match read {
        Ok(read) => read,
        Err(found) => {
            mistakes.extend(found);
            return None;
        }
    };
    scenario.targets.tracks = Some(path);
    let count = tracks.count() as u16;
    let written = tree::exact(tree, "targets.count").map(|node| &node.value);
    if let Some(written) = written.filter(|count| map_file::is_beside(count, &site, sources))
        && scenario.targets.count != count
    {
        let text = format!("`targets.count` cannot be {}", scenario.targets.count);
        let expected = format!("{count}, the number of cars in `{file}`, or no such key");
        mistakes.push(Mistake::new(text).expected(expected).at(Some(sources.place(written))));
    }
    scenario.targets.count = count;
    let text = sources.get(source).text.clone();
    Some(TracksText { text, tracks, source })
}

/// The absolute path and the text's index.
fn read(
    file: &str,
    site: &Site,
    sources: &mut Sources,
) -> Result<(std::path::PathBuf, usize), Vec<Mistake>> {
    let refuse = |text: String, sources: &Sources| {
        let mistake = Mistake::new(text).expected(
            "a CSV file with the columns target,time_s,x_m,y_m (relative to the scenario file, or \
             with --set to the current folder)",
        );
        vec![mistake.at(Some(sources.place(site)))]
    };
    let Some(folder) = &sources.get(site.source).folder else {
        return Err(refuse(format!("there are no tracks `{file}` in the program"), sources));
    };
    // `./x` is not what the user wrote.
    let path =
        if folder.as_os_str() == "." { Path::new(file).to_owned() } else { folder.join(file) };
    let name = path.to_string_lossy().into_owned();
    let text = std::fs::read_to_string(&path)
        .map_err(|error| refuse(format!("cannot read the tracks `{name}`: {error}"), sources))?;
    let absolute = path.canonicalize().unwrap_or(path);
    let source = sources.push(Source { name, text, is_file: true, folder: None });
    Ok((absolute, source))
}

fn parse(text: &str, source: usize, sources: &Sources) -> Result<Tracks, Vec<Mistake>> {
    let at = |line| Some(line_place(line, source, sources));
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let unreadable = |error: csv::Error| {
        let line = error.position().map_or(1, |position| position.line() as usize);
        vec![Mistake::new(format!("these tracks are no CSV: {error}")).at(at(line))]
    };
    let header = reader.headers().map_err(unreadable)?.clone();
    let header_line = header.position().map_or(1, |position| position.line() as usize);
    let column = |name: &str| header.iter().position(|column| column == name);
    let (Some([target, time_s, x_m, y_m]), 4) = (all(COLUMNS.map(column)), header.len()) else {
        let got: Vec<&str> = header.iter().collect();
        let mistake = Mistake::new(format!("tracks cannot have the columns `{}`", got.join(",")));
        return Err(vec![mistake.expected(format!("`{}`", COLUMNS.join(","))).at(at(header_line))]);
    };
    let (mut rows, mut mistakes): (Vec<Row>, Vec<Mistake>) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        let line = record.position().map_or(1, |position| position.line() as usize);
        let number = |column: usize| record.get(column).unwrap_or_default().parse::<f64>().ok();
        let id = record.get(target).and_then(|cell| cell.parse::<u16>().ok());
        match (id.filter(|id| *id < MAX_TARGETS), all([time_s, x_m, y_m].map(number))) {
            (Some(id), Some([time_s, x, y])) if record.len() == header.len() => {
                rows.push((TargetId(id), Waypoint { line, time_s, location: [x, y] }));
            }
            _ => {
                let cells: Vec<&str> = record.iter().collect();
                let expected = format!("a target from 0 to {}, and three numbers", MAX_TARGETS - 1);
                let mistake = Mistake::new(format!("a row cannot be `{}`", cells.join(",")));
                mistakes.push(mistake.expected(expected).at(at(line)));
            }
        }
    }
    if !mistakes.is_empty() {
        return Err(shortened(mistakes));
    }
    Tracks::new(&rows).map_err(|errors| complain(&errors, source, sources))
}

fn all<const N: usize, T>(options: [Option<T>; N]) -> Option<[T; N]> {
    let all: Option<Vec<T>> = options.into_iter().collect();
    all?.try_into().ok()
}

fn complain(errors: &[TrackError], source: usize, sources: &Sources) -> Vec<Mistake> {
    let mistake = |error: &TrackError| {
        let place = line_place(error.line, source, sources);
        Mistake::new(error.fault.to_string()).expected(error.fault.expected()).at(Some(place))
    };
    shortened(errors.iter().map(mistake).collect())
}

/// The first mistakes, and how many more there are.
fn shortened(mut mistakes: Vec<Mistake>) -> Vec<Mistake> {
    let more = mistakes.len().saturating_sub(MAX_MISTAKES);
    if more > 0 {
        mistakes.truncate(MAX_MISTAKES);
        let all = more + MAX_MISTAKES;
        mistakes.push(Mistake::new(format!("and so {more} more of {all} mistakes in the tracks")));
    }
    mistakes
}

/// A whole line of a source.
fn line_place(line: usize, source: usize, sources: &Sources) -> Place {
    let text = &sources.get(source).text;
    let start: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
    let length = text[start..].lines().next().unwrap_or_default().len();
    sources.place(&Site { source, span: start..start + length })
}
