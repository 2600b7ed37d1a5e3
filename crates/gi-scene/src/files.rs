//! Finds and reads the files that a scene names.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Largest text file of a scene: meshes and pictures are in files of their own.
const MAX_TEXT: u64 = 1 << 28;
/// Largest mesh file: a larger one would not fit into memory.
const MAX_BYTES: u64 = 1 << 34;

/// Result of a search.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// The file with exactly this name.
    Exact(PathBuf),
    /// A file whose name differs only in case: the scene comes from a system that ignores case.
    OtherCase(PathBuf),
    /// No file.
    No,
}

/// The folder of a file; `.` for a bare name.
pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Look for `name` in `folder`, then in the other folders. Backslashes separate folders too.
pub(crate) fn find(name: &str, folder: &Path, others: &[PathBuf]) -> Found {
    let name = PathBuf::from(name.replace('\\', "/"));
    let folders = || std::iter::once(folder).chain(others.iter().map(PathBuf::as_path));
    for f in folders() {
        let path = f.join(&name);
        if path.is_file() {
            return Found::Exact(path);
        }
    }
    for f in folders() {
        if let Some(path) = find_other_case(&name, f) {
            return Found::OtherCase(path);
        }
    }
    Found::No
}

fn find_other_case(name: &Path, folder: &Path) -> Option<PathBuf> {
    let mut at = folder.to_owned();
    for part in name.components() {
        let Component::Normal(part) = part else {
            at.push(part);
            continue;
        };
        if at.join(part).exists() {
            at.push(part);
            continue;
        }
        let wanted = part.to_string_lossy().to_lowercase();
        let mut near: Vec<_> = fs::read_dir(&at)
            .ok()?
            .flatten()
            .map(|e| e.file_name())
            .filter(|n| n.to_string_lossy().to_lowercase() == wanted)
            .collect();
        near.sort();
        at.push(near.first()?);
    }
    at.is_file().then_some(at)
}

/// The text of a file without its byte order mark.
pub(crate) fn read_text(path: &Path) -> Result<String, String> {
    let bytes = read_limited(path, MAX_TEXT)?;
    let text = match without_mark(&bytes) {
        Cow::Owned(bytes) => String::from_utf8(bytes),
        Cow::Borrowed(rest) if rest.len() == bytes.len() => String::from_utf8(bytes),
        Cow::Borrowed(rest) => String::from_utf8(rest.to_vec()),
    };
    text.map_err(|_| "it is not UTF-8 text".into())
}

/// The text's bytes without a byte order mark; UTF-16, recognised by its mark, becomes UTF-8.
pub(crate) fn without_mark(bytes: &[u8]) -> Cow<'_, [u8]> {
    let units = |read: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|b| read([b[0], b[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units).into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        [0xff, 0xfe, ..] => units(u16::from_le_bytes),
        [0xfe, 0xff, ..] => units(u16::from_be_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

/// The bytes of a file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    read_limited(path, MAX_BYTES)
}

fn read_limited(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| e.to_string())?;
    file.take(limit + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    if bytes.len() as u64 > limit {
        return Err(format!("it is longer than {limit} bytes"));
    }
    refuse_pointer(&bytes)?;
    Ok(bytes)
}

/// First bytes of a Git LFS pointer, which replaces a file that was not fetched.
const POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Refuse a Git LFS pointer.
fn refuse_pointer(bytes: &[u8]) -> Result<(), String> {
    if !bytes.starts_with(POINTER) {
        return Ok(());
    }
    Err("it is only a Git LFS pointer to the file; run `git lfs pull` in its repository".into())
}

/// The same check for a file that another library reads. An unreadable file passes: that library reports the error.
pub(crate) fn refuse_pointer_file(path: &Path) -> Result<(), String> {
    let mut head = Vec::new();
    if let Ok(file) = File::open(path) {
        let _ = file.take(POINTER.len() as u64).read_to_end(&mut head);
    }
    refuse_pointer(&head)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_in_the_wrong_case() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("Models")).unwrap();
        fs::write(dir.path().join("Models/Mesh.OBJ"), "").unwrap();
        let want = dir.path().join("Models/Mesh.OBJ");
        assert_eq!(find("Models/Mesh.OBJ", dir.path(), &[]), Found::Exact(want.clone()));
        assert_eq!(find("models\\mesh.obj", dir.path(), &[]), Found::OtherCase(want));
        assert_eq!(find("models/other.obj", dir.path(), &[]), Found::No);
    }
}
