//! A hash of everything that a scene was read from.

/// A 64-bit hash that depends on the order of its input. Not cryptographic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Hash(0x9e37_79b9_7f4a_7c15)
    }
}

impl Hash {
    /// Add some bytes and their number.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.end(bytes, bytes.len());
    }

    /// Add the first bytes of several pieces, a multiple of eight.
    pub(crate) fn words(&mut self, bytes: &[u8]) {
        debug_assert!(bytes.len().is_multiple_of(8));
        let words = bytes.chunks_exact(8);
        words.for_each(|w| self.word(u64::from_le_bytes(w.try_into().expect("eight bytes"))));
    }

    /// Add the last piece of some bytes, and their number: the hash is that of all pieces together.
    pub(crate) fn end(&mut self, bytes: &[u8], length: usize) {
        let (words, last) = bytes.split_at(bytes.len() / 8 * 8);
        self.words(words);
        let mut rest = [0; 8];
        rest[..last.len()].copy_from_slice(last);
        self.word(u64::from_le_bytes(rest));
        self.word(length as u64);
    }

    /// Add one number.
    pub(crate) fn word(&mut self, w: u64) {
        // The finaliser of splitmix64, applied to the running state.
        let mut z = (self.0 ^ w).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = z ^ (z >> 32);
    }

    /// The hash.
    pub(crate) fn value(self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_order_and_lengths_change_the_hash() {
        let of = |parts: &[&[u8]]| {
            let mut h = Hash::default();
            parts.iter().for_each(|p| h.bytes(p));
            h.value()
        };
        assert_eq!(of(&[b"abc"]), of(&[b"abc"]));
        let all =
            [of(&[b"abc"]), of(&[b"abd"]), of(&[b"abc\0"]), of(&[b"ab", b"c"]), of(&[b"", b"abc"])];
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| a != b));
        }
    }
}
