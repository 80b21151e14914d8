//! Short text of fixed capacity.

use crate::validate::Invalid;
use crate::wire::{Wire, hash_start, hash_u64};

/// The end of a text that was cut.
// Visible: a reader must see that a text is not complete.
pub const CUT: char = '…';

/// UTF-8 text of at most `N` bytes; the rest is zeros.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Text<const N: usize> {
    bytes: [u8; N],
}

// SAFETY: an array of bytes.
unsafe impl<const N: usize> Wire for Text<N> {
    const SCHEMA: u64 = hash_u64(hash_start("text"), N as u64);

    fn element() -> (String, usize) {
        (format!("Text{N}"), 1)
    }
}

impl<const N: usize> Text<N> {
    /// No text.
    pub const EMPTY: Self = Self { bytes: [0; N] };

    /// `text`, cut as by [`Self::format`].
    pub fn new(text: &str) -> Self {
        Self::format(format_args!("{text}"))
    }

    /// The output of `arguments`. A text that is too long is cut at a character and ends with
    /// [`CUT`]. Allocates nothing.
    pub fn format(arguments: core::fmt::Arguments<'_>) -> Self {
        let mut cut = CutOff {
            bytes: [0; N],
            used: 0,
        };
        // The writer refuses text that does not fit; the part that fits is kept and marked.
        if core::fmt::write(&mut cut, arguments).is_err() {
            cut.mark();
        }
        Self { bytes: cut.bytes }
    }

    /// The text; empty where the bytes are not UTF-8.
    pub fn as_str(&self) -> &str {
        // Ends at the first zero, so that remains of a longer text are not shown.
        let end = self.bytes.iter().position(|b| *b == 0).unwrap_or(N);
        core::str::from_utf8(&self.bytes[..end]).unwrap_or("")
    }

    /// Whether there is no text.
    pub fn is_empty(&self) -> bool {
        self.bytes.first().is_none_or(|b| *b == 0)
    }

    // The bytes come from shared memory: any of them can be damaged.
    pub(crate) fn check(&self, field: &'static str) -> Result<(), Invalid> {
        let end = self.bytes.iter().position(|b| *b == 0).unwrap_or(N);
        match core::str::from_utf8(&self.bytes[..end]) {
            Ok(_) => Ok(()),
            Err(error) => Err(Invalid {
                field,
                index: error.valid_up_to(),
                value: f64::NAN,
                allowed: "UTF-8 text",
            }),
        }
    }
}

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl<const N: usize> core::fmt::Debug for Text<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl<const N: usize> core::fmt::Display for Text<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.as_str())
    }
}

impl<const N: usize> From<&str> for Text<N> {
    fn from(text: &str) -> Self {
        Self::new(text)
    }
}

/// The first characters of the text written.
struct CutOff<const N: usize> {
    bytes: [u8; N],
    used: usize,
}

impl<const N: usize> CutOff<N> {
    /// Replaces the last characters by [`CUT`]; a capacity below its three bytes has no mark.
    fn mark(&mut self) {
        let mut mark = [0; 4];
        let mark = CUT.encode_utf8(&mut mark).as_bytes();
        let Some(mut end) = N.checked_sub(mark.len()).map(|end| end.min(self.used)) else {
            return;
        };
        // A byte that continues a character is not a place to cut.
        while end > 0 && self.bytes[end] & 0xC0 == 0x80 {
            end -= 1;
        }
        // The rest is zeroed, as the text ends at the first zero.
        self.bytes[end..].fill(0);
        self.bytes[end..][..mark.len()].copy_from_slice(mark);
    }
}

impl<const N: usize> core::fmt::Write for CutOff<N> {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        let mut end = text.len().min(N - self.used);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        self.bytes[self.used..][..end].copy_from_slice(&text.as_bytes()[..end]);
        self.used += end;
        if end == text.len() {
            Ok(())
        } else {
            Err(core::fmt::Error)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Text;

    #[test]
    fn a_text_that_is_too_long_is_cut_at_a_character_and_says_so() {
        assert_eq!(Text::<6>::new("aßßß").as_str(), "aß…");
        assert_eq!(Text::<7>::new("aßßß").as_str(), "aßßß");
        assert_eq!(Text::<4>::new("LIFTED").as_str(), "L…");
        assert_eq!(Text::<2>::new("LIFT").as_str(), "LI");
        assert_eq!(Text::<8>::new("LIFT").as_str(), "LIFT");
        assert_eq!(Text::<4>::new("LIFT").as_str(), "LIFT");
        assert!(Text::<8>::new("").is_empty());
        let parts = Text::<8>::format(format_args!("{} {}", "number", 1234));
        assert_eq!(parts.as_str(), "numbe…");
    }
}
