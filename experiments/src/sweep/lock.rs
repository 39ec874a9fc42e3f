//! That no two processes fly the same shard into the same folder: each would take what the other has
//! under way for what a dead process left, and remove it.

use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::folder::SweepFolder;
use super::seeds::Shard;
use super::{SweepError, refused_by_system};

/// A shard that no other process may take, where the file system has locks. The system lets go of it with
/// the process, however that ends; the file goes when this is dropped.
#[derive(Debug)]
pub(super) struct ShardLock {
    path: PathBuf,
    _file: File,
}

impl ShardLock {
    /// Takes a shard.
    ///
    /// # Errors
    /// When another process has it, or the system refuses.
    pub(super) fn take(folder: &SweepFolder, shard: Shard) -> Result<Self, SweepError> {
        let path = folder.partial_of(shard).with_extension("lock");
        let refused = |what, error| refused_by_system(what, &path, error);
        loop {
            let file = match open(&path) {
                // Whoever was the last to end has just removed the folder.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                file => file.map_err(|error| refused("create", error))?,
            };
            match file.try_lock() {
                // Whoever had it has just removed the file.
                Ok(()) if !is_at(&file, &path) => {}
                // Without locks nobody can know.
                Ok(()) | Err(TryLockError::Error(_)) => return Ok(Self { path, _file: file }),
                Err(TryLockError::WouldBlock) => return Err(taken(folder, shard)),
            }
        }
    }
}

impl Drop for ShardLock {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
        // Only when no other shard is at work.
        let _ = self.path.parent().map(fs::remove_dir);
    }
}

fn open(path: &Path) -> io::Result<File> {
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    File::options().write(true).create(true).truncate(false).open(path)
}

/// Whether a path leads to this very file.
fn is_at(file: &File, path: &Path) -> bool {
    let [ours, there] = [file.metadata(), fs::metadata(path)];
    let id = |metadata: io::Result<fs::Metadata>| metadata.ok().map(|m| (m.dev(), m.ino()));
    id(there).is_some_and(|there| id(ours) == Some(there))
}

fn taken(folder: &SweepFolder, shard: Shard) -> SweepError {
    let what = match shard {
        Shard::WHOLE => "the sweep".to_owned(),
        Shard { index, count } => format!("shard {index}/{count} of the sweep"),
    };
    SweepError::Refused(format!(
        "error: another process is flying {what} in `{}`\n  = expected to start when it has ended, or \
         with another --out",
        folder.root().display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scratch;

    #[test]
    fn a_shard_is_taken_once_until_it_is_let_go() {
        let base = scratch("lock");
        let folder = SweepFolder::at(&base);
        let [first, second] = ["1/2", "2/2"].map(|text| Shard::parse(text).unwrap());
        let held = ShardLock::take(&folder, first).unwrap();
        let refusal = ShardLock::take(&folder, first).unwrap_err().to_string();
        assert!(
            refusal.starts_with("error: another process is flying shard 1/2 of the sweep in `")
        );
        let other = ShardLock::take(&folder, second).unwrap();
        drop(held);
        let again = ShardLock::take(&folder, first).unwrap();
        assert!(base.join(".partial/1of2.lock").exists());
        drop((other, again));
        assert!(!base.join(".partial").exists());
    }

    /// A file that somebody left behind is nobody's.
    #[test]
    fn a_dead_process_holds_nothing() {
        let base = scratch("lock-dead");
        fs::create_dir(base.join(".partial")).unwrap();
        File::create(base.join(".partial/1of1.lock")).unwrap();
        let folder = SweepFolder::at(&base);
        let _held = ShardLock::take(&folder, Shard::WHOLE).unwrap();
        assert!(ShardLock::take(&folder, Shard::WHOLE).is_err());
    }
}
