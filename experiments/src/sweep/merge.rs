//! From run files to tables and the report.

use std::path::{Path, PathBuf};

use super::folder::SweepFolder;
use super::manifest::Manifest;
use super::results::Results;
use super::seeds::Shard;
use super::{SweepError, report, table};

/// Writes `sweep.csv`, `sweep_means.csv` and `report.html` from what is in the folder.
///
/// # Errors
/// When a file is not what it should be, or the system refuses.
pub fn conclude(folder: &SweepFolder, manifest: &Manifest) -> Result<Results, SweepError> {
    let results = tables(folder, manifest)?;
    folder.write("report.html", &report::html(&results))?;
    Ok(results)
}

/// The same without the report.
///
/// # Errors
/// As [`conclude`].
pub fn tables(folder: &SweepFolder, manifest: &Manifest) -> Result<Results, SweepError> {
    let results = Results::read(folder, manifest.clone())?;
    folder.write("sweep.csv", &table::runs_csv(&results))?;
    folder.write("sweep_means.csv", &table::means_csv(&results))?;
    Ok(results)
}

/// Brings the runs of several folders of one sweep into the first one and concludes.
///
/// # Errors
/// When the folders are of different sweeps or contradict each other, or the system refuses.
pub fn merge(folders: &[PathBuf]) -> Result<(SweepFolder, Results), SweepError> {
    let (first, others) = match folders {
        [first, others @ ..] => (SweepFolder::at(first), others),
        [] => return Err(SweepError::Refused("error: there is no folder to merge".to_owned())),
    };
    let manifest = first.manifest()?;
    for other in others {
        let there = SweepFolder::at(other);
        let differences = there.manifest()?.differences(&manifest);
        if !differences.is_empty() {
            let lines: String = differences.iter().map(|d| format!("  = {d}\n")).collect();
            return Err(SweepError::Refused(format!(
                "error: `{}` (there) and `{}` (here) are different sweeps\n{}",
                first.root().display(),
                other.display(),
                lines.trim_end()
            )));
        }
        bring(&manifest, &there, &first)?;
    }
    let results = conclude(&first, &manifest)?;
    Ok((first, results))
}

fn bring(manifest: &Manifest, from: &SweepFolder, to: &SweepFolder) -> Result<(), SweepError> {
    let fingerprint = manifest.fingerprint();
    for run in manifest.runs(Shard::WHOLE) {
        let Some(new) = from.run(manifest, &fingerprint, &run)? else { continue };
        match to.run(manifest, &fingerprint, &run)? {
            // A run that failed in one place may have been flown in another.
            Some(there) if there.failed.is_none() && new.failed.is_none() => {
                if there.digest() != new.digest() {
                    return Err(contradiction(manifest, &run, from.root(), to.root()));
                }
            }
            Some(there) if there.failed.is_none() || new.failed.is_some() => {}
            _ => to.put_run(manifest, &run, &new.to_json())?,
        }
    }
    Ok(())
}

fn contradiction(
    manifest: &Manifest,
    run: &super::plan::Run,
    from: &Path,
    to: &Path,
) -> SweepError {
    SweepError::Refused(format!(
        "error: `{}` and `{}` have different results of `{}`\n  = fly it again with `{}`",
        from.display(),
        to.display(),
        manifest.run_name(run),
        manifest.replay(run)
    ))
}
