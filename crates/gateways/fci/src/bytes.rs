//! Little-endian numbers in packed messages.

/// Reads numbers from the front of a message.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.take::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// `N` numbers in a row.
    pub(crate) fn f64s<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut all = [0.0; N];
        for slot in &mut all {
            *slot = self.f64()?;
        }
        Some(all)
    }
}

/// Writes numbers one after the other; what does not fit is left out.
pub(crate) struct Writer<'a> {
    out: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(out: &'a mut [u8]) -> Self {
        Self { out, at: 0 }
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        let end = self.at + bytes.len();
        if let Some(slot) = self.out.get_mut(self.at..end) {
            slot.copy_from_slice(bytes);
        }
        self.at = end;
    }

    /// Each as a number of 32 bits.
    pub(crate) fn f32s(&mut self, values: &[f64]) {
        for value in values {
            self.bytes(&single(*value).to_le_bytes());
        }
    }

    pub(crate) fn zeros(&mut self, count: usize) {
        for _ in 0..count {
            self.f32s(&[0.0]);
        }
    }

    /// Bytes asked for so far.
    pub(crate) fn len(&self) -> usize {
        self.at
    }
}

/// The nearest number of 32 bits.
#[expect(
    clippy::cast_possible_truncation,
    reason = "numbers of a state have 32 bits"
)]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
