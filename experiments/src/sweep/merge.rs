//! From run files to tables and the report.

use std::path::{Path, PathBuf};

use super::folder::SweepFolder;
use super::growth;
use super::lock::Lock;
use super::manifest::Manifest;
use super::pairs::Reference;
use super::plan::Run;
use super::record::RunRecord;
use super::results::Results;
use super::seeds::Shard;
use super::{SweepError, report, table};

/// What [`conclude`] writes.
pub const RESULTS: [&str; 4] = ["sweep.csv", "sweep_means.csv", "sweep_pairs.csv", "report.html"];

/// Writes `sweep.csv`, `sweep_means.csv`, `sweep_pairs.csv` and `report.html` from what is in the folder.
///
/// # Errors
/// When a file is not what it should be, or the system refuses.
pub fn conclude(folder: &SweepFolder, manifest: &Manifest) -> Result<Results, SweepError> {
    let results = tables(folder, manifest)?;
    folder.write("report.html", &report::html(&results))?;
    Ok(results)
}

/// The refusal of an `--against`.
pub fn not_comparable(why: String) -> SweepError {
    SweepError::Refused(format!("error: --against: {why}"))
}

/// The same without the report.
///
/// # Errors
/// As [`conclude`].
pub fn tables(folder: &SweepFolder, manifest: &Manifest) -> Result<Results, SweepError> {
    let results = Results::read(folder, manifest.clone());
    folder.write("sweep.csv", &table::runs_csv(&results))?;
    folder.write("sweep_means.csv", &table::means_csv(&results))?;
    if let Some(reference) = Reference::new(manifest).map_err(not_comparable)? {
        folder.write("sweep_pairs.csv", &table::pairs_csv(&results, &reference))?;
    }
    Ok(results)
}

/// Brings the runs of several folders into the first one, whose sweep grows until it covers all, and
/// concludes.
///
/// # Errors
/// When their sweeps do not go together or contradict each other, when a process flies in the first folder,
/// or the system refuses.
pub fn merge(
    folders: &[PathBuf],
    mix_versions: bool,
    against: Option<&str>,
) -> Result<(SweepFolder, Results), SweepError> {
    let (first, others) = match folders {
        [first, others @ ..] => (SweepFolder::at(first), others),
        [] => return Err(SweepError::Refused("error: there is no folder to merge".to_owned())),
    };
    let there = first.manifest()?;
    let mut whole = there.clone();
    let mut from = Vec::new();
    for other in others {
        let (folder, manifest) = (SweepFolder::at(other), SweepFolder::at(other).manifest()?);
        whole = growth::union(&whole, &manifest, mix_versions).map_err(|lines| {
            let [there, here] = [first.root(), other].map(Path::display);
            let what = format!("`{there}` (there) and `{here}` (here) are different sweeps");
            SweepError::Refused(growth::refusal(&what, &lines))
        })?;
        from.push((folder, manifest));
    }
    if against.is_some() {
        whole.against = against.map(str::to_owned);
    }
    Reference::new(&whole).map_err(not_comparable)?;
    let lock = Lock::manifest(first.root())?;
    first.grow(&there, &whole, &lock)?;
    for (folder, manifest) in &from {
        bring(manifest, folder, &whole, &first)?;
    }
    let results = conclude(&first, &whole)?;
    Ok((first, results))
}

/// What is no run in `from` or `to` counts as missing there.
fn bring(
    manifest: &Manifest,
    from: &SweepFolder,
    whole: &Manifest,
    to: &SweepFolder,
) -> Result<(), SweepError> {
    let runs = manifest.runs(Shard::WHOLE);
    for (run, into) in runs.iter().zip(whole.runs_of(manifest, Shard::WHOLE)) {
        let Ok(Some(new)) = from.run(manifest, run) else { continue };
        match to.run(whole, &into) {
            // A run that failed in one place may have been flown in another.
            Ok(Some(there)) if there.failed.is_none() && new.failed.is_none() => {
                if there.digest() != new.digest() {
                    return Err(contradiction(whole, &into, [from, to], [&new, &there]));
                }
            }
            Ok(Some(there)) if there.failed.is_none() || new.failed.is_some() => {}
            _ => to.put_run(whole, &into, &new.to_json())?,
        }
    }
    Ok(())
}

fn contradiction(
    manifest: &Manifest,
    run: &Run,
    folders: [&SweepFolder; 2],
    records: [&RunRecord; 2],
) -> SweepError {
    let [from, to] = folders.map(|folder| folder.root().display());
    let [ours, theirs] = records.map(|record| &record.build);
    SweepError::Refused(format!(
        "error: `{from}` and `{to}` have different results of `{}`\n  = flown by {ours}, and by \
         {theirs}\n  = fly it again with `{}`",
        manifest.run_name(run),
        manifest.replay(run)
    ))
}
