//! Sorts points into buckets in parallel. The order does not depend on the number of threads.

use rayon::prelude::*;

use super::{Grid, Item};

/// Number of pieces that the buckets are divided into.
const PIECES: usize = 256;

impl<T: Copy + Default + Send + Sync> Grid<T> {
    /// Put the points into the order of their buckets. Each chunk distributes its points to pieces, which are ranges
    /// of buckets. Then each piece counts and places its own points.
    pub(super) fn sort(&mut self, chunks: &[Vec<Item<T>>]) {
        let buckets = self.layout.buckets();
        let width = buckets.div_ceil(PIECES);
        let dealt: Vec<Dealt> = chunks.par_iter().map(|chunk| self.deal(chunk, width)).collect();
        let mut pieces = self.pieces(&dealt, width);
        pieces.par_iter_mut().for_each(|piece| piece.place(chunks, &dealt));
        let n = self.values.len() as u32;
        *self.start.last_mut().expect("one entry more than buckets") = n;
    }

    /// Distribute the points of a chunk: sorted by piece, in order within a piece.
    fn deal(&self, chunk: &[Item<T>], width: usize) -> Dealt {
        let buckets: Vec<u32> =
            chunk.iter().map(|p| self.layout.bucket(self.cell_of(p.p)) as u32).collect();
        let mut ends = vec![0u32; PIECES + 1];
        buckets.iter().for_each(|&b| ends[b as usize / width + 1] += 1);
        (1..=PIECES).for_each(|k| ends[k] += ends[k - 1]);
        let mut next = ends.clone();
        let mut entries = vec![Entry::default(); chunk.len()];
        for (place, bucket) in buckets.into_iter().enumerate() {
            let at = &mut next[bucket as usize / width];
            entries[*at as usize] = Entry { bucket, place: place as u32 };
            *at += 1;
        }
        Dealt { entries, ends }
    }

    /// The pieces with their parts of the arrays.
    fn pieces(&mut self, dealt: &[Dealt], width: usize) -> Vec<Piece<'_, T>> {
        let [mut x, mut y, mut z] = self.columns.each_mut().map(Vec::as_mut_slice);
        let mut values = self.values.as_mut_slice();
        let mut first = 0;
        let buckets = self.start.len() - 1;
        let mut pieces = Vec::new();
        for (index, start) in self.start[..buckets].chunks_mut(width).enumerate() {
            let count = dealt.iter().map(|d| d.of_piece(index).len()).sum();
            let columns = [&mut x, &mut y, &mut z].map(|column| take(column, count));
            let values = take(&mut values, count);
            pieces.push(Piece { index, width, first, start, columns, values });
            first += count as u32;
        }
        pieces
    }
}

/// Cut the first `count` off a slice.
fn take<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, others) = std::mem::take(rest).split_at_mut(count);
    *rest = others;
    first
}

/// A point of a chunk and its bucket.
#[derive(Clone, Copy, Default)]
struct Entry {
    bucket: u32,
    place: u32,
}

/// A chunk, distributed to pieces.
struct Dealt {
    entries: Vec<Entry>,
    /// The start of each piece's entries, and the end of the last.
    ends: Vec<u32>,
}

impl Dealt {
    fn of_piece(&self, index: usize) -> &[Entry] {
        &self.entries[self.ends[index] as usize..self.ends[index + 1] as usize]
    }
}

/// A range of buckets, with its parts of the grid's arrays.
struct Piece<'a, T> {
    index: usize,
    /// Number of buckets per piece; the last piece may have fewer.
    width: usize,
    /// Index of the first point.
    first: u32,
    start: &'a mut [u32],
    columns: [&'a mut [f32]; 3],
    values: &'a mut [T],
}

impl<T: Copy> Piece<'_, T> {
    /// Count the points of each bucket, then place them, chunk by chunk.
    fn place(&mut self, chunks: &[Vec<Item<T>>], dealt: &[Dealt]) {
        let base = self.index * self.width;
        let mut next = vec![0u32; self.start.len() + 1];
        let entries = || dealt.iter().enumerate().map(|(chunk, d)| (chunk, d.of_piece(self.index)));
        entries().flat_map(|(_, e)| e).for_each(|e| next[e.bucket as usize - base + 1] += 1);
        (1..next.len()).for_each(|k| next[k] += next[k - 1]);
        for (start, offset) in self.start.iter_mut().zip(&next) {
            *start = self.first + offset;
        }
        for (chunk, entries) in entries() {
            for entry in entries {
                let point = &chunks[chunk][entry.place as usize];
                let at = &mut next[entry.bucket as usize - base];
                let place = *at as usize;
                *at += 1;
                for (column, v) in self.columns.iter_mut().zip(point.p.to_array()) {
                    column[place] = v;
                }
                self.values[place] = point.value;
            }
        }
    }
}
