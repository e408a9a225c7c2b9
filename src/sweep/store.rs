//! The folder of a sweep: a file for each point that is known.

use crate::console;
use crate::output::{OutputFile, OutputFolder, TEMPORARY, read_text};
use anyhow::{anyhow, bail};
use reports::sweep::Figures;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// The folder, held by this process alone.
pub(crate) struct Store {
    // Fields drop in order: what is in a folder goes before the folder.
    _lock: Lock,
    points: OutputFolder,
    folder: OutputFolder,
    path: PathBuf,
}

/// A file that one process at a time may hold; the system gives it back when the process ends, however that is.
struct Lock {
    file: File,
    path: PathBuf,
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Without it nobody waits: a lock that stays is only a file too many.
        let _ = fs::remove_file(&self.path);
        let _ = self.file.unlock();
    }
}

impl Store {
    /// Opens the folder `path`, which must not have points unless the sweep is resumed.
    pub(crate) fn open(path: &Path, resume: bool) -> anyhow::Result<Self> {
        let folder = OutputFolder::create(path)?;
        let points_path = path.join("points");
        let points = OutputFolder::create(&points_path)?;
        let lock = lock(&path.join("sweep.lock"))?;
        let store = Self { _lock: lock, points, folder, path: points_path };
        store.remove_unfinished(path)?;
        store.remove_unfinished(&store.path)?;
        if !resume && store.has_points()? {
            bail!(
                "{}: it has points of an earlier sweep; add --resume to go on with it, or choose another folder",
                path.display()
            );
        }
        Ok(store)
    }

    /// Removes what a killed process left unfinished.
    fn remove_unfinished(&self, path: &Path) -> anyhow::Result<()> {
        for entry in entries(path)? {
            let unfinished =
                entry.file_name().is_some_and(|name| name.to_string_lossy().starts_with(TEMPORARY));
            if unfinished {
                fs::remove_file(&entry).map_err(|error| {
                    anyhow!("{}: cannot remove: {error}; remove it by hand", entry.display())
                })?;
            }
        }
        Ok(())
    }

    fn has_points(&self) -> anyhow::Result<bool> {
        Ok(entries(&self.path)?.iter().any(|entry| entry.extension().is_some_and(|end| end == "json")))
    }

    /// The figures of a point, where they are known. A torn file, as a machine that lost its power leaves it, is as good as none.
    pub(crate) fn figures(&self, id: &str) -> anyhow::Result<Option<Figures>> {
        let path = self.path.join(file_name(id));
        if !path.exists() {
            return Ok(None);
        }
        let text = read_text(&path, "figures of a point (.json)")?;
        match Figures::parse(&text, &path.display().to_string()) {
            Ok(figures) => Ok(Some(figures)),
            Err(error) => {
                console::warn(&format!("{error}; replaying the point again"));
                Ok(None)
            }
        }
    }

    /// Keeps the figures of a point.
    pub(crate) fn keep(&self, id: &str, figures: &Figures) -> anyhow::Result<()> {
        let file = self.points.file(&file_name(id))?.written(figures.text().as_bytes())?;
        OutputFile::finish(file)
    }

    /// Checks now that files of these names can later be written beside the points.
    pub(crate) fn check(&self, names: &[&str]) -> anyhow::Result<()> {
        self.folder.check(names)
    }

    /// Writes `files` beside the points, all or none.
    pub(crate) fn finish(self, files: &[(String, Vec<u8>)]) -> anyhow::Result<()> {
        self.points.keep();
        self.folder.write_all(files)
    }
}

fn file_name(id: &str) -> String {
    format!("{id}.json")
}

fn entries(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let cannot = |error| anyhow!("{}: cannot read: {error}; choose another folder", path.display());
    let entries = fs::read_dir(path).map_err(cannot)?;
    entries.map(|entry| entry.map(|entry| entry.path()).map_err(cannot)).collect()
}

fn lock(path: &Path) -> anyhow::Result<Lock> {
    let shown = path.display();
    let cannot = |error| anyhow!("{shown}: cannot lock: {error}; choose another folder");
    let file = File::create(path).map_err(cannot)?;
    match file.try_lock() {
        Ok(()) => Ok(Lock { file, path: path.to_owned() }),
        Err(TryLockError::WouldBlock) => {
            bail!("{shown}: another sweep is at work in this folder; wait for it, or choose another folder")
        }
        Err(TryLockError::Error(error)) => Err(cannot(error)),
    }
}
