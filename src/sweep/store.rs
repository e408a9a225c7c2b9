//! The folder of a sweep: a file for each point that is known.

use crate::console;
use crate::output::{OutputFile, OutputFolder, is_unfinished, read_text};
use crate::report::TOOL;
use anyhow::{anyhow, bail};
use reports::sweep::Figures;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// The folder, held by this process alone.
pub(crate) struct Store {
    lock: Lock,
    points: OutputFolder,
    folder: OutputFolder,
    path: PathBuf,
    points_path: PathBuf,
}

/// A file that one process at a time may hold; the system gives it back when the process ends, however that is.
struct Lock {
    path: PathBuf,
    _file: File,
}

impl Drop for Lock {
    /// It stays with points, as another process may have opened it by now; a folder without any is not left behind.
    fn drop(&mut self) {
        let folder = self.path.parent().map(entries);
        if folder.is_some_and(|entries| entries.is_ok_and(|entries| entries.len() == 1)) {
            // Without it nobody waits: a lock that stays is only a file too many.
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl Store {
    /// Opens the folder `path`, which must not have points unless the sweep is resumed.
    pub(crate) fn open(path: &Path, resume: bool) -> anyhow::Result<Self> {
        let folder = OutputFolder::create(path)?;
        let points_path = path.join("points");
        let points = OutputFolder::create(&points_path)?;
        let lock = lock(points_path.join(".lock"))?;
        let store = Self { lock, points, folder, path: path.to_owned(), points_path };
        store.remove_unfinished()?;
        if !resume && store.has_points()? {
            bail!(
                "{}: it has points of an earlier sweep; add --resume to go on with it, or choose another folder",
                path.display()
            );
        }
        Ok(store)
    }

    /// Removes files that a killed process left unfinished.
    fn remove_unfinished(&self) -> anyhow::Result<()> {
        let unfinished = |path: &&PathBuf| {
            path.is_file() && path.file_name().is_some_and(|name| is_unfinished(&name.to_string_lossy()))
        };
        for folder in [&self.path, &self.points_path] {
            entries(folder)?.iter().filter(unfinished).try_for_each(|path| remove(path))?;
        }
        Ok(())
    }

    fn has_points(&self) -> anyhow::Result<bool> {
        let is_point = |entry: &PathBuf| entry.extension().is_some_and(|end| end == "json");
        Ok(entries(&self.points_path)?.iter().any(is_point))
    }

    /// The figures of a point, where they are known. A file that is not theirs, such as a torn one that a machine leaves that lost its power, is as
    /// good as none.
    pub(crate) fn figures(&self, id: &str) -> Option<Figures> {
        let path = self.points_path.join(file_name(id));
        if !path.exists() {
            return None;
        }
        let shown = path.display();
        let read = read_text(&path, "figures of a point (.json)").and_then(|text| {
            let figures = Figures::parse(&text, &shown.to_string())?;
            if figures.point != id || figures.tool != TOOL {
                bail!("{shown}: the figures of another point, or by another version of this program");
            }
            Ok(figures)
        });
        read.map_err(|error| console::warn(&format!("{error}; replaying the point again"))).ok()
    }

    /// Keeps the figures of a point.
    pub(crate) fn keep(&self, figures: &Figures) -> anyhow::Result<()> {
        let file = self.points.file(&file_name(&figures.point))?.written(figures.text().as_bytes())?;
        OutputFile::finish(file)
    }

    /// Checks now that tables and charts of these names can later be written beside the points.
    pub(crate) fn check(&self, charts: impl Iterator<Item = String>) -> anyhow::Result<()> {
        self.folder.check(&["sweep.csv", "columns.csv", "pareto.csv"])?;
        let mut stems = charts.chain(["pareto".to_owned()]);
        stems.try_for_each(|stem| self.folder.check(&[&format!("{stem}.svg"), &format!("{stem}.png")]))
    }

    /// Writes `files` beside the points, all or none; charts of an earlier plan go.
    pub(crate) fn finish(self, files: &[(String, Vec<u8>)]) -> anyhow::Result<()> {
        let Self { lock: _lock, points, folder, path, .. } = self;
        points.keep();
        folder.write_all(files)?;
        let is_old_chart = |entry: &&PathBuf| {
            let name = entry.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
            let is_chart = (name.starts_with("effect-") || name.starts_with("pareto."))
                && (name.ends_with(".svg") || name.ends_with(".png"));
            is_chart && files.iter().all(|(written, _)| *written != name)
        };
        entries(&path)?.iter().filter(is_old_chart).try_for_each(|path| remove(path))
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

fn remove(path: &Path) -> anyhow::Result<()> {
    fs::remove_file(path)
        .map_err(|error| anyhow!("{}: cannot remove: {error}; remove it by hand", path.display()))
}

fn lock(path: PathBuf) -> anyhow::Result<Lock> {
    let shown = path.display();
    let cannot = |error| anyhow!("{shown}: cannot lock: {error}; choose another folder");
    if fs::symlink_metadata(&path).is_ok_and(|found| !found.is_file()) {
        bail!("{shown}: this is a link or a folder, and sweeps lock a file of that name; remove it");
    }
    let file = File::options().write(true).create(true).truncate(false).open(&path).map_err(cannot)?;
    match file.try_lock() {
        Ok(()) => Ok(Lock { path, _file: file }),
        Err(TryLockError::WouldBlock) => {
            bail!("{shown}: another sweep is at work in this folder; wait for it, or choose another folder")
        }
        Err(TryLockError::Error(error)) => Err(cannot(error)),
    }
}
