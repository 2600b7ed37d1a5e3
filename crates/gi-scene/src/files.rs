//! Finds and reads the files that a scene names.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use flate2::read::MultiGzDecoder;
use gi_core::files::open_regular;

use crate::budget::Claim;
use crate::hash::Hash;

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

/// The names in the folders where files were looked for. Each folder is listed once: many files in it may be written
/// in another case.
#[derive(Debug, Default)]
pub(crate) struct Folders {
    listed: RefCell<HashMap<PathBuf, Names>>,
}

/// The names in a folder, by what they are in lower case; of several, the first in alphabetical order.
type Names = HashMap<String, OsString>;

impl Folders {
    /// Look for `name` in `folder`, then in the other folders. Backslashes separate folders too.
    pub(crate) fn find(&self, name: &str, folder: &Path, others: &[PathBuf]) -> Found {
        let name = PathBuf::from(name.replace('\\', "/"));
        let folders = || std::iter::once(folder).chain(others.iter().map(PathBuf::as_path));
        for f in folders() {
            let path = f.join(&name);
            // What is neither a file nor a folder is found too: the error says more when it is read.
            if path.metadata().is_ok_and(|m| !m.is_dir()) {
                return Found::Exact(path);
            }
        }
        for f in folders() {
            if let Some(path) = self.find_other_case(&name, f) {
                return Found::OtherCase(path);
            }
        }
        Found::No
    }

    fn find_other_case(&self, name: &Path, folder: &Path) -> Option<PathBuf> {
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
            let mut listed = self.listed.borrow_mut();
            let names = listed.entry(at.clone()).or_insert_with(|| list(&at));
            at.push(names.get(&part.to_string_lossy().to_lowercase())?);
        }
        at.is_file().then_some(at)
    }
}

fn list(folder: &Path) -> Names {
    let mut names = Names::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let first = names.entry(name.to_string_lossy().to_lowercase()).or_insert(name.clone());
        if name < *first {
            *first = name;
        }
    }
    names
}

/// The text of a file without its byte order mark.
pub(crate) fn read_text(path: &Path, claim: &mut Claim<'_>) -> Result<String, String> {
    let bytes = read_limited(path, MAX_TEXT, claim)?;
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
pub(crate) fn read_bytes(path: &Path, claim: &mut Claim<'_>) -> Result<Vec<u8>, String> {
    read_limited(path, MAX_BYTES, claim)
}

fn read_limited(path: &Path, limit: u64, claim: &mut Claim<'_>) -> Result<Vec<u8>, String> {
    let file = open_regular(path)?;
    let length = file.metadata().map_err(|e| e.to_string())?.len();
    if length > limit {
        return Err(format!("it is longer than {limit} bytes"));
    }
    claim.set(length)?;
    let mut bytes = Vec::with_capacity(length as usize);
    // Not more than claimed, even if the file is growing.
    file.take(length).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    refuse_pointer(&bytes)?;
    match is_compressed(path) {
        true => decompressed(&bytes, limit, claim),
        false => Ok(bytes),
    }
}

/// Whether a file's name says that it is compressed by gzip, as pbrt accepts.
fn is_compressed(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"))
}

/// The contents of a file in gzip's format, of which the claim keeps count while they grow.
fn decompressed(bytes: &[u8], limit: u64, claim: &mut Claim<'_>) -> Result<Vec<u8>, String> {
    const PIECE: u64 = 1 << 16;
    let mut reader = MultiGzDecoder::new(bytes);
    let mut all = Vec::new();
    loop {
        let read = reader.by_ref().take(PIECE).read_to_end(&mut all).map_err(|e| e.to_string())?;
        if all.len() as u64 > limit {
            return Err(format!("it contains more than {limit} bytes"));
        }
        // A growing vector doubles.
        claim.at_least((bytes.len() + 2 * all.len()) as u64)?;
        if read == 0 {
            return Ok(all);
        }
    }
}

/// The hash of a file's bytes, read a piece at a time.
pub(crate) fn hash_file(path: &Path) -> Result<u64, String> {
    const PIECE: usize = 1 << 16; // a multiple of the hash's words
    let mut file = open_regular(path)?;
    let (mut hash, mut length, mut piece) = (Hash::default(), 0, Vec::with_capacity(PIECE));
    loop {
        piece.clear();
        let more = file.by_ref().take(PIECE as u64).read_to_end(&mut piece);
        more.map_err(|e| e.to_string())?;
        length += piece.len();
        if piece.len() < PIECE {
            hash.end(&piece, length);
            return Ok(hash.value());
        }
        hash.words(&piece);
    }
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
    if let Ok(file) = open_regular(path) {
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
        let folders = Folders::default();
        let find = |name: &str| folders.find(name, dir.path(), &[]);
        assert_eq!(find("Models/Mesh.OBJ"), Found::Exact(want.clone()));
        assert_eq!(find("models\\mesh.obj"), Found::OtherCase(want));
        assert_eq!(find("models/other.obj"), Found::No);
    }
}
