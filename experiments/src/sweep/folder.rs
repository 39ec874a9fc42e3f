//! The folder of a sweep; several processes may write into it.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::lock::{Lock, partial_of};
use super::manifest::{FORMAT, Manifest};
use super::plan::Run;
use super::record::RunRecord;
use super::seeds::Shard;
use super::{SweepError, refused_by_system};
use crate::run_folder::Destination;

/// The file that makes a folder that of a sweep.
pub(super) const MANIFEST: &str = "sweep.json";

/// A sweep's folder.
#[derive(Debug)]
pub struct SweepFolder {
    pub(super) root: PathBuf,
    /// Distinguishes the temporary files of processes that share the folder.
    pub(super) tag: String,
    /// Keeps other processes from flying the same shard.
    pub(super) _lock: Option<Lock>,
}

/// A file that should be that of a run and is not: empty, cut short, or of another run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is no run: {reason}", path.display())]
pub struct BadRun {
    /// Which file.
    pub path: PathBuf,
    /// Why it is none.
    pub reason: String,
}

/// The folder in `parent` that is used when the user names none: the first free one, or with `resume`
/// the last one that is there. `is_ours` looks into it: `city-2` may be the second sweep of `city` or
/// the first one of a scenario `city-2`.
///
/// # Errors
/// When the system refuses.
pub fn default_root(
    parent: &Path,
    name: &str,
    resume: bool,
    is_ours: impl Fn(&Path) -> bool,
) -> Result<PathBuf, SweepError> {
    let free = Destination::Numbered(parent.join(name)).resolve()?;
    if !resume {
        return Ok(free);
    }
    let number = |path: &Path| {
        let file = path.file_name()?.to_str()?.strip_prefix(name)?;
        if file.is_empty() { Some(1) } else { file.strip_prefix('-')?.parse::<u64>().ok() }
    };
    let there = fs::read_dir(parent).into_iter().flatten().flatten().map(|entry| entry.path());
    let ours = there.filter(|path| number(path).is_some() && is_ours(path));
    Ok(ours.max_by_key(|path| number(path)).unwrap_or(free))
}

impl SweepFolder {
    /// A folder that holds a sweep, to be read and merged.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned(), tag: format!("merge-{}", std::process::id()), _lock: None }
    }

    /// Its path.
    pub fn root(&self) -> &Path {
        &self.root
    }

    pub(super) fn create(&self, name: &str) -> Result<PathBuf, SweepError> {
        let path = self.root.join(name);
        fs::create_dir_all(&path).map_err(|e| refused_by_system("create", &path, e))?;
        Ok(path)
    }

    pub(super) fn temporary(&self, name: &str) -> PathBuf {
        let path = self.root.join(name);
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        path.with_file_name(format!(".{file}.{}.tmp", self.tag))
    }

    /// Writes a file: whole under its name, or not there.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn write(&self, name: &str, text: &str) -> Result<(), SweepError> {
        let (path, temporary) = (self.root.join(name), self.temporary(name));
        // Else a computer that fails may leave the name with nothing behind it.
        File::create(&temporary)
            .and_then(|mut file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))
            .map_err(|e| refused_by_system("write", &temporary, e))?;
        fs::rename(&temporary, &path).map_err(|e| refused_by_system("rename to", &path, e))
    }

    /// The manifest that is there.
    ///
    /// # Errors
    /// When there is none, or it is none.
    pub fn manifest(&self) -> Result<Manifest, SweepError> {
        let (path, expected) = (self.root.join(MANIFEST), "the manifest of a sweep");
        if !path.exists() {
            let folder = self.root.display();
            let text = format!(
                "error: there is no sweep in `{folder}`\n  = expected the folder of a sweep, with its \
                 {MANIFEST}"
            );
            return Err(SweepError::Refused(text));
        }
        let refuse = |reason: String| SweepError::Unreadable {
            path: path.clone(),
            expected,
            reason: format!(
                "{reason}\n  = without the file, --resume with the command of the sweep takes up the runs \
                 that are there"
            ),
        };
        let value: Value = read_json(&path).map_err(refuse)?;
        if let Some(format) = value["format"].as_u64().filter(|&format| format != u64::from(FORMAT))
        {
            return Err(SweepError::Refused(format!(
                "error: the sweep in `{}` was written by another version of csat (format {format}; this one \
                 reads {FORMAT})\n  = expected that version, or --out with another folder",
                self.root.display()
            )));
        }
        let manifest: Manifest =
            serde_json::from_value(value).map_err(|e| refuse(e.to_string()))?;
        manifest.flaw().map_or(Ok(manifest), |reason| Err(refuse(reason)))
    }

    /// The path of a run's file.
    pub fn run_path(&self, manifest: &Manifest, run: &Run) -> PathBuf {
        self.root.join("runs").join(format!("{}.json", manifest.run_name(run)))
    }

    /// Writes a run down.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn put_run(&self, manifest: &Manifest, run: &Run, text: &str) -> Result<(), SweepError> {
        self.write(&format!("runs/{}.json", manifest.run_name(run)), text)
    }

    /// The file of a run; `None` when it is not there.
    ///
    /// # Errors
    /// When it is no such file, or that of another run.
    pub fn run(&self, manifest: &Manifest, run: &Run) -> Result<Option<RunRecord>, BadRun> {
        let path = self.run_path(manifest, run);
        if path.symlink_metadata().is_err() {
            return Ok(None);
        }
        let record: RunRecord =
            read_json(&path).map_err(|reason| BadRun { path: path.clone(), reason })?;
        record.check().map_err(|reason| BadRun { path: path.clone(), reason })?;
        let hash = &manifest.points[run.point].scenario_hash;
        if (&record.scenario_hash, record.seed) == (hash, run.seed) {
            return Ok(Some(record));
        }
        let (other, seed) = (&record.scenario_hash, record.seed);
        let reason = format!("it says that it is seed {seed} of scenario {other}");
        Err(BadRun { path, reason })
    }

    /// Where a run is while it flies: no result yet.
    pub fn partial(&self, shard: Shard, run_name: &str) -> PathBuf {
        partial_of(&self.root, shard).join(run_name)
    }

    /// Where the whole run folder goes, if it is kept.
    pub fn kept(&self, run_name: &str) -> PathBuf {
        self.root.join("folders").join(run_name)
    }
}

fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, String> {
    let text = fs::read_to_string(path).map_err(|e| e.to_string())?;
    if text.trim().is_empty() {
        return Err("it is empty".to_owned());
    }
    serde_json::from_str(&text).map_err(|error| {
        if error.is_eof() { format!("it is cut short: {error}") } else { error.to_string() }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scratch;

    #[test]
    fn what_is_resumed_is_the_last_folder_of_the_same_name_only() {
        let base = scratch("resumed");
        for name in ["city", "city-2", "city-3", "city-speed"] {
            fs::create_dir(base.join(name)).unwrap();
        }
        let root = |resume, is_ours: fn(&Path) -> bool| {
            default_root(&base, "city", resume, is_ours).unwrap()
        };
        assert_eq!(root(false, |_| true), base.join("city-4"));
        assert_eq!(root(true, |_| true), base.join("city-3"));
        assert_eq!(root(true, |path| !path.ends_with("city-3")), base.join("city-2"));
        assert_eq!(root(true, |_| false), base.join("city-4"));
    }
}
