//! Damages files: bytes, and what text consists of: numbers, words and lines.

use std::ops::Range;

/// Random numbers (splitmix64).
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`; 0 if `n` is 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

/// Numbers at the limits of what can be read.
const EXTREMES: [&str; 18] = [
    "0",
    "-0",
    "-1",
    "1e-45",
    "1e-30",
    "1e15",
    "-1e15",
    "1e16",
    "3.4e38",
    "1e39",
    "1e400",
    "nan",
    "inf",
    "2147483648",
    "-2147483649",
    "18446744073709551616",
    "0.30000001192092896",
    "x",
];

/// Words that mean something, or that break something.
const WORDS: [&str; 16] = [
    "", "'", "\"", "<", ">", "/>", "&", "$", "$a", "<!--", "-->", "\\", "#", "/", "\u{feff}",
    "\u{0}",
];

pub(crate) struct Damage<'a> {
    pub(crate) rng: &'a mut Rng,
    pub(crate) files: &'a [Vec<u8>],
}

impl Damage<'_> {
    /// A damaged copy of one of the files; now and then an undamaged one.
    pub(crate) fn copy(&mut self) -> Vec<u8> {
        let mut bytes = self.rng.pick(self.files).clone();
        for _ in 0..self.rng.below(5) {
            self.once(&mut bytes);
        }
        bytes
    }

    /// One change.
    pub(crate) fn once(&mut self, bytes: &mut Vec<u8>) {
        match self.rng.below(10) {
            0 => bytes.truncate(self.rng.below(bytes.len() + 1)),
            1 => self.change_byte(bytes),
            2 => self.change_word(bytes),
            3..=5 => self.change_number(bytes),
            6 => self.swap_words(bytes),
            7 => self.repeat_line(bytes),
            8 => self.splice(bytes),
            _ => {
                let line = self.piece(bytes, |b| b == b'\n');
                bytes.drain(line);
            }
        }
    }

    /// The piece around a random byte, between bytes that separate.
    fn piece(&mut self, bytes: &[u8], separates: impl Fn(u8) -> bool) -> Range<usize> {
        let at = self.rng.below(bytes.len());
        let start = bytes[..at].iter().rposition(|b| separates(*b)).map_or(0, |i| i + 1);
        let end = bytes[at..].iter().position(|b| separates(*b)).map_or(bytes.len(), |i| at + i);
        start..end.max(start)
    }

    fn word(&mut self, bytes: &[u8]) -> Range<usize> {
        self.piece(bytes, |b| b.is_ascii_whitespace() || b"'\"=<>/,:".contains(&b))
    }

    fn change_byte(&mut self, bytes: &mut [u8]) {
        if bytes.is_empty() {
            return;
        }
        let at = self.rng.below(bytes.len());
        bytes[at] = match self.rng.below(3) {
            0 => bytes[at] ^ (1 << self.rng.below(8)),
            1 => *self.rng.pick(&[0, 0x7f, 0x80, 0xff]),
            _ => self.rng.below(256) as u8,
        };
    }

    fn change_word(&mut self, bytes: &mut Vec<u8>) {
        let word = self.word(bytes);
        let new = *self.rng.pick(&WORDS);
        bytes.splice(word, new.bytes());
    }

    /// Replace a number of a text, or four bytes of anything else.
    fn change_number(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..20 {
            let word = self.word(bytes);
            if bytes[word.clone()].iter().any(u8::is_ascii_digit) && bytes[word.clone()].is_ascii()
            {
                let new = *self.rng.pick(&EXTREMES);
                bytes.splice(word, new.bytes());
                return;
            }
        }
        if bytes.len() >= 4 {
            let at = self.rng.below(bytes.len() - 3);
            let new =
                *self.rng.pick(&[0, 1, 0x7fff_ffff, u32::MAX, 0x7fc0_0000, 0x7f80_0000, 1 << 26]);
            bytes[at..at + 4].copy_from_slice(&new.to_le_bytes());
        }
    }

    fn swap_words(&mut self, bytes: &mut Vec<u8>) {
        let (a, b) = (self.word(bytes), self.word(bytes));
        let (a, b) = if a.start <= b.start { (a, b) } else { (b, a) };
        if a.end > b.start {
            return;
        }
        let (first, second) = (bytes[a.clone()].to_vec(), bytes[b.clone()].to_vec());
        bytes.splice(b, first);
        bytes.splice(a, second);
    }

    fn repeat_line(&mut self, bytes: &mut Vec<u8>) {
        let line = self.piece(bytes, |b| b == b'\n');
        let times = *self.rng.pick(&[1, 2, 100]);
        let end = line.end;
        let mut copies = b"\n".to_vec();
        copies.extend_from_slice(&bytes[line]);
        if copies.len() * times < 1 << 16 {
            bytes.splice(end..end, copies.repeat(times));
        }
    }

    /// The start of this file and the end of another.
    fn splice(&mut self, bytes: &mut Vec<u8>) {
        let other = self.rng.pick(self.files).clone();
        bytes.truncate(self.rng.below(bytes.len() + 1));
        bytes.extend_from_slice(&other[self.rng.below(other.len() + 1)..]);
    }
}
