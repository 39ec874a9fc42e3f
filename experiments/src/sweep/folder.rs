//! The folder of a sweep; several processes may write into it.

use std::fs;
use std::path::{Path, PathBuf};

use super::lock::ShardLock;
use super::manifest::Manifest;
use super::plan::Run;
use super::record::RunRecord;
use super::seeds::Shard;
use super::{SweepError, refused_by_system};
use crate::run_folder::Destination;

const MANIFEST: &str = "sweep.json";
/// Of what is under way, by shard.
const PARTIAL: &str = ".partial";

/// A sweep's folder.
#[derive(Debug)]
pub struct SweepFolder {
    root: PathBuf,
    /// Distinguishes the temporary files of processes that share the folder.
    tag: String,
    /// Keeps other processes from flying the same shard.
    _lock: Option<ShardLock>,
}

/// How to take a folder.
#[derive(Debug, Clone, Copy)]
pub struct Taking {
    /// The part of the sweep that this process flies.
    pub shard: Shard,
    /// Whether runs may be there already.
    pub resume: bool,
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

    /// Takes a folder for a sweep: a new or empty one, or one with the same sweep in it when that is
    /// to be resumed, or for another shard of it.
    ///
    /// # Errors
    /// When the folder holds something else, or the system refuses.
    pub fn take(root: &Path, manifest: &Manifest, taking: Taking) -> Result<Self, SweepError> {
        let Taking { shard, resume } = taking;
        let tag = format!("{}of{}-{}", shard.index, shard.count, std::process::id());
        let folder = Self { root: root.to_owned(), tag, _lock: None };
        let shared = shard.count > 1;
        if !root.join(MANIFEST).exists() {
            folder.refuse_strangers()?;
            folder.create("runs")?;
            folder.put_manifest(manifest)?;
        } else if !resume && !shared {
            return Err(SweepError::Refused(format!(
                "error: `{}` holds a sweep\n  = expected with --out a folder that is new or empty, \
                 or --resume to go on with that sweep",
                root.display()
            )));
        }
        // Also after writing it: another shard may have been quicker.
        let there = folder.manifest()?;
        let differences = manifest.differences(&there);
        if !differences.is_empty() {
            let lines: String = differences.iter().map(|d| format!("  = {d}\n")).collect();
            return Err(SweepError::Refused(format!(
                "error: `{}` holds another sweep\n{}",
                root.display(),
                lines.trim_end()
            )));
        }
        folder.create("runs")?;
        if shared && !resume {
            let runs = manifest.runs(shard);
            let flown = runs.iter().find(|run| folder.run_path(manifest, run).exists());
            if let Some(run) = flown {
                return Err(SweepError::Refused(format!(
                    "error: shard {}/{} has flown `{}` already\n  = expected --resume to go on \
                     with it",
                    shard.index,
                    shard.count,
                    manifest.run_name(run)
                )));
            }
        }
        // Before anything of another process is taken for that of a dead one.
        let lock = ShardLock::take(&folder, shard)?;
        folder.clear_partial(shard)?;
        Ok(Self { _lock: Some(lock), ..folder })
    }

    /// Its path.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What is in a folder without a manifest must be what another shard is just writing.
    fn refuse_strangers(&self) -> Result<(), SweepError> {
        let root = &self.root;
        if root.symlink_metadata().is_ok() && !root.is_dir() {
            let text = format!("error: `{}` is not a folder", root.display());
            return Err(SweepError::Refused(text));
        }
        let mut names = fs::read_dir(root).into_iter().flatten().flatten().map(|e| e.file_name());
        let ours = |name: &str| {
            [MANIFEST, "runs", PARTIAL].contains(&name) || name.starts_with(".sweep.json.")
        };
        match names.find(|name| !ours(&name.to_string_lossy())) {
            None => Ok(()),
            Some(name) => Err(SweepError::Refused(format!(
                "error: `{}` exists and is not empty: `{}` is in it\n  = expected with --out a \
                 folder that is new or empty, or one of a sweep with --resume",
                root.display(),
                name.to_string_lossy()
            ))),
        }
    }

    fn create(&self, name: &str) -> Result<PathBuf, SweepError> {
        let path = self.root.join(name);
        fs::create_dir_all(&path).map_err(|e| refused_by_system("create", &path, e))?;
        Ok(path)
    }

    fn put_manifest(&self, manifest: &Manifest) -> Result<(), SweepError> {
        let path = self.root.join(MANIFEST);
        let temporary = self.temporary(MANIFEST);
        fs::write(&temporary, manifest.to_json())
            .map_err(|e| refused_by_system("write", &temporary, e))?;
        // Unlike a rename, a link never replaces the manifest of a quicker shard.
        let linked = fs::hard_link(&temporary, &path);
        if linked.is_err() && !path.exists() {
            // A file system without links.
            return fs::rename(&temporary, &path)
                .map_err(|e| refused_by_system("rename to", &path, e));
        }
        fs::remove_file(&temporary).map_err(|e| refused_by_system("remove", &temporary, e))
    }

    fn temporary(&self, name: &str) -> PathBuf {
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
        fs::write(&temporary, text).map_err(|e| refused_by_system("write", &temporary, e))?;
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
        let manifest: Manifest = read_json(&path, expected)?;
        match manifest.flaw() {
            None => Ok(manifest),
            Some(reason) => Err(SweepError::Unreadable { path, expected, reason }),
        }
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

    /// The file of a run; `None` when it is not there. `fingerprint` is that of the manifest, which
    /// takes a while for a large sweep.
    ///
    /// # Errors
    /// When it is no such file, or that of another sweep.
    pub fn run(
        &self,
        manifest: &Manifest,
        fingerprint: &str,
        run: &Run,
    ) -> Result<Option<RunRecord>, SweepError> {
        let path = self.run_path(manifest, run);
        if !path.exists() {
            return Ok(None);
        }
        let record: RunRecord = read_json(&path, "the file of a run")?;
        if record.sweep != fingerprint {
            let reason = format!("it belongs to sweep {}", record.sweep);
            return Err(SweepError::Unreadable { path, expected: "a run of this sweep", reason });
        }
        Ok(Some(record))
    }

    /// Where a run is while it flies: nobody's result.
    pub fn partial(&self, shard: Shard, run_name: &str) -> PathBuf {
        self.partial_of(shard).join(run_name)
    }

    /// Where the whole run folder goes, if it is kept.
    pub fn kept(&self, run_name: &str) -> PathBuf {
        self.root.join("folders").join(run_name)
    }

    /// Where what is of this shard alone is while it flies.
    pub(super) fn partial_of(&self, shard: Shard) -> PathBuf {
        self.root.join(PARTIAL).join(format!("{}of{}", shard.index, shard.count))
    }

    /// Removes what died in the middle of a run of this shard.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn clear_partial(&self, shard: Shard) -> Result<(), SweepError> {
        let partial = self.partial_of(shard);
        if partial.exists() {
            fs::remove_dir_all(&partial).map_err(|e| refused_by_system("remove", &partial, e))?;
        }
        Ok(())
    }
}

fn read_json<T: serde::de::DeserializeOwned>(
    path: &Path,
    expected: &'static str,
) -> Result<T, SweepError> {
    let refuse =
        |reason: String| SweepError::Unreadable { path: path.to_owned(), expected, reason };
    let text = fs::read_to_string(path).map_err(|e| refuse(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| refuse(e.to_string()))
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
