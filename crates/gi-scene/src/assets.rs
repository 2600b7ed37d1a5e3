//! Mesh and picture files that a scene names. All names are collected first; then the files are read in parallel, each
//! once.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use gi_core::geometry::Mesh;
use gi_core::texture::{Bitmap, Lookup, Wrap};
use rayon::prelude::*;

use crate::budget::Budget;
use crate::diagnostics::{Report, Span};
use crate::document::{Class, Document, Node, ObjectId};
use crate::files::{self, Found};
use crate::hash::Hash;
use crate::shapes::mesh_file::{self, MeshFile, Placement, ReadMesh};
use crate::shapes::smooth;
use crate::texels::BitmapFile;

/// Number of missing files that an error lists.
const MAX_MISSING: usize = 100;

/// The contents of these files, by the object that names them.
#[derive(Debug, Default)]
pub(crate) struct Assets {
    bitmap_of: HashMap<ObjectId, usize>,
    bitmaps: Vec<(BitmapFile, Option<Arc<Bitmap>>)>,
    meshes: HashMap<ObjectId, (MeshFile, bool, Mesh)>,
    /// Hash of all bytes that were read.
    pub(crate) hash: Hash,
}

/// A file that something in the scene names.
struct Wanted<K> {
    object: ObjectId,
    span: Span,
    key: K,
}

impl Assets {
    /// Find and read all mesh and picture files that a document names.
    pub(crate) fn load(doc: &Document, report: &Report) -> Assets {
        let mut missing = Vec::new();
        let (mut bitmaps, mut meshes) = (Vec::new(), Vec::new());
        for node in doc.nodes(report) {
            let is_bitmap = match node.class() {
                Class::Texture => node.plugin() == "bitmap",
                Class::Emitter => node.plugin() == "envmap",
                _ => false,
            };
            let is_mesh = node.class() == Class::Shape && MeshFile::KINDS.contains(&node.plugin());
            if !is_bitmap && !is_mesh {
                continue;
            }
            let Some(path) = locate(node, &mut missing) else { continue };
            let (object, span) = (node.id, node.span_of("filename"));
            if is_mesh {
                meshes.push(Wanted { object, span, key: MeshFile::of(node, path) });
            } else if node.class() == Class::Emitter {
                let (wrap, lookup) = (Wrap::Repeat, Lookup::Bilinear);
                let raw = node.float_opt("gamma") == Some(1.0);
                let key = BitmapFile { path, raw, wrap, lookup };
                bitmaps.push(Wanted { object, span, key });
            } else {
                bitmaps.push(Wanted { object, span, key: BitmapFile::of(node, path) });
            }
        }
        report_missing(report, &missing);
        let mut assets = Assets::default();
        assets.read_bitmaps(bitmaps, report);
        assets.read_meshes(meshes, doc, report);
        assets
    }

    fn read_bitmaps(&mut self, wanted: Vec<Wanted<BitmapFile>>, report: &Report) {
        let (keys, index) = unique(&wanted);
        keys.iter().for_each(|key| report.reads(&key.path));
        let budget = &report.budget;
        let read: Vec<_> =
            keys.par_iter().map(|key| (files::hash_file(&key.path), key.read(budget))).collect();
        let first = first_of(&index, keys.len());
        for (i, (key, (hash, bitmap))) in keys.into_iter().zip(read).enumerate() {
            self.hash.word(hash.unwrap_or(0));
            let bitmap = note_failure(bitmap, &key.path, wanted[first[i]].span, report);
            self.bitmaps.push((key, bitmap.map(Arc::new)));
        }
        self.bitmap_of = wanted.iter().zip(index).map(|(w, i)| (w.object, i)).collect();
    }

    fn read_meshes(&mut self, wanted: Vec<Wanted<MeshFile>>, doc: &Document, report: &Report) {
        let (keys, index) = unique(&wanted);
        keys.iter().for_each(|key| report.reads(&key.path));
        let read = read_files(&keys, &report.budget);
        let first = first_of(&index, keys.len());
        let mut raw = Vec::new();
        for (i, (key, result)) in keys.iter().zip(read).enumerate() {
            let span = wanted[first[i]].span;
            let read = note_failure(result, &key.path, span, report);
            self.hash.word(read.as_ref().map_or(0, |r| r.1));
            if let Some(note) = read.as_ref().and_then(|(mesh, _)| mesh.note.as_ref()) {
                report.warn(span, note);
            }
            raw.push(read.map(|(read, _)| (read.mesh, read.portable)));
        }
        let copies = copies(raw, wanted, index, report);
        let place = |object| Placement::of(Node { doc, report, id: object });
        let jobs: Vec<_> = copies.into_iter().map(|copy| (place(copy.want.object), copy)).collect();
        let done: Vec<_> = jobs
            .into_par_iter()
            .map(|(place, Copy { want, portable, mut mesh })| {
                let replaced = place.apply(&mut mesh);
                (want.span, replaced, (want.object, (want.key, portable, mesh)))
            })
            .collect();
        for (span, replaced, (_, (file, ..))) in
            done.iter().filter(|(_, replaced, _)| *replaced > 0)
        {
            let path = file.path.display().to_string();
            report.warn(*span, smooth::bad_normals(*replaced, &path));
        }
        self.meshes = done.into_iter().map(|(.., mesh)| mesh).collect();
    }

    /// The picture that an object names, or `None` if it could not be read. (The error is reported already.)
    pub(crate) fn bitmap(&self, object: ObjectId) -> Option<Arc<Bitmap>> {
        self.bitmaps[*self.bitmap_of.get(&object)?].1.clone()
    }

    /// The file of that picture.
    pub(crate) fn bitmap_file(&self, object: ObjectId) -> Option<&BitmapFile> {
        Some(&self.bitmaps[*self.bitmap_of.get(&object)?].0)
    }

    /// The mesh that a shape names, in world space, and whether Mitsuba 3 reads its file too.
    /// Each mesh can be taken once.
    pub(crate) fn take_mesh(&mut self, object: ObjectId) -> Option<(MeshFile, bool, Mesh)> {
        self.meshes.remove(&object)
    }
}

/// Read the meshes of all keys, with the hash of their files. Each file is read once, even if it contains many meshes.
fn read_files(keys: &[MeshFile], budget: &Budget) -> Vec<Result<(ReadMesh, u64), String>> {
    let mut of_path: HashMap<&PathBuf, Vec<usize>> = HashMap::new();
    keys.iter().enumerate().for_each(|(i, key)| of_path.entry(&key.path).or_default().push(i));
    let read = of_path.into_par_iter().flat_map(|(path, wanted)| {
        let mut claim = budget.claim(path.display());
        let file = files::read_bytes(path, &mut claim).map(|bytes| (hash_of(&bytes), bytes));
        let parse = |i: usize| {
            let (hash, bytes) = file.as_ref().map_err(String::clone)?;
            Ok((keys[i].parse(bytes, budget.claim(path.display()))?, *hash))
        };
        wanted.into_par_iter().map(|i| (i, parse(i))).collect::<Vec<_>>()
    });
    let mut read: Vec<_> = read.collect();
    read.sort_by_key(|(i, _)| *i);
    read.into_iter().map(|(_, mesh)| mesh).collect()
}

/// The mesh of one shape.
struct Copy {
    want: Wanted<MeshFile>,
    portable: bool,
    mesh: Mesh,
}

/// A copy of the mesh for each shape that uses it, because each moves its own into place. The last shape that uses a
/// file takes the original.
fn copies(
    mut raw: Vec<Option<(Mesh, bool)>>,
    wanted: Vec<Wanted<MeshFile>>,
    index: Vec<usize>,
    report: &Report,
) -> Vec<Copy> {
    let (mut last, mut uses) = (vec![0; raw.len()], vec![0u64; raw.len()]);
    for (w, &i) in index.iter().enumerate() {
        last[i] = w;
        uses[i] += 1;
    }
    // Nothing is copied before all copies are allowed.
    for (i, mesh) in raw.iter_mut().enumerate() {
        let Some((of_it, _)) = mesh else { continue };
        let Wanted { key, span, .. } = &wanted[last[i]];
        let claim = report.budget.claim(key.path.display());
        if let Err(why) = claim.keep((uses[i] - 1) * mesh_file::bytes(of_it)) {
            let (path, n) = (key.path.display(), uses[i]);
            report.error(*span, format!("{n} shapes use the mesh `{path}`: {why}"), "");
            *mesh = None;
        }
    }
    let mut copies = Vec::new();
    for (w, (want, i)) in wanted.into_iter().zip(index).enumerate() {
        let mesh = if last[i] == w { raw[i].take() } else { raw[i].clone() };
        copies.extend(mesh.map(|(mesh, portable)| Copy { want, portable, mesh }));
    }
    copies
}

/// The distinct keys in order of first appearance, and for each entry of `wanted` the index of its key.
fn unique<K: Clone + Eq + std::hash::Hash>(wanted: &[Wanted<K>]) -> (Vec<K>, Vec<usize>) {
    let mut keys: Vec<K> = Vec::new();
    let mut known: HashMap<&K, usize> = HashMap::new();
    let index = wanted.iter().map(|w| {
        *known.entry(&w.key).or_insert_with(|| {
            keys.push(w.key.clone());
            keys.len() - 1
        })
    });
    let index = index.collect();
    (keys, index)
}

/// For each of `count` keys, the first entry that has it.
fn first_of(index: &[usize], count: usize) -> Vec<usize> {
    let mut first = vec![0; count];
    index.iter().enumerate().rev().for_each(|(wish, &key)| first[key] = wish);
    first
}

fn hash_of(bytes: &[u8]) -> u64 {
    let mut hash = Hash::default();
    hash.bytes(bytes);
    hash.value()
}

fn note_failure<T>(
    result: Result<T, String>,
    path: &std::path::Path,
    span: Span,
    report: &Report,
) -> Option<T> {
    result
        .map_err(|why| report.error(span, format!("cannot read `{}`: {why}", path.display()), ""))
        .ok()
}

fn locate(node: Node<'_>, missing: &mut Vec<(Span, String)>) -> Option<PathBuf> {
    let Some(name) = node.text("filename") else {
        if !node.has("filename") {
            node.error(format!("`{}` without a `filename`", node.plugin()), "");
        }
        return None;
    };
    match node.doc.folders.find(name, &node.object().folder, &node.doc.search) {
        Found::Exact(path) => Some(path),
        Found::OtherCase(path) => {
            let message = format!("`{name}` is read as `{}`", path.display());
            node.report.warn(node.span_of("filename"), message);
            Some(path)
        }
        Found::No => {
            missing.push((node.span_of("filename"), name.to_owned()));
            None
        }
    }
}

/// One error for all files that are missing.
fn report_missing(report: &Report, missing: &[(Span, String)]) {
    match missing {
        [] => {}
        [(span, name)] => report.error(*span, format!("cannot find `{name}`"), ""),
        [(first, _), ..] => {
            let mut list: Vec<String> = missing
                .iter()
                .take(MAX_MISSING)
                .map(|(span, name)| format!("{}: {name}", report.place(*span)))
                .collect();
            if missing.len() > MAX_MISSING {
                list.push(format!("and {} more", missing.len() - MAX_MISSING));
            }
            let message = format!("cannot find {} files", missing.len());
            report.error_help(*first, message, "the first one", Some(list.join("\n")));
        }
    }
}
