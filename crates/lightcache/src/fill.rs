//! The order in which a prepass fills a cache: over the picture from coarse to fine, in rounds. A round finds the
//! places that need records while the cache is frozen, then computes these records, then inserts them in order. Rounds
//! do not depend on the number of threads, and so neither does the cache.

use rayon::prelude::*;

/// Number of points in the first round. Each round has twice as many as the round before, up to [`LAST`].
const FIRST: usize = 16;
/// Number of points in the largest rounds. In large rounds, nearby points get unnecessary records; small rounds leave
/// threads idle.
const LAST: usize = 512;

/// Go through `points` points in rounds: `find` returns the places without a record at a point, and `fill` adds records
/// for all places of a round.
pub fn in_rounds<C: Sync, W: Send>(
    cache: &mut C,
    points: usize,
    find: impl Fn(&C, usize) -> Vec<W> + Sync,
    mut fill: impl FnMut(&mut C, Vec<W>),
) {
    let (mut from, mut round) = (0, FIRST);
    while from < points {
        let to = (from + round).min(points);
        let frozen = &*cache;
        let found: Vec<W> =
            (from..to).into_par_iter().with_min_len(8).flat_map_iter(|k| find(frozen, k)).collect();
        if !found.is_empty() {
            fill(cache, found);
        }
        (from, round) = (to, (2 * round).min(LAST));
    }
}

/// The pixels of a picture from coarse to fine. Consecutive pixels lie far apart, and every prefix of the order covers
/// the picture evenly.
pub fn coarse_to_fine([w, h]: [usize; 2]) -> Vec<[u32; 2]> {
    let bits = usize::BITS - (w.max(h).max(2) - 1).leading_zeros();
    // From its lowest bit on, the index of a pixel consists of alternating bits of x and y, highest bits first.
    let pixel = |i: usize| {
        let coordinate = |shift: usize| {
            (0..bits).fold(0, |c, b| c | ((i >> (2 * b as usize + shift)) & 1) << (bits - 1 - b))
        };
        [coordinate(0) as u32, coordinate(1) as u32]
    };
    (0..1usize << (2 * bits))
        .map(pixel)
        .filter(|&[x, y]| (x as usize) < w && (y as usize) < h)
        .collect()
}

/// The numbers below `n` from coarse to fine, like [`coarse_to_fine`] in one dimension.
pub fn scattered(n: usize) -> Vec<u32> {
    let bits = usize::BITS - n.max(2).leading_zeros();
    let number = |i: usize| (i.reverse_bits() >> (usize::BITS - bits)) as u32;
    (0..1usize << bits).map(number).filter(|&k| (k as usize) < n).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_comes_once_and_every_prefix_is_spread_over_the_picture() {
        let order = coarse_to_fine([48, 32]);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!((order.len(), sorted.len()), (48 * 32, 48 * 32));
        // The first 24 pixels of the 64 x 64 grid that covers the picture; those inside the picture are at least 8
        // apart.
        let first = &order[..12];
        for (i, a) in first.iter().enumerate() {
            for b in &first[..i] {
                let d = a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1]));
                assert!(d >= 8, "{a:?} and {b:?}");
            }
        }
        let mut numbers = scattered(100);
        assert!(numbers[0].abs_diff(numbers[1]) > 30);
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..100));
    }

    #[test]
    fn rounds_see_the_records_of_earlier_rounds_and_come_in_order() {
        let mut cache: Vec<usize> = Vec::new();
        in_rounds(
            &mut cache,
            1000,
            |cache, k| if cache.contains(&(k % 50)) { vec![] } else { vec![k % 50] },
            |cache, found| cache.extend(found),
        );
        // The first two rounds add 16 and 32 numbers. The third adds the two missing ones, and repeats some numbers of
        // its own round.
        assert_eq!(cache[..50], (0..50).collect::<Vec<_>>());
        assert!(cache.len() <= 50 + LAST);
    }
}
