//! That no two processes fly the same shard into the same folder (each would take what the other has
//! under way for what a dead process left, and remove it), and that a sweep does not grow while a process
//! flies in its folder.

use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::seeds::Shard;
use super::{SweepError, refused_by_system};

/// The folder of what is under way, by shard.
pub(super) const PARTIAL: &str = ".partial";
/// What the files of locks end with.
const LOCK: &str = "lock";

/// A file that no other process may lock, where the file system has locks. The system lets go of it with
/// the process, however that ends; the file goes when this is dropped.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Takes a shard.
    ///
    /// # Errors
    /// When another process has it, or the system refuses.
    pub(super) fn shard(root: &Path, shard: Shard) -> Result<Self, SweepError> {
        let path = partial_of(root, shard).with_extension(LOCK);
        Self::take(path, |file| file.try_lock(), || taken(root, shard))
    }

    /// Takes the manifest: waits until no other process looks whether it may start.
    ///
    /// # Errors
    /// When the system refuses.
    pub(super) fn manifest(root: &Path) -> Result<Self, SweepError> {
        let path = partial_of(root, Shard::WHOLE).with_file_name("manifest.lock");
        let wait = |file: &File| file.lock().map_err(TryLockError::Error);
        Self::take(path, wait, || unreachable!("it waits"))
    }

    fn take(
        path: PathBuf,
        lock: impl Fn(&File) -> Result<(), TryLockError>,
        taken: impl Fn() -> SweepError,
    ) -> Result<Self, SweepError> {
        loop {
            let file = match open(&path) {
                // The last process that flew has just removed the folder.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                file => file.map_err(|error| refused_by_system("create", &path, error))?,
            };
            match lock(&file) {
                // The process that had it has just removed the file.
                Ok(()) if !is_at(&file, &path) => {}
                // Without locks no process can know.
                Ok(()) | Err(TryLockError::Error(_)) => return Ok(Self { path, _file: file }),
                Err(TryLockError::WouldBlock) => return Err(taken()),
            }
        }
    }

    /// Whether a process has a shard of the folder, other than this lock.
    pub(super) fn others_fly(&self) -> bool {
        let folder = self.path.parent().map(fs::read_dir);
        let paths = folder.into_iter().flatten().flatten().flatten().map(|entry| entry.path());
        let shards = paths.filter(|path| {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            path.extension().is_some_and(|e| e == LOCK) && name.contains("of") && *path != self.path
        });
        shards.filter_map(|path| File::open(path).ok()).any(|file| {
            let taken = file.try_lock();
            matches!(taken, Err(TryLockError::WouldBlock))
        })
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
        // Only when no other shard is at work.
        let _ = self.path.parent().map(fs::remove_dir);
    }
}

/// Where what is of a shard alone is while it flies.
pub(super) fn partial_of(root: &Path, shard: Shard) -> PathBuf {
    root.join(PARTIAL).join(format!("{}of{}", shard.index, shard.count))
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

fn taken(root: &Path, shard: Shard) -> SweepError {
    let what = match shard {
        Shard::WHOLE => "the sweep".to_owned(),
        Shard { index, count } => format!("shard {index}/{count} of the sweep"),
    };
    SweepError::Refused(format!(
        "error: another process is flying {what} in `{}`\n  = expected to start when it has ended, or \
         with another --out",
        root.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scratch;

    #[test]
    fn a_shard_is_taken_once_until_it_is_let_go() {
        let base = scratch("lock");
        let [first, second] = ["1/2", "2/2"].map(|text| Shard::parse(text).unwrap());
        let held = Lock::shard(&base, first).unwrap();
        let refusal = Lock::shard(&base, first).unwrap_err().to_string();
        assert!(
            refusal.starts_with("error: another process is flying shard 1/2 of the sweep in `")
        );
        let other = Lock::shard(&base, second).unwrap();
        drop(held);
        let again = Lock::shard(&base, first).unwrap();
        assert!(base.join(".partial/1of2.lock").exists());
        drop((other, again));
        assert!(!base.join(".partial").exists());
    }

    #[test]
    fn a_shard_knows_of_others() {
        let base = scratch("lock-others");
        let [first, second] = ["1/2", "2/2"].map(|text| Shard::parse(text).unwrap());
        let held = Lock::shard(&base, first).unwrap();
        let _manifest = Lock::manifest(&base).unwrap();
        File::create(base.join(".partial/7of9.lock")).unwrap();
        assert!(!held.others_fly());
        let other = Lock::shard(&base, second).unwrap();
        assert!(held.others_fly() && other.others_fly());
        drop(other);
        assert!(!held.others_fly());
    }

    /// A file that a dead process left is locked by none.
    #[test]
    fn a_dead_process_holds_nothing() {
        let base = scratch("lock-dead");
        fs::create_dir(base.join(".partial")).unwrap();
        File::create(base.join(".partial/1of1.lock")).unwrap();
        let _held = Lock::shard(&base, Shard::WHOLE).unwrap();
        assert!(Lock::shard(&base, Shard::WHOLE).is_err());
    }
}
