//! Writing a run down while it flies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use csat_proto::model::Station;
use csat_world::truth::CheckCounts;
use serde::Serialize;

use crate::metrics_file;
use crate::outputs::link_columns;
use crate::passages::LinkRow;
use crate::plot;
use crate::progress::Progress;
use crate::provenance::Provenance;
use crate::run_folder::{Destination, FolderError, PartialFile, RunFolder};
use crate::scenario::{Loaded, MAP_FILE, TRACKS_FILE};
use crate::series::{Curves, Series};
use crate::station::StationSummary;
use crate::summary::{Messages, NamedLiar, Summary};
use crate::timing::Timing;
use crate::values::Numbers;
use crate::view::View;
use csat_mission::fleet::Frames;
use csat_mission::measures::Column;
use csat_mission::mission::Kind;
use csat_mission::row::{Role, Row};
use csat_mission::timing::Stopwatch;

/// Why a run could not be written down.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The folder or a file of it.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A row of `metrics.csv`.
    #[error("cannot write a row of `{}`: {error}", path.display())]
    Csv {
        /// The file.
        path: PathBuf,
        /// What the csv crate said, the system's reason included.
        error: csv::Error,
    },
    /// A line of `events.jsonl`.
    #[error("cannot write an event as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A picture.
    #[error("cannot draw: {0}")]
    Plot(#[from] plot::PlotError),
}

/// Where and how to record.
#[derive(Debug, Clone)]
pub struct RecordOptions {
    /// The folder.
    pub destination: Destination,
    /// Whether the progress bar is hidden even on a terminal.
    pub quiet: bool,
}

/// What a mission leaves besides its steps and events.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Steps flown.
    pub steps: u32,
    /// Simulated time flown, seconds.
    pub sim_s: f64,
    /// Whether it was ended early.
    pub interrupted: bool,
    /// What the monitor checked and found broken.
    pub checked: CheckCounts,
    /// Reports that came too late to be checked.
    pub unchecked: u64,
    /// `inconsistent` events of honest agents.
    pub inconsistencies: u64,
    /// The agents that were named as liars, by index.
    pub liars: Vec<NamedLiar>,
    /// What became of the messages.
    pub messages: Messages,
    /// Bytes that agents sent.
    pub bytes_sent: u64,
    /// What became of each agent's frames, by index.
    pub frames: Vec<Frames>,
    /// What processes did not believe of what was said to them, by kind.
    pub refused: BTreeMap<String, u64>,
    /// What each link did.
    pub links: Vec<LinkRow>,
    /// Hash of every agent's state at every step.
    pub digest: u64,
    /// The end, to be drawn.
    pub view: View,
}

/// A run that was written down.
#[derive(Debug, Clone)]
pub struct Finished {
    /// Its folder.
    pub folder: PathBuf,
    /// `summary.json`.
    pub summary: Summary,
}

/// Writes a run folder. Dropped without [`Self::finish`], it leaves the hidden partial folder.
#[derive(Debug)]
pub struct Recorder {
    folder: RunFolder,
    kind: &'static Kind,
    scenario: String,
    seed: u64,
    agents: u16,
    targets: u16,
    stations: Vec<Station>,
    thesis_setting: bool,
    metrics: csv::Writer<PartialFile>,
    events: PartialFile,
    curves: Curves,
    timing: Timing,
    progress: Progress,
    watch: Stopwatch,
}

impl Recorder {
    /// Starts the folder and writes down what is known before the start.
    ///
    /// # Errors
    /// When the folder is taken or the system refuses.
    pub fn create(loaded: &Loaded, options: &RecordOptions) -> Result<Self, RecordError> {
        let scenario = &loaded.scenario;
        let kind = loaded.kind();
        let folder = RunFolder::create(options.destination.clone())?;
        folder.write("scenario.resolved.toml", &loaded.kept().to_toml())?;
        if let Some(map) = loaded.own_map() {
            folder.write(MAP_FILE, &map.text)?;
        }
        if let Some(tracks) = &loaded.tracks {
            folder.write(TRACKS_FILE, &tracks.text)?;
        }
        let attribution = loaded.world.map().attribution.clone();
        let provenance = Provenance::collect(&loaded.name, scenario.seed, attribution);
        folder.write("provenance.json", &(serde_json::to_string_pretty(&provenance)? + "\n"))?;
        let mut metrics = csv::Writer::from_writer(folder.file("metrics.csv")?);
        let path = || folder.partial().join("metrics.csv");
        let header = metrics_file::header(kind.columns);
        metrics.write_record(header).map_err(|error| RecordError::Csv { path: path(), error })?;
        let events = folder.file("events.jsonl")?;
        Ok(Self {
            kind,
            scenario: loaded.name.clone(),
            seed: scenario.seed,
            agents: scenario.agents.count,
            targets: scenario.targets.count,
            thesis_setting: scenario.is_thesis_setting(),
            metrics,
            events,
            curves: Curves::new(kind.columns),
            stations: scenario.stations.clone(),
            timing: Timing::default(),
            progress: Progress::new(kind, scenario.steps(), scenario.targets.count, options.quiet),
            watch: Stopwatch::start(),
            folder,
        })
    }

    /// Where the files are while the run lasts.
    pub fn partial_folder(&self) -> &Path {
        self.folder.partial()
    }

    /// The bar, for other writers to the same terminal.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Takes down one step: one row per agent, by increasing index; `violations` counts what the
    /// monitor found so far.
    ///
    /// # Errors
    /// When the system refuses, as when the disk is full.
    pub fn step(&mut self, rows: &[Row], violations: u64) -> Result<(), RecordError> {
        for row in rows {
            let record = metrics_file::record(self.kind.columns, row);
            self.metrics.write_record(record).map_err(|error| self.csv_error(error))?;
            // A station's steps take next to nothing: they would make the UAVs look fast.
            if row.role == Role::Uav {
                self.timing.add(&row.times);
            }
        }
        if let Some(point) = self.curves.add(rows) {
            self.progress.step(point, violations);
        }
        Ok(())
    }

    /// Takes down one event: a line of `events.jsonl`.
    ///
    /// # Errors
    /// When it is not JSON or the system refuses.
    pub fn event(&mut self, event: &impl Serialize) -> Result<(), RecordError> {
        let line = serde_json::to_string(event)? + "\n";
        Ok(self.events.write_text(&line)?)
    }

    /// Writes the rest and gives the folder its final name.
    ///
    /// # Errors
    /// When the system refuses; the partial folder stays.
    pub fn finish(self, outcome: Outcome) -> Result<Finished, RecordError> {
        self.progress.clear();
        let summary = self.summarise(&outcome);
        let Self { folder, kind, metrics, events, curves, .. } = self;
        let path = folder.partial().join("metrics.csv");
        let file = metrics.into_inner().map_err(|e| RecordError::Csv {
            path: path.clone(),
            error: csv::Error::from(std::io::Error::new(e.error().kind(), e.error().to_string())),
        })?;
        file.finish()?;
        events.finish()?;
        folder.write("links.csv", &links_csv(&outcome.links)?)?;
        folder.write("view.json", &(serde_json::to_string(&outcome.view)? + "\n"))?;
        folder.write("map.svg", &plot::map_svg(&outcome.view, 0))?;
        folder.write("metrics.svg", &plot::metrics_svg(kind, &summary, &curves)?)?;
        // Last: a folder with a summary is a whole one.
        folder.write("summary.json", &summary.to_json())?;
        Ok(Finished { folder: folder.finish()?, summary })
    }

    /// Removes a folder in which nothing was flown.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn discard(self) -> Result<(), RecordError> {
        self.progress.clear();
        Ok(self.folder.discard()?)
    }

    fn summarise(&self, outcome: &Outcome) -> Summary {
        let wall_s = self.watch.elapsed_s();
        let checked = outcome.checked.total();
        let (numbers, last) = self.numbers();
        Summary {
            mission: self.kind.name.to_owned(),
            scenario: self.scenario.clone(),
            seed: self.seed,
            agents: self.agents,
            targets: self.targets,
            thesis_setting: self.thesis_setting,
            steps: outcome.steps,
            interrupted: outcome.interrupted,
            violations: checked.violations,
            checks: checked.checks,
            unchecked: outcome.unchecked,
            checked: outcome.checked.clone(),
            inconsistencies: outcome.inconsistencies,
            liars: outcome.liars.clone(),
            numbers,
            last,
            stations: self.summarise_stations(&outcome.links),
            frames: outcome.frames.clone(),
            refused: outcome.refused.clone(),
            messages: outcome.messages.clone(),
            bytes_sent: outcome.bytes_sent,
            timing_ms: self.timing.summary(),
            wall_s,
            sim_s: outcome.sim_s,
            realtime_factor: outcome.sim_s / wall_s.max(1e-9),
            digest: format!("{:016x}", outcome.digest),
        }
    }

    /// The mission's own numbers: values at the end, milestones and means over the second half; and the means
    /// at the last step.
    fn numbers(&self) -> (Numbers, Numbers) {
        let Self { kind, curves: Curves { fleet, .. }, targets, .. } = self;
        let mut numbers = Numbers::default();
        for column in kind.columns {
            if let Some(key) = column.last_as {
                let value = fleet.last(column.key);
                numbers.push_of(column, key, value);
            }
        }
        for milestone in kind.milestones {
            let reached_s = fleet.reached_s(milestone.fleet, milestone.level, *targets);
            numbers.push(milestone.key, reached_s);
        }
        let last = self.push_means(&mut numbers, fleet, |column| column.in_summary);
        (numbers, last)
    }

    /// Adds the means of some columns over the second half, and gives their values at the last step.
    fn push_means(
        &self,
        numbers: &mut Numbers,
        series: &Series,
        is_wanted: impl Fn(&Column) -> bool,
    ) -> Numbers {
        let mut last = Numbers::default();
        for column in self.kind.columns.iter().filter(|column| is_wanted(column)) {
            numbers.push(column.key, series.half_mean(column.key));
            last.push(column.key, series.last(column.key));
        }
        last
    }

    fn summarise_stations(&self, links: &[LinkRow]) -> Vec<StationSummary> {
        let nothing = Series::new(self.kind.columns);
        let summarise = |(agent, station): (u16, &Station)| {
            let series = self.curves.stations.get(&agent).unwrap_or(&nothing);
            let to_it = || links.iter().filter(|link| link.dst.0 == agent);
            let Station { x_m, y_m, z_m } = *station;
            let mut numbers = Numbers::default();
            for milestone in self.kind.milestones {
                if let Some(column) = milestone.station {
                    let reached_s = series.reached_s(column, milestone.level, self.targets);
                    numbers.push(milestone.key, reached_s);
                }
            }
            let last = self.push_means(&mut numbers, series, |column| column.of_stations);
            StationSummary {
                agent,
                x_m,
                y_m,
                z_m,
                numbers,
                last,
                sent_to: to_it().map(|link| link.sent).sum(),
                delivered_to: to_it().map(|link| link.delivered).sum(),
            }
        };
        (self.agents..).zip(&self.stations).map(summarise).collect()
    }

    fn csv_error(&self, error: csv::Error) -> RecordError {
        RecordError::Csv { path: self.folder.partial().join("metrics.csv"), error }
    }
}

fn links_csv(rows: &[LinkRow]) -> Result<String, RecordError> {
    let error = |error| RecordError::Csv { path: "links.csv".into(), error };
    let mut writer = csv::Writer::from_writer(Vec::new());
    if rows.is_empty() {
        writer.write_record(link_columns()).map_err(error)?;
    }
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(error)?;
    let bytes = writer.into_inner().expect("a vector takes everything");
    Ok(String::from_utf8(bytes).expect("numbers are text"))
}

#[cfg(test)]
#[path = "record_tests.rs"]
mod tests;
