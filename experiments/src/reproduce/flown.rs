//! What was flown.

use csat_mission::mission::Whole;

use crate::metrics_file;
use crate::series::Series;
use crate::set_membership::SetMembership;
use crate::summary::Summary;
use crate::sweep::SweepError;
use crate::sweep::folder::SweepFolder;
use crate::sweep::results::Results;

/// A mission that was flown to its end.
#[derive(Debug, Clone)]
pub struct Flown {
    /// Its numbers.
    pub summary: Summary,
    /// Its curves.
    pub series: Series,
}

/// The flown missions of each point of a sweep that keeps its run folders.
///
/// # Errors
/// When a file is missing or not what it should be.
pub fn read(folder: &SweepFolder, results: &Results) -> Result<Vec<Vec<Flown>>, SweepError> {
    let manifest = &results.manifest;
    let mut points = vec![Vec::new(); manifest.points.len()];
    for (run, record) in &results.runs {
        let Some(summary) = record.as_ref().and_then(|record| record.summary.clone()) else {
            continue;
        };
        let path = folder.run_path(manifest, run);
        let summary = serde_json::from_value(summary)
            .map_err(|e| unreadable(path, "the file of a run", &e))?;
        let path = folder.kept(&manifest.run_name(run)).join("metrics.csv");
        let curves = metrics_file::read(&path, Whole::<SetMembership>::KIND.columns);
        let series = curves.map_err(|e| unreadable(path, "the metrics of a run", &e))?.fleet;
        points[run.point].push(Flown { summary, series });
    }
    Ok(points)
}

fn unreadable(
    path: std::path::PathBuf,
    expected: &'static str,
    reason: &dyn std::fmt::Display,
) -> SweepError {
    SweepError::Unreadable { path, expected, reason: reason.to_string() }
}
