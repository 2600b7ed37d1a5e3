//! Files of meshes, pictures and volumes that a scene names. All names are collected first; then the files are read in parallel, each
//! once.

mod meshes;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use gi_core::geometry::Mesh;
use gi_core::texture::{Bitmap, Lookup, Wrap};
use rayon::prelude::*;

use crate::diagnostics::{Report, Span};
use crate::document::{Class, Document, Node, ObjectId};
use crate::files::{self, Found};
use crate::hash::Hash;
use crate::shapes::mesh_file::MeshFile;
use crate::texels::BitmapFile;
use crate::volumes::VolumeFile;

/// Number of missing files that an error lists.
const MAX_MISSING: usize = 100;

/// The contents of these files, by the object that names them.
#[derive(Debug, Default)]
pub(crate) struct Assets {
    bitmap_of: HashMap<ObjectId, usize>,
    bitmaps: Vec<(BitmapFile, Option<Arc<Bitmap>>)>,
    meshes: HashMap<ObjectId, (MeshFile, bool, Mesh)>,
    volumes: HashMap<ObjectId, Arc<VolumeFile>>,
    /// How much mesh files round positions, in world units.
    pub(crate) rounding: f32,
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
    /// Find and read all files of meshes, pictures and volumes that a document names.
    pub(crate) fn load(doc: &Document, report: &Report) -> Assets {
        let mut missing = Vec::new();
        let (mut bitmaps, mut meshes, mut volumes) = (Vec::new(), Vec::new(), Vec::new());
        for node in doc.nodes(report) {
            let is_bitmap = match node.class() {
                Class::Texture => node.plugin() == "bitmap",
                Class::Emitter => node.plugin() == "envmap",
                _ => false,
            };
            let is_mesh = node.class() == Class::Shape && MeshFile::KINDS.contains(&node.plugin());
            let distances = node.class() == Class::Shape && node.plugin() == "sdfgrid";
            let is_volume =
                distances || node.class() == Class::Volume && node.plugin() == "gridvolume";
            if !is_bitmap && !is_mesh && !is_volume {
                continue;
            }
            let Some(path) = locate(node, &mut missing) else { continue };
            let (object, span) = (node.id, node.span_of("filename"));
            if is_volume {
                volumes.push(Wanted { object, span, key: (path, distances) });
            } else if is_mesh {
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
        assets.read_volumes(volumes, report);
        assets
    }

    /// Read grids of values, which are signed if they are distances.
    fn read_volumes(&mut self, wanted: Vec<Wanted<(PathBuf, bool)>>, report: &Report) {
        let (keys, index) = unique(&wanted);
        let first = first_of(&index, keys.len());
        let mut read = Vec::new();
        for (i, (path, signed)) in keys.iter().enumerate() {
            report.reads(path);
            let result = VolumeFile::read(path, *signed, &report.budget);
            let volume = note_failure(result, path, wanted[first[i]].span, report);
            self.hash.word(volume.as_ref().map_or(0, |(_, hash)| *hash));
            read.push(volume.map(|(volume, _)| Arc::new(volume)));
        }
        let found =
            wanted.iter().zip(index).filter_map(|(w, i)| Some((w.object, read[i].clone()?)));
        self.volumes = found.collect();
    }

    /// The grid file that a volume names, or `None` if it could not be read. (The error is reported already.)
    pub(crate) fn volume(&self, object: ObjectId) -> Option<Arc<VolumeFile>> {
        self.volumes.get(&object).cloned()
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

    /// The picture that an object names, or `None` if it could not be read. (The error is reported already.)
    pub(crate) fn bitmap(&self, object: ObjectId) -> Option<Arc<Bitmap>> {
        self.bitmaps[*self.bitmap_of.get(&object)?].1.clone()
    }

    /// The file of that picture.
    pub(crate) fn bitmap_file(&self, object: ObjectId) -> Option<&BitmapFile> {
        Some(&self.bitmaps[*self.bitmap_of.get(&object)?].0)
    }

    /// The file of the mesh that a shape names, before the mesh is taken.
    pub(crate) fn mesh_path(&self, object: ObjectId) -> Option<PathBuf> {
        self.meshes.get(&object).map(|(file, ..)| file.path.clone())
    }

    /// The mesh that a shape names, in world space, and whether Mitsuba 3 reads its file too.
    /// Each mesh can be taken once.
    pub(crate) fn take_mesh(&mut self, object: ObjectId) -> Option<(MeshFile, bool, Mesh)> {
        self.meshes.remove(&object)
    }
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
