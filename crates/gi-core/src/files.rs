//! Atomic writes: a killed run leaves the old file or the new one, never half of one.

use std::ffi::{OsStr, OsString};
use std::fs::{DirEntry, File};
use std::io::{BufWriter, Error, ErrorKind, Read, Result, Write};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockWriteGuard};
use std::time::Duration;

use tempfile::NamedTempFile;

/// A file that is being written.
pub type Out = BufWriter<NamedTempFile>;

/// Read-locked while a file is being written; write-locked to end the process.
static WRITING: RwLock<()> = RwLock::new(());

/// Wait until no file is half-written, and block further writes while the returned guard exists. Used to end the
/// process.
pub fn hold_writes() -> RwLockWriteGuard<'static, ()> {
    WRITING.write().unwrap_or_else(PoisonError::into_inner)
}

/// Read a file that the user named.
///
/// # Errors
/// A message of one line with the file's name and the cause.
pub fn read(path: &Path) -> std::result::Result<Vec<u8>, String> {
    let cannot = |why: &dyn std::fmt::Display| format!("cannot read {}: {why}", path.display());
    let mut bytes = Vec::new();
    let mut file = open_regular(path).map_err(|e| cannot(&e))?;
    file.read_to_end(&mut bytes).map_err(|e| cannot(&e))?;
    Ok(bytes)
}

/// The message about a file that can be read, but not used.
pub fn refusal(path: &Path, cause: &str) -> String {
    format!("cannot use {}: {cause}", path.display())
}

/// Open a file. A device might never end, and a FIFO might never begin, so they are refused.
///
/// # Errors
/// A message of one line without the file's name.
pub fn open_regular(path: &Path) -> std::result::Result<File, String> {
    let kind = path.metadata().map_err(|e| e.to_string())?.file_type();
    if kind.is_dir() {
        return Err("it is a folder".into());
    }
    if !kind.is_file() {
        return Err("it is not a regular file but a device, a FIFO or a socket".into());
    }
    File::open(path).map_err(|e| e.to_string())
}

/// Parse the name of a file of points to write: a point cloud (.ply) or a table (.csv).
///
/// # Errors
/// The message names the allowed extensions.
pub fn points_file(name: &str) -> std::result::Result<PathBuf, String> {
    let path = PathBuf::from(name);
    let known = |e: &OsStr| ["ply", "csv"].iter().any(|k| e.eq_ignore_ascii_case(k));
    let is_known = path.extension().is_some_and(known);
    is_known.then_some(path).ok_or_else(|| "the file's name must end in .ply or .csv".into())
}

/// Whether a file of points is a table, by its name; otherwise it is a point cloud.
pub fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))
}

/// Write a file: to a temporary name beside it, then rename. A symbolic link stays, and its target is written.
///
/// # Errors
/// The system's message, without the file's name. The file is unchanged.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |out| out.write_all(bytes))
}

/// The same, with `fill` writing the bytes.
///
/// # Errors
/// The error of `fill` or of the system, without the file's name. The file is unchanged.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut Out) -> Result<()>) -> Result<()> {
    let _whole = WRITING.read().unwrap_or_else(PoisonError::into_inner);
    refuse_special(path)?;
    let path = &target(path)?;
    remove_abandoned(path);
    let mut out = BufWriter::new(temporary(path)?);
    fill(&mut out).map_err(without_name)?;
    let part = out.into_inner().map_err(|e| without_name(e.into_error()))?;
    part.as_file().sync_all()?;
    // Whatever fails before this removes the temporary file.
    part.persist(path)?;
    Ok(())
}

/// An error without the temporary name, which would only confuse.
fn without_name(error: Error) -> Error {
    match error.to_string().split_once(" at path ") {
        Some((cause, _)) => Error::new(error.kind(), cause),
        None => error,
    }
}

/// Check before rendering that `path` can be written. An existing file stays unchanged.
///
/// # Errors
/// The reason why it cannot be written, without the file's name.
pub fn check_writable(path: &Path) -> Result<()> {
    let _whole = WRITING.read().unwrap_or_else(PoisonError::into_inner);
    refuse_special(path)?;
    temporary(&target(path)?).map(drop)
}

/// Whether two names refer to the same file, also through links. The file need not exist.
pub fn is_same(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let path = target(path).ok()?;
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
        path.canonicalize().ok().or_else(|| Some(folder.join(path.file_name()?)))
    };
    a == b || place(a).is_some_and(|a| Some(a) == place(b))
}

/// Refuse what no regular file can replace: a folder, a device, a pipe.
///
/// # Errors
/// A message that says what it is.
pub fn refuse_special(path: &Path) -> Result<()> {
    match std::fs::metadata(path) {
        Ok(there) if there.is_dir() => Err(Error::new(ErrorKind::IsADirectory, "it is a folder")),
        Ok(there) if !there.is_file() => {
            Err(Error::new(ErrorKind::InvalidInput, "it is a device or a pipe, not a regular file"))
        }
        _ => Ok(()),
    }
}

/// Largest number of symbolic links that are followed; a longer chain is assumed to be a circle, as operating systems
/// do.
const MAX_LINKS: usize = 40;

/// The target of a symbolic link, which need not exist; for other names, the name itself.
fn target(path: &Path) -> Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        if !std::fs::symlink_metadata(&path).is_ok_and(|there| there.is_symlink()) {
            return Ok(path);
        }
        let to = std::fs::read_link(&path)?;
        path = path.parent().unwrap_or(Path::new("")).join(to);
    }
    Err(Error::other("its symbolic links form a circle"))
}

/// Ending of temporary names.
const PART: &str = ".part";
/// Number of random letters and digits in temporary names: processes on other machines may write to the same folder.
const RANDOM: usize = 10;
/// Age of a temporary file that nobody is writing any more.
const ABANDONED: Duration = Duration::from_secs(600);

/// The folder of a file, and the beginning of the temporary names beside it.
fn beside(path: &Path) -> Result<(&Path, OsString)> {
    let missing = || Error::new(ErrorKind::InvalidInput, "the name of a file is missing");
    let mut name = path.file_name().ok_or_else(missing)?.to_os_string();
    name.push(".");
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    Ok((folder.unwrap_or(Path::new(".")), name))
}

/// A temporary file in the folder of `path`. It is removed when it is dropped.
fn temporary(path: &Path) -> Result<NamedTempFile> {
    let (folder, start) = beside(path)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(&start).suffix(PART).rand_bytes(RANDOM);
    #[cfg(unix)]
    builder.permissions(rights(path));
    builder.tempfile_in(folder).map_err(without_name)
}

/// The rights of the file that is replaced, or those of any new file.
#[cfg(unix)]
fn rights(path: &Path) -> std::fs::Permissions {
    use std::os::unix::fs::PermissionsExt;
    let there = std::fs::metadata(path).map(|m| m.permissions().mode() & 0o777);
    PermissionsExt::from_mode(there.unwrap_or(0o666))
}

/// Remove temporary files of `path` that killed processes have left. If this fails, they stay.
fn remove_abandoned(path: &Path) {
    let Ok((folder, start)) = beside(path) else { return };
    let start = start.to_string_lossy();
    let is_abandoned = |entry: &DirEntry| {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let random = name.strip_prefix(&*start).and_then(|rest| rest.strip_suffix(PART));
        let is_random = |r: &str| r.len() == RANDOM && r.bytes().all(|b| b.is_ascii_alphanumeric());
        let age = entry.metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
        random.is_some_and(is_random) && age.is_some_and(|age| age > ABANDONED)
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(is_abandoned) {
        let _ = std::fs::remove_file(entry.path());
    }
}

#[cfg(test)]
mod tests;
