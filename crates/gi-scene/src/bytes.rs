//! Reading numbers from bytes without ever reading past their end.

/// The message for a file that ends too soon.
pub(crate) const TRUNCATED: &str = "it ends too soon";

/// A stretch of bytes, read from the front.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bytes<'a> {
    rest: &'a [u8],
    big_endian: bool,
}

macro_rules! numbers {
    ($($name:ident: $type:ty),*) => {$(
        /// The next number of this type.
        pub(crate) fn $name(&mut self) -> Result<$type, String> {
            const N: usize = size_of::<$type>();
            let b: [u8; N] = self.take(N)?.try_into().expect("as many bytes as asked for");
            Ok(if self.big_endian { <$type>::from_be_bytes(b) } else { <$type>::from_le_bytes(b) })
        }
    )*};
}

impl<'a> Bytes<'a> {
    /// Little-endian numbers.
    pub(crate) fn little(rest: &'a [u8]) -> Self {
        Bytes { rest, big_endian: false }
    }

    /// Numbers of either order.
    pub(crate) fn new(rest: &'a [u8], big_endian: bool) -> Self {
        Bytes { rest, big_endian }
    }

    /// How many bytes are left.
    pub(crate) fn len(&self) -> usize {
        self.rest.len()
    }

    /// The next `n` bytes.
    pub(crate) fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(n).ok_or(TRUNCATED)?;
        self.rest = rest;
        Ok(taken)
    }

    numbers!(
        u8: u8, i8: i8, u16: u16, i16: i16, u32: u32, i32: i32, u64: u64, f32: f32, f64: f64
    );
}
