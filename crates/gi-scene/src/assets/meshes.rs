//! The meshes of all shapes. Each file is read once and each of its meshes decoded once. Shapes that use the same mesh
//! share everything that does not depend on their place.

use std::collections::HashMap;
use std::path::PathBuf;

use rayon::prelude::*;

use super::{Assets, Wanted, first_of, note_failure, unique};
use crate::budget::Budget;
use crate::diagnostics::Report;
use crate::document::{Document, Node, ObjectId};
use crate::files;
use crate::hash::Hash;
use crate::local;
use crate::shapes::mesh_file::{self, MeshFile, MeshKind, Placement, ReadMesh};
use crate::shapes::smooth;

impl Assets {
    /// Read the meshes of all shapes, and move each shape's to its place.
    pub(super) fn read_meshes(
        &mut self,
        wanted: Vec<Wanted<MeshFile>>,
        doc: &Document,
        report: &Report,
    ) {
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
            raw.push(read.map(|(read, _)| read));
        }
        let extents: Vec<_> =
            raw.iter().map(|read| read.as_ref().and_then(mesh_file::extent)).collect();
        let of_object: HashMap<ObjectId, usize> =
            wanted.iter().zip(&index).map(|(w, i)| (w.object, *i)).collect();
        let inline = doc.inline_meshes.take();
        let place = local::place(doc, report, |id| match inline.get(&id) {
            Some(read) => mesh_file::extent(read),
            None => extents[*of_object.get(&id)?],
        });
        doc.local.replace(place);
        let place = |object| Placement::of(Node { doc, report, id: object });
        let inline = inline.into_iter().map(|(object, read)| {
            let span = Node { doc, report, id: object }.span();
            let key = MeshFile { path: files::folder_of(&doc.search[0]), kind: MeshKind::Inline };
            Copy { want: Wanted { object, span, key }, read }
        });
        let mut inline: Vec<Copy> = inline.collect();
        inline.sort_by_key(|copy| copy.want.object);
        let jobs: Vec<_> = copies(raw, wanted, index, report)
            .into_iter()
            .chain(inline)
            .map(|copy| (place(copy.want.object), copy))
            .collect();
        self.take_meshes(jobs, report);
    }

    /// Move each mesh to its place, in parallel, and keep them in the order of the jobs.
    fn take_meshes(&mut self, jobs: Vec<(Placement, Copy)>, report: &Report) {
        let budget = &report.budget;
        let done: Vec<_> = jobs
            .into_par_iter()
            .map(|(place, mut copy)| {
                let claim = budget.claim(copy.want.key.path.display());
                let rounding = place.scale() * copy.read.rounding;
                (place.apply(&mut copy.read, claim), rounding, copy)
            })
            .collect();
        for (replaced, rounding, Copy { want, read }) in done {
            self.rounding = self.rounding.max(rounding);
            let Some(replaced) = note_failure(replaced, &want.key.path, want.span, report) else {
                continue;
            };
            if replaced > 0 {
                let path = want.key.path.display().to_string();
                report.warn(want.span, smooth::bad_normals(replaced, &path));
            }
            self.meshes.insert(want.object, (want.key, read.portable, read.mesh));
        }
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
    read: ReadMesh,
}

/// The mesh of each shape. The vertices are the shape's own, because it moves them to its place; the rest is shared. The
/// last shape that uses a mesh takes the original.
fn copies(
    mut raw: Vec<Option<ReadMesh>>,
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
        let Some(read) = mesh else { continue };
        let Wanted { key, span, .. } = &wanted[last[i]];
        let claim = report.budget.claim(key.path.display());
        if let Err(why) = claim.keep((uses[i] - 1) * mesh_file::own_bytes(&read.mesh)) {
            let (path, n) = (key.path.display(), uses[i]);
            report.error(*span, format!("{n} shapes use the mesh `{path}`: {why}"), "");
            *mesh = None;
        }
    }
    let mut copies = Vec::new();
    for (w, (want, i)) in wanted.into_iter().zip(index).enumerate() {
        let read = if last[i] == w { raw[i].take() } else { raw[i].clone() };
        copies.extend(read.map(|read| Copy { want, read }));
    }
    copies
}

fn hash_of(bytes: &[u8]) -> u64 {
    let mut hash = Hash::default();
    hash.bytes(bytes);
    hash.value()
}
