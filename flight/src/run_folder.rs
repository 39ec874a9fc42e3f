//! The folder of a run: complete under its final name, or not there.
//!
//! Everything is written into a hidden sibling `.NAME.partial-PID`
//! (numbered when that is taken), each file first as `FILE.tmp`,
//! and the folder is renamed at the very end. So what has its final name is whole, and a run that
//! died leaves its pieces where they can be found.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why a run folder could not be written.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The user named a folder that holds something.
    #[error("`{}` exists and is not empty: a run never overwrites anything", .0.display())]
    NotEmpty(PathBuf),
    /// The user named a file, a device or a link.
    #[error("`{}` is not a folder", .0.display())]
    NotAFolder(PathBuf),
    /// The user named a folder in a way that has no name of its own, such as `.`.
    #[error("`{}` has no name of its own that a run folder could get", .0.display())]
    Nameless(PathBuf),
    /// The system refused.
    #[error("cannot {what} `{}`: {error}", path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// With which file or folder.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
}

impl FolderError {
    fn io<'a>(what: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> Self + 'a {
        move |error| Self::Io { what, path: path.to_owned(), error }
    }
}

/// Where a run goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Destination {
    /// A folder that the user named; it must not hold anything.
    Named(PathBuf),
    /// This folder, or with `-2`, `-3`... when it exists.
    Numbered(PathBuf),
}

impl Destination {
    /// The final folder if the run ended now.
    ///
    /// # Errors
    /// [`FolderError::NotEmpty`], [`FolderError::NotAFolder`] or [`FolderError::Nameless`] for a
    /// named folder that cannot be taken.
    pub fn resolve(&self) -> Result<PathBuf, FolderError> {
        match self {
            Self::Named(path) => {
                let kind = path.symlink_metadata().map(|metadata| metadata.is_dir());
                match fs::read_dir(path).map(Iterator::count) {
                    Ok(entries) if entries > 0 => Err(FolderError::NotEmpty(path.clone())),
                    // A link, a file or a device: a folder cannot take its place.
                    _ if kind.is_ok_and(|is_folder| !is_folder) => {
                        Err(FolderError::NotAFolder(path.clone()))
                    }
                    _ if path.file_name().is_none() => Err(FolderError::Nameless(path.clone())),
                    _ => Ok(path.clone()),
                }
            }
            Self::Numbered(path) => {
                let taken = |p: &Path| p.symlink_metadata().is_ok();
                let mut free = path.clone();
                let mut number = 1u64;
                while taken(&free) {
                    number += 1;
                    let mut name = path.file_name().unwrap_or_default().to_owned();
                    name.push(format!("-{number}"));
                    free = path.with_file_name(name);
                }
                Ok(free)
            }
        }
    }
}

/// A run folder in the making.
#[derive(Debug)]
pub struct RunFolder {
    destination: Destination,
    partial: PathBuf,
}

impl RunFolder {
    /// Starts a folder.
    ///
    /// # Errors
    /// As [`Destination::resolve`], and when the system refuses.
    pub fn create(destination: Destination) -> Result<Self, FolderError> {
        let last = destination.resolve()?;
        let parent = match last.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        if let Some(file) = parent.ancestors().find(|path| path.exists() && !path.is_dir()) {
            return Err(FolderError::NotAFolder(file.to_owned()));
        }
        fs::create_dir_all(&parent).map_err(FolderError::io("create", &parent))?;
        let name = last.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let partial = create_partial(&parent, &name)?;
        Ok(Self { destination, partial })
    }

    /// Whether a folder could be started now.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn try_out(destination: Destination) -> Result<(), FolderError> {
        let folder = Self::create(destination)?;
        fs::remove_dir(&folder.partial).map_err(FolderError::io("remove", &folder.partial))
    }

    /// Where files are while the run lasts.
    pub fn partial(&self) -> &Path {
        &self.partial
    }

    /// Starts a file.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn file(&self, name: &str) -> Result<PartialFile, FolderError> {
        PartialFile::create(self.partial.join(name))
    }

    /// Writes a whole file.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn write(&self, name: &str, contents: &str) -> Result<(), FolderError> {
        let mut file = self.file(name)?;
        file.write_text(contents)?;
        file.finish()
    }

    /// Removes the folder and what is in it.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn discard(self) -> Result<(), FolderError> {
        fs::remove_dir_all(&self.partial).map_err(FolderError::io("remove", &self.partial))
    }

    /// Gives the folder its final name and returns it.
    ///
    /// # Errors
    /// When another process wrote into a named folder in the meantime, or the system refuses.
    pub fn finish(self) -> Result<PathBuf, FolderError> {
        let mut attempts = 0;
        loop {
            let last = self.destination.resolve()?;
            match fs::rename(&self.partial, &last) {
                Ok(()) => return Ok(last),
                // Another run took the number between the look and the rename.
                Err(_) if attempts < 100 && last.exists() => attempts += 1,
                Err(error) => return Err(FolderError::io("rename to", &last)(error)),
            }
        }
    }
}

/// A new folder of this process. One that is there belongs to another process: processes in containers
/// that share a disk may have the same id, and the user may want to see what a dead process left.
fn create_partial(parent: &Path, name: &str) -> Result<PathBuf, FolderError> {
    let id = std::process::id();
    let mut number = 1u64;
    loop {
        let suffix = if number == 1 { String::new() } else { format!("-{number}") };
        let partial = parent.join(format!(".{name}.partial-{id}{suffix}"));
        match fs::create_dir(&partial) {
            Ok(()) => return Ok(partial),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(FolderError::io("create", &partial)(error)),
        }
    }
}

/// A file that gets its name when it is whole.
#[derive(Debug)]
pub struct PartialFile {
    path: PathBuf,
    temporary: PathBuf,
    writer: BufWriter<File>,
}

impl PartialFile {
    /// Starts the file that will be at `path`.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: PathBuf) -> Result<Self, FolderError> {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".tmp");
        let temporary = path.with_file_name(name);
        let file = File::create(&temporary).map_err(FolderError::io("create", &temporary))?;
        Ok(Self { path, temporary, writer: BufWriter::new(file) })
    }

    /// Appends text.
    ///
    /// # Errors
    /// When the system refuses, as when the disk is full.
    pub fn write_text(&mut self, text: &str) -> Result<(), FolderError> {
        self.writer.write_all(text.as_bytes()).map_err(FolderError::io("write", &self.path))
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// When the system refuses, as when the disk is full.
    pub fn finish(mut self) -> Result<(), FolderError> {
        self.writer.flush().map_err(FolderError::io("write", &self.path))?;
        fs::rename(&self.temporary, &self.path).map_err(FolderError::io("rename", &self.path))
    }
}

impl Write for PartialFile {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.writer.write(buffer)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scratch;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn nothing_has_its_final_name_before_it_is_whole() {
        let base = scratch("whole");
        let folder = RunFolder::create(Destination::Numbered(base.join("runs/a"))).unwrap();
        let mut file = folder.file("metrics.csv").unwrap();
        file.write_text("half").unwrap();
        assert_eq!(names(folder.partial()), ["metrics.csv.tmp"]);
        assert!(!base.join("runs/a").exists());
        file.write_text(" and half").unwrap();
        file.finish().unwrap();
        let last = folder.finish().unwrap();
        assert_eq!(last, base.join("runs/a"));
        assert_eq!(names(&base.join("runs")), ["a"]);
        assert_eq!(fs::read_to_string(last.join("metrics.csv")).unwrap(), "half and half");
    }

    #[test]
    fn default_folders_are_numbered_and_named_ones_refused() {
        let base = scratch("numbered");
        for expected in ["city-seed1", "city-seed1-2", "city-seed1-3"] {
            let destination = Destination::Numbered(base.join("city-seed1"));
            let folder = RunFolder::create(destination).unwrap();
            assert_eq!(folder.finish().unwrap(), base.join(expected));
        }
        fs::write(base.join("city-seed1/kept"), "mine").unwrap();
        let refused = RunFolder::create(Destination::Named(base.join("city-seed1"))).unwrap_err();
        assert_eq!(
            refused.to_string(),
            format!(
                "`{}` exists and is not empty: a run never overwrites anything",
                base.join("city-seed1").display()
            )
        );
        let file = Destination::Named(base.join("city-seed1/kept"));
        assert!(matches!(RunFolder::create(file), Err(FolderError::NotAFolder(_))));
        assert_eq!(fs::read_to_string(base.join("city-seed1/kept")).unwrap(), "mine");
        assert!(matches!(
            RunFolder::create(Destination::Named(".".into())),
            Err(FolderError::NotEmpty(_))
        ));
        let up = Destination::Named(base.join("city-seed1-3/../city-seed1-3/.."));
        assert!(up.resolve().is_err());
        let nameless = Destination::Named("nowhere/..".into()).resolve();
        assert!(matches!(nameless, Err(FolderError::Nameless(_))));
        // An empty folder is as good as none.
        let folder = RunFolder::create(Destination::Named(base.join("city-seed1-2"))).unwrap();
        folder.write("x", "y").unwrap();
        folder.finish().unwrap();
        assert_eq!(names(&base.join("city-seed1-2")), ["x"]);
    }

    #[test]
    fn a_folder_that_fills_up_during_the_run_is_not_overwritten() {
        let base = scratch("race");
        let named = RunFolder::create(Destination::Named(base.join("out"))).unwrap();
        fs::create_dir(base.join("out")).unwrap();
        fs::write(base.join("out/other"), "").unwrap();
        assert!(matches!(named.finish(), Err(FolderError::NotEmpty(_))));
        let numbered = RunFolder::create(Destination::Numbered(base.join("run"))).unwrap();
        fs::create_dir(base.join("run")).unwrap();
        assert_eq!(numbered.finish().unwrap(), base.join("run-2"));
    }

    #[test]
    fn a_process_with_the_same_id_keeps_its_pieces() {
        let base = scratch("same-id");
        let destination = Destination::Numbered(base.join("run"));
        let first = RunFolder::create(destination.clone()).unwrap();
        first.write("metrics.csv", "of another process").unwrap();
        let second = RunFolder::create(destination).unwrap();
        assert_ne!(first.partial(), second.partial());
        assert_eq!(names(first.partial()), ["metrics.csv"]);
        second.discard().unwrap();
        assert_eq!(first.finish().unwrap(), base.join("run"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_named_with_the_file() {
        let base = scratch("full");
        let folder = RunFolder::create(Destination::Numbered(base.join("run"))).unwrap();
        let path = folder.partial().join("metrics.csv");
        std::os::unix::fs::symlink("/dev/full", path.with_extension("csv.tmp")).unwrap();
        let mut file = folder.file("metrics.csv").unwrap();
        file.write_text("1,2,3\n").unwrap();
        let error = file.finish().unwrap_err().to_string();
        let expected = format!("cannot write `{}`: No space left on device", path.display());
        assert!(error.starts_with(&expected), "{error}");
        assert!(!path.exists());
    }
}
