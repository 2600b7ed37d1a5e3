//! Atomic writes: a killed run leaves the old file or the new one, never half of one.

use std::ffi::{OsStr, OsString};
use std::fs::DirEntry;
use std::io::{BufWriter, Error, ErrorKind, Result, Write};
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
    // A device might never end.
    if !path.metadata().map_err(|e| cannot(&e))?.is_file() {
        return Err(cannot(&"it is not a regular file"));
    }
    std::fs::read(path).map_err(|e| cannot(&e))
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
    fill(&mut out)?;
    let part = out.into_inner()?;
    part.as_file().sync_all()?;
    // Whatever fails before this removes the temporary file.
    part.persist(path)?;
    Ok(())
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
    // Rights as for any other file, and not only for the owner.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
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
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("the folder");
        let name = |e: Result<std::fs::DirEntry>| e.expect("an entry").file_name();
        entries.map(|e| name(e).into_string().expect("UTF-8")).collect()
    }

    #[test]
    fn a_write_that_fails_half_way_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write(&path, b"old").expect("written");
        let half = |out: &mut Out| {
            out.write_all(b"ne")?;
            out.flush()?;
            Err(Error::other("no more"))
        };
        let error = write_with(&path, half).expect_err("errors are passed on");
        assert_eq!(error.to_string(), "no more");
        assert_eq!(std::fs::read(&path).expect("a file"), b"old");
        assert_eq!(names(folder.path()), ["a.txt"]);
        write(&path, b"new").expect("written");
        assert_eq!(std::fs::read(&path).expect("a file"), b"new");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_killed_processes_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let old = std::time::SystemTime::now() - 2 * ABANDONED;
        let abandoned = "a.exr.0123456789.part";
        let others = [
            "a.exr.9876543210.part",
            "a.exr.012345678.part",
            "b.exr.0123456789.part",
            "a.exr.part",
        ];
        for name in [&[abandoned], &others[..]].concat() {
            let file = std::fs::File::create(at(name)).expect("a file");
            // The first of the others is being written.
            if name != others[0] {
                file.set_modified(old).expect("its time");
            }
        }
        write(&at("a.exr"), b"new").expect("written");
        let mut expected = [&["a.exr"], &others[..]].concat();
        let mut left = names(folder.path());
        expected.sort_unstable();
        left.sort();
        assert_eq!(left, expected);
    }

    #[test]
    fn a_check_changes_nothing_and_finds_what_a_write_would() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        write(&at("a.txt"), b"old").expect("written");
        std::fs::create_dir(at("b.txt")).expect("made");
        check_writable(&at("a.txt")).expect("it can be written anew");
        check_writable(&at("c.txt")).expect("it can be made");
        for refused in [at("b.txt"), at("no/such/d.txt"), PathBuf::new()] {
            assert!(check_writable(&refused).is_err(), "{refused:?} passed the check");
            assert!(write(&refused, b"new").is_err(), "{refused:?} was written");
        }
        assert_eq!(std::fs::read(at("a.txt")).expect("a file"), b"old");
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, ["a.txt", "b.txt"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_symbolic_link_is_written_through_even_if_its_target_does_not_exist() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, at(name)).expect("a link");
        link("b.txt", "a.txt");
        link("a.txt", "chain.txt");
        for text in [b"one", b"two"] {
            write(&at("chain.txt"), text).expect("written");
            assert_eq!(std::fs::read(at("b.txt")).expect("the target"), text);
        }
        assert!(
            at("a.txt").is_symlink() && at("chain.txt").is_symlink() && !at("b.txt").is_symlink()
        );
        assert!(is_same(&at("chain.txt"), &at("b.txt")));
        link("to.txt", "fro.txt");
        link("fro.txt", "to.txt");
        assert!(check_writable(&at("to.txt")).is_err() && write(&at("to.txt"), b"").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused_by_any_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("null.txt");
        std::os::unix::fs::symlink("/dev/null", &link).expect("a link");
        for path in [Path::new("/dev/null"), &link] {
            let error = check_writable(path).expect_err("a device");
            assert!(error.to_string().contains("device"), "{error}");
            assert!(write(path, b"new").is_err());
        }
    }

    #[test]
    fn files_of_points_are_known_by_their_names() {
        assert!(["a.ply", "a.csv", "b/a.CSV"].iter().all(|name| points_file(name).is_ok()));
        assert!(["a.txt", "csv", "a.csv.gz"].iter().all(|name| points_file(name).is_err()));
        let table = ["a.ply", "a.csv", "a.CSV"].map(|name| is_table(Path::new(name)));
        assert_eq!(table, [false, true, true]);
    }

    #[test]
    fn a_file_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("missing");
        for path in [folder.path(), &missing] {
            let message = read(path).expect_err("it cannot be read");
            assert!(message.contains(&path.display().to_string()), "{message}");
        }
    }

    #[test]
    fn different_names_of_the_same_file_are_recognised() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        write(&at("a.txt"), b"there").expect("written");
        for name in ["a.txt", "b.txt"] {
            assert!(is_same(&at(name), &at("./").join(name)), "{name}");
            assert!(!is_same(&at(name), &at("c.txt")), "{name}");
        }
    }
}
