//! Taking the folder of a sweep: what may be in it, which part of the sweep no other process flies, and how
//! the sweep in it grows.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::folder::{MANIFEST, SweepFolder};
use super::lock::{Lock, PARTIAL, partial_of};
use super::manifest::Manifest;
use super::pairs::Reference;
use super::plan::Point;
use super::seeds::Shard;
use super::{SweepError, growth, merge, refused_by_system};

/// How to take a folder.
#[derive(Debug, Clone, Copy)]
pub struct Taking {
    /// The part of the sweep that this process flies.
    pub shard: Shard,
    /// Whether runs may be there already, and the sweep may grow.
    pub resume: bool,
    /// Whether they may be those of another version of the program.
    pub mix_versions: bool,
}

impl SweepFolder {
    /// Takes a folder for a sweep: a new or empty one, or one with a sweep in it that is to be resumed, or
    /// of which another shard is to be flown. Gives the sweep in the folder, which with `resume` has grown
    /// until it covers `asked`.
    ///
    /// # Errors
    /// When the folder holds something else, or the system refuses.
    pub fn take(
        root: &Path,
        asked: &Manifest,
        taking: Taking,
    ) -> Result<(Self, Manifest), SweepError> {
        let Taking { shard, resume, mix_versions } = taking;
        let tag = format!("{}of{}-{}", shard.index, shard.count, std::process::id());
        let folder = Self { root: root.to_owned(), tag, _lock: None };
        let shared = shard.count > 1;
        if !root.join(MANIFEST).exists() {
            Reference::new(asked).map_err(merge::not_comparable)?;
            folder.refuse_strangers(resume)?;
            folder.create("runs")?;
        } else if !resume && !shared {
            return Err(SweepError::Refused(format!(
                "error: `{}` holds a sweep\n  = expected with --out a folder that is new or empty, \
                 or --resume to go on with that sweep",
                root.display()
            )));
        }
        let manifest_lock = Lock::manifest(folder.root())?;
        if !root.join(MANIFEST).exists() {
            folder.put_manifest(asked)?;
        }
        let there = folder.manifest()?;
        let other = format!("`{}` holds another sweep", root.display());
        let whole = growth::union(&there, asked, mix_versions)
            .map_err(|lines| SweepError::Refused(growth::refusal(&other, &lines)))?;
        if whole != there && !resume {
            let lines = ["expected --resume to let it grow".to_owned()];
            return Err(SweepError::Refused(growth::refusal(&other, &lines)));
        }
        Reference::new(&whole).map_err(merge::not_comparable)?;
        folder.create("runs")?;
        if shared && !resume {
            folder.refuse_flown(&whole, asked, shard)?;
        }
        // Before anything of another process is taken for that of a dead one.
        let lock = Lock::shard(folder.root(), shard)?;
        folder.grow(&there, &whole, &lock)?;
        folder.clear_partial(shard)?;
        drop(manifest_lock);
        Ok((Self { _lock: Some(lock), ..folder }, whole))
    }

    /// A shard that is flown twice without `--resume` is a mistake.
    fn refuse_flown(
        &self,
        whole: &Manifest,
        asked: &Manifest,
        shard: Shard,
    ) -> Result<(), SweepError> {
        let runs = whole.runs_of(asked, shard);
        let Some(run) = runs.iter().find(|run| self.run_path(whole, run).exists()) else {
            return Ok(());
        };
        Err(SweepError::Refused(format!(
            "error: shard {}/{} has flown `{}` already\n  = expected --resume to go on with it",
            shard.index,
            shard.count,
            whole.run_name(run)
        )))
    }

    /// Makes the sweep in the folder a larger one. Runs keep their files, under the names that they have
    /// in it.
    ///
    /// # Errors
    /// When another process than that of `lock` flies in the folder, or the system refuses.
    pub(super) fn grow(
        &self,
        there: &Manifest,
        whole: &Manifest,
        lock: &Lock,
    ) -> Result<(), SweepError> {
        let others_fly = lock.others_fly();
        if whole != there {
            if others_fly {
                return Err(SweepError::Refused(format!(
                    "error: another process is flying in `{}`\n  = expected to let the sweep grow when \
                     it has ended",
                    self.root.display()
                )));
            }
            self.write(MANIFEST, &whole.to_json())?;
        }
        // Also when the sweep is as it was: a process may have died before it came to this.
        if others_fly { Ok(()) } else { self.rename_runs(whole) }
    }

    /// Gives runs the names that they have in this sweep: other keys and labels make other names of the
    /// same mission.
    fn rename_runs(&self, whole: &Manifest) -> Result<(), SweepError> {
        let points: BTreeMap<&str, &Point> =
            whole.points.iter().map(|point| (point.scenario_hash.as_str(), point)).collect();
        for (folder, ending) in [("runs", ".json"), ("folders", "")] {
            let folder = self.root.join(folder);
            for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
                let file = entry.file_name().to_string_lossy().into_owned();
                let name = file.strip_suffix(ending).unwrap_or(&file);
                let Some((old, seed)) = name.rsplit_once("-seed") else { continue };
                let hash = old.rsplit('-').next().unwrap_or_default();
                let Some(point) = points.get(hash).filter(|point| point.name != old) else {
                    continue;
                };
                let path = folder.join(format!("{}-seed{seed}{ending}", point.name));
                fs::rename(entry.path(), &path)
                    .map_err(|e| refused_by_system("rename to", &path, e))?;
            }
        }
        Ok(())
    }

    /// What is in a folder without a manifest must be what another shard is just writing, or with `--resume`
    /// what a sweep left whose manifest is lost.
    fn refuse_strangers(&self, resume: bool) -> Result<(), SweepError> {
        let root = &self.root;
        if root.symlink_metadata().is_ok() && !root.is_dir() {
            let text = format!("error: `{}` is not a folder", root.display());
            return Err(SweepError::Refused(text));
        }
        let mut names = fs::read_dir(root).into_iter().flatten().flatten().map(|e| e.file_name());
        let ours = |name: &str| {
            [MANIFEST, "runs", PARTIAL].contains(&name)
                || name.starts_with(".sweep.json.")
                || resume && (merge::RESULTS.contains(&name) || name == "folders")
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

    /// Removes what died in the middle of a run of this shard.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn clear_partial(&self, shard: Shard) -> Result<(), SweepError> {
        let partial = partial_of(self.root(), shard);
        if partial.exists() {
            fs::remove_dir_all(&partial).map_err(|e| refused_by_system("remove", &partial, e))?;
        }
        Ok(())
    }
}
