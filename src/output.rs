//! Output files that appear whole or not at all.
//!
//! A file is opened under a temporary name in the folder where it will stand, before the long work; it gets its name when
//! it is finished. Dropped before that, it leaves nothing behind, and neither does a folder that was made for it.

use anyhow::{anyhow, bail};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// How names of unfinished files begin, and how many random letters and digits follow.
const TEMPORARY: &str = ".raybudget-";
const RANDOM: usize = 6;

/// Whether a file has the name of an unfinished one.
pub(crate) fn is_unfinished(name: &str) -> bool {
    let random = name.strip_prefix(TEMPORARY);
    random.is_some_and(|random| {
        random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
    })
}

/// A file in the making.
pub(crate) struct OutputFile {
    path: PathBuf,
    file: BufWriter<NamedTempFile>,
}

impl OutputFile {
    /// Opens a file that will be called `path`.
    pub(crate) fn create(path: &Path) -> anyhow::Result<Self> {
        let path = target(path)?;
        let file = temporary_beside(&path)?;
        Ok(Self { path, file: BufWriter::new(file) })
    }

    /// Gives the file its name.
    pub(crate) fn finish(self) -> anyhow::Result<()> {
        Self::finish_all([self])
    }

    /// Gives several files their names, once all of them are known to be whole. A file that gets its name and did not
    /// exist before goes again if a later one fails.
    pub(crate) fn finish_all(files: impl IntoIterator<Item = Self>) -> anyhow::Result<()> {
        let mut whole = Vec::new();
        for Self { path, file } in files {
            let temporary = file.into_inner().map_err(|error| cannot_write(&path, error.error()))?;
            whole.push((path, temporary));
        }
        let mut new: Vec<PathBuf> = Vec::new();
        for (path, temporary) in whole {
            let is_new = !path.exists();
            if let Err(error) = temporary.persist(&path) {
                for path in &new {
                    // The first failure is the one to tell.
                    let _ = fs::remove_file(path);
                }
                return Err(cannot_write(&path, &error.error));
            }
            if is_new {
                new.push(path);
            }
        }
        Ok(())
    }

    /// The error for a failed write.
    pub(crate) fn refused(&self, error: &io::Error) -> anyhow::Error {
        cannot_write(&self.path, error)
    }

    /// Writes `bytes` through to the disk, still under the temporary name.
    pub(crate) fn written(mut self, bytes: &[u8]) -> anyhow::Result<Self> {
        self.write_all(bytes).and_then(|()| self.flush()).map_err(|error| self.refused(&error))?;
        Ok(self)
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Checks now that a file can later be written to `path`, and says what its name is once links are followed.
pub(crate) fn check_writable(path: &Path) -> anyhow::Result<PathBuf> {
    let path = target(path)?;
    drop(temporary_beside(&path)?);
    Ok(path)
}

/// Where a file of that name would stand; refuses what must not be replaced.
fn target(path: &Path) -> anyhow::Result<PathBuf> {
    let shown = path.display();
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => bail!("{shown}: this is a folder; give the name of a file in it"),
        Ok(found) if !found.is_file() => {
            bail!("{shown}: this is a device or a pipe; give the name of a file")
        }
        Ok(_) => fs::canonicalize(path).map_err(|error| cannot_write(path, &error)),
        Err(_) if path.file_name().is_none() => bail!("{shown}: this names no file; give the name of a file"),
        Err(_) => Ok(path.to_owned()),
    }
}

fn temporary_beside(path: &Path) -> anyhow::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY).rand_bytes(RANDOM);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|error| cannot_write(path, &error))
}

fn cannot_write(path: &Path, error: &io::Error) -> anyhow::Error {
    let remedy = match error.kind() {
        io::ErrorKind::NotFound => "create its folder first",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to"
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "free space, or choose another disk",
        io::ErrorKind::NotADirectory => "one part of its path is a file; choose another",
        _ => "choose another place",
    };
    anyhow!("{}: cannot write: {error}; {remedy}", path.display())
}

/// A folder for output files, made if it is missing. What was made goes again unless [`OutputFolder::keep`] is called.
pub(crate) struct OutputFolder {
    path: PathBuf,
    /// From the outermost to the innermost.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    pub(crate) fn create(path: &Path) -> anyhow::Result<Self> {
        let missing: Vec<PathBuf> = path
            .ancestors()
            .filter(|folder| *folder != Path::new(""))
            .take_while(|folder| !folder.exists())
            .map(Path::to_owned)
            .collect();
        let mut folder = Self { path: path.to_owned(), made: Vec::new() };
        if path.exists() && !path.is_dir() {
            bail!("{}: this is a file; give a folder", path.display());
        }
        for level in missing.into_iter().rev() {
            fs::create_dir(&level).map_err(|error| cannot_write(&level, &error))?;
            folder.made.push(level);
        }
        Ok(folder)
    }

    /// Opens a file in the folder.
    pub(crate) fn file(&self, name: &str) -> anyhow::Result<OutputFile> {
        OutputFile::create(&self.path.join(name))
    }

    /// Checks now that files of these names can later be written.
    pub(crate) fn check(&self, names: &[&str]) -> anyhow::Result<()> {
        names.iter().try_for_each(|name| self.file(name).map(drop))
    }

    /// Writes `files`, name and bytes, all or none, and keeps the folder.
    pub(crate) fn write_all(self, files: &[(String, Vec<u8>)]) -> anyhow::Result<()> {
        let ready = files.iter().map(|(name, bytes)| self.file(name)?.written(bytes));
        OutputFile::finish_all(ready.collect::<anyhow::Result<Vec<_>>>()?)?;
        self.keep();
        Ok(())
    }

    /// All is well: the folder stays.
    pub(crate) fn keep(mut self) {
        self.made.clear();
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        for folder in self.made.iter().rev() {
            // A folder that has meanwhile got other files is not ours to remove.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Reads a text file that the user named.
pub(crate) fn read_text(path: &Path, what: &str) -> anyhow::Result<String> {
    const MOST: u64 = 1 << 26;
    let shown = path.display();
    let file = fs::File::open(path).map_err(|error| anyhow!("{shown}: cannot open: {error}; give {what}"))?;
    let mut bytes = Vec::new();
    io::Read::read_to_end(&mut io::Read::take(file, MOST + 1), &mut bytes)
        .map_err(|error| anyhow!("{shown}: cannot read: {error}; give {what}"))?;
    if bytes.len() as u64 > MOST {
        bail!("{shown}: more than {MOST} bytes; give {what}");
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        anyhow!("{shown}: byte {at} is not UTF-8 text; give {what}")
    })
}
