//! `csat reproduce`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crate::cli::{Published, ReproduceArguments};
use crate::progress;
use crate::reproduce::chapter4::Chapter4;
use crate::reproduce::chapter6::Chapter6;
use crate::reproduce::plan::{self, Plan};
use crate::reproduce::setting::Deviations;
use crate::reproduce::table::Table;
use crate::reproduce::tisdale::{self, Tisdale};
use crate::reproduce::{chapter5, clearing, flown, page, table1};
use crate::run_folder::{Destination, FolderError, PartialFile, RunFolder};
use crate::scenario::{self, Loaded, Mistake, Scenario};
use crate::sweep::folder::{SweepFolder, default_root};
use crate::sweep::manifest::{Manifest, quoted};
use crate::sweep::results::Results;
use crate::sweep::seeds::{Shard, parse_seeds};
use crate::sweep::take::Taking;
use crate::sweep::{SweepError, check, merge};
use crate::verdict::DONE;
use anyhow::Context;

use super::common::{interrupted_by_the_user, say, warn};
use super::runs::{Flight, code, complain, jobs, judge};

const REPORT: &str = "report.html";
const TABLES: &str = "tables.txt";
/// The same for programs, and for `csat compare`.
const TABLES_JSON: &str = "tables.json";

/// How many flights are filtered for Tisdale et al.; what is published is of one.
const FLIGHTS: usize = 20;

/// How many looks chapters 4 and 6 take of each setting; what is published is of as many, of ten or of one.
const LOOKS: usize = 100;

/// `csat reproduce`.
pub fn reproduce(arguments: &ReproduceArguments) -> anyhow::Result<u8> {
    judge(match arguments.what {
        Published::Chapter5 => fly(arguments, &plan::CHAPTER5),
        Published::Table1 => fly(arguments, &plan::TABLE1),
        Published::Chapter4 => look(arguments, "chapter4", |scenario, seeds| {
            let seen = Chapter4::look(scenario, seeds);
            (seen.tables(), Box::new(move |tables, again| seen.html(tables, again)))
        }),
        Published::Chapter6 => look(arguments, "chapter6", |scenario, seeds| {
            let seen = Chapter6::look(scenario, seeds);
            (seen.tables(), Box::new(move |tables, again| seen.html(tables, again)))
        }),
        Published::Tisdale => search(arguments),
        Published::Clearing => fly(arguments, &plan::CLEARING),
    })
}

/// What is a sweep.
fn fly(arguments: &ReproduceArguments, plan: &Plan) -> anyhow::Result<u8> {
    let asked = manifest(arguments, plan)?;
    let root = root(arguments, plan.name)?;
    let taking = Taking { shard: Shard::WHOLE, resume: arguments.resume, mix_versions: false };
    let (folder, manifest) = SweepFolder::take(&root, &asked, taking)?;
    let stop = interrupted_by_the_user()?;
    let flight = Flight {
        manifest: &manifest,
        folder: &folder,
        shard: Shard::WHOLE,
        runs: manifest.runs_of(&asked, Shard::WHOLE),
        jobs: jobs(arguments.jobs),
        quiet: arguments.json,
        keep_folders: true,
        fail_fast: false,
    };
    flight.fly(stop.clone())?;
    let results = Results::read(&folder, manifest.clone());
    if stop.load(Ordering::SeqCst) && flight.lacks_runs(&results) {
        return Ok(flight.interrupted(&plan.command(&asked), ""));
    }
    conclude(arguments, plan, &folder, &manifest)
}

/// Writes the tables and the report, and says what they say.
fn conclude(
    arguments: &ReproduceArguments,
    plan: &Plan,
    folder: &SweepFolder,
    manifest: &Manifest,
) -> anyhow::Result<u8> {
    let results = merge::tables(folder, manifest)?;
    let runs = flown::read(folder, &results)?;
    let points = manifest.points.iter().filter(|_| !manifest.vary.is_empty());
    let names: Vec<String> = points.map(|point| point.shown(&manifest.vary, 0)).collect();
    let (mut tables, figures) = match arguments.what {
        Published::Chapter5 => (chapter5::tables(&names, &runs), chapter5::figures(&names, &runs)),
        Published::Clearing => {
            let flown = runs.first().map_or(&[][..], Vec::as_slice);
            let seen = pool(arguments)?.install(|| clearing::Clearings::read(flown))?;
            (seen.tables(), seen.figures())
        }
        _ => (table1::tables(&names, &runs), String::new()),
    };
    let seeds = manifest.seed_list().len();
    let deviations = plan.deviations(seeds, &sets(arguments)).map_err(SweepError::Mistakes)?;
    tables.iter_mut().for_each(|table| table.not_published = deviations.banner());
    let page = page::html(plan.title, &results, &plan.command(manifest), &runs, &tables, &figures);
    folder.write(TABLES, &text(&tables))?;
    folder.write(TABLES_JSON, &json(&tables)?)?;
    folder.write(REPORT, &page)?;
    if !arguments.json {
        complain(&results);
    }
    tell(arguments, &tables, &page::complaints(&runs), folder.root())?;
    Ok(code(&results.counts()))
}

fn manifest(arguments: &ReproduceArguments, plan: &Plan) -> anyhow::Result<Manifest> {
    let request = plan.request(seeds(arguments, "1..10")?, &sets(arguments));
    let request = request.map_err(SweepError::Mistakes)?;
    let pool = pool(arguments)?;
    let (manifest, warnings) = pool.install(|| check::manifest(request))?;
    warn(&warnings, "from `csat check` with the values of a run");
    Ok(manifest)
}

/// The threads that were asked for.
fn pool(arguments: &ReproduceArguments) -> anyhow::Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs(arguments.jobs)).build();
    pool.context("cannot start the threads")
}

fn seeds(arguments: &ReproduceArguments, usual: &str) -> Result<Vec<u64>, SweepError> {
    parse_seeds(arguments.seeds.as_deref().unwrap_or(usual)).map_err(|error| {
        SweepError::Mistakes(vec![Mistake::new(format!("--seeds: {error}"))].into())
    })
}

fn sets(arguments: &ReproduceArguments) -> Vec<String> {
    let duration = arguments.duration.map(|s| format!("run.duration_s={s:?}"));
    arguments.sets.iter().cloned().chain(duration).collect()
}

fn root(arguments: &ReproduceArguments, name: &str) -> Result<PathBuf, SweepError> {
    let usual = || default_root(Path::new("reproductions"), name, arguments.resume, |_| true);
    arguments.out.clone().map_or_else(usual, Ok)
}

fn text(tables: &[Table]) -> String {
    tables.iter().map(Table::text).collect::<Vec<_>>().join("\n")
}

fn json(tables: &[Table]) -> anyhow::Result<String> {
    Ok(serde_json::to_string_pretty(tables)? + "\n")
}

fn tell(
    arguments: &ReproduceArguments,
    tables: &[Table],
    complaints: &str,
    root: &Path,
) -> anyhow::Result<()> {
    if arguments.json {
        return say(&json(tables)?);
    }
    say(&format!("{}\n{complaints}\n{}\n", text(tables), root.join(REPORT).display()))
}

/// The tables of looks, and what makes a page of them and of the command that makes it again.
type Looked = (Vec<Table>, Box<dyn Fn(&[Table], &str) -> String + Send>);

/// Chapters 4 and 6: no missions.
fn look(
    arguments: &ReproduceArguments,
    name: &str,
    take: impl Fn(&Scenario, &[u64]) -> Looked + Sync,
) -> anyhow::Result<u8> {
    let refused = |text: &str| SweepError::Refused(format!("error: {text}"));
    if arguments.duration.is_some() {
        return Err(refused(&format!("--duration: {name} has no missions, it looks once")).into());
    }
    let seeds = seeds(arguments, &format!("1..{LOOKS}"))?;
    let sets = sets(arguments);
    let deviations = Deviations::of(None, (seeds.len(), LOOKS, "looks"), &[], &sets);
    let deviations = deviations.map_err(SweepError::Mistakes)?;
    let request = scenario::Request { scenario: None, sets: &sets, seed: None };
    let Loaded { scenario, warnings, .. } =
        scenario::load(request).map_err(SweepError::Mistakes)?;
    let warnings: Vec<String> = warnings.iter().map(|w| w.render("warning")).collect();
    warn(&warnings, "from `csat check` with the same values");
    let place = Place::take(root(arguments, name)?, arguments.resume)?;
    let pool = pool(arguments)?;
    let (mut tables, html) = pool.install(|| take(&scenario, &seeds));
    tables.iter_mut().for_each(|table| table.not_published = deviations.banner());
    let page = html(&tables, &again(arguments, name, &sets));
    write(arguments, place, &tables, page, &format!("{} looks per setting", seeds.len()))
}

/// Tisdale et al.: flights that are no sweep, as the frames of each are filtered many times.
fn search(arguments: &ReproduceArguments) -> anyhow::Result<u8> {
    let seeds = seeds(arguments, &format!("1..{FLIGHTS}"))?;
    let sets = sets(arguments);
    let plan = tisdale::SETS.map(str::to_owned);
    let flights = (seeds.len(), FLIGHTS, "flights");
    let deviations = Deviations::of(Some("tisdale"), flights, &plan, &sets);
    let deviations = deviations.map_err(SweepError::Mistakes)?;
    let scenarios: Result<Vec<Loaded>, _> =
        seeds.iter().map(|seed| tisdale::scenario(&sets, *seed)).collect();
    let scenarios = scenarios.map_err(SweepError::Mistakes)?;
    let warnings = scenarios.first().map(|loaded| &loaded.warnings[..]).unwrap_or_default();
    let warnings: Vec<String> = warnings.iter().map(|w| w.render("warning")).collect();
    warn(&warnings, "from `csat check tisdale` with the same values");
    let place = Place::take(root(arguments, "tisdale")?, arguments.resume)?;
    let pool = pool(arguments)?;
    let style = progress::style("{wide_bar} {pos}/{len} flights");
    let bar = progress::bar(scenarios.len() as u64, style, arguments.json);
    let seen = pool.install(|| Tisdale::fly(scenarios, || bar.inc(1)));
    bar.finish_and_clear();
    let mut tables = seen.tables();
    tables.iter_mut().for_each(|table| table.not_published = deviations.banner());
    let page = seen.html(&tables, &again(arguments, "tisdale", &sets));
    write(arguments, place, &tables, page, &format!("{} flights", seen.count()))
}

/// The command that makes a reproduction again.
fn again(arguments: &ReproduceArguments, name: &str, sets: &[String]) -> String {
    let seeds = arguments.seeds.iter().map(|seeds| format!(" --seeds {seeds}"));
    let sets = sets.iter().map(|set| format!(" --set {}", quoted(set)));
    format!("csat reproduce {name}{}", seeds.chain(sets).collect::<String>())
}

/// Writes the tables and the page of a reproduction that is no sweep, and says what they say of so `many`.
fn write(
    arguments: &ReproduceArguments,
    place: Place,
    tables: &[Table],
    page: String,
    many: &str,
) -> anyhow::Result<u8> {
    let files = [(TABLES, text(tables)), (TABLES_JSON, json(tables)?), (REPORT, page)];
    let root = place.fill(&files)?;
    tell(arguments, tables, many, &root)?;
    Ok(DONE)
}

/// Where the files of chapters 4 and 6 and of Tisdale et al. go.
enum Place {
    /// A folder that is new or empty.
    New(RunFolder),
    /// One that has them already: they are replaced, each at once.
    Again(PathBuf),
}

impl Place {
    fn take(root: PathBuf, resume: bool) -> Result<Self, SweepError> {
        if resume && root.join(TABLES).exists() {
            return Ok(Self::Again(root));
        }
        match RunFolder::create(Destination::Named(root)) {
            Ok(folder) => Ok(Self::New(folder)),
            Err(error @ FolderError::Io { .. }) => Err(error.into()),
            Err(error) => Err(SweepError::Refused(format!(
                "error: {error}\n  = expected with --out a folder that is new or empty"
            ))),
        }
    }

    fn fill(self, files: &[(&str, String)]) -> Result<PathBuf, FolderError> {
        match self {
            Self::New(folder) => {
                files.iter().try_for_each(|(name, text)| folder.write(name, text))?;
                folder.finish()
            }
            Self::Again(root) => {
                for (name, text) in files {
                    let mut file = PartialFile::create(root.join(name))?;
                    file.write_text(text)?;
                    file.finish()?;
                }
                Ok(root)
            }
        }
    }
}
