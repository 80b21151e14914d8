//! Lines and columns of byte offsets, from an index that is built once: a search from the
//! start of the text for each value takes quadratic time in a large file.

/// A place in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Location {
    /// Line, the first is 1.
    pub line: u32,
    /// Column in characters, the first is 1.
    pub column: u32,
}

impl Location {
    /// The start of a text.
    pub const START: Self = Self { line: 1, column: 1 };
}

/// Columns beyond so many bytes count bytes instead of characters: counting
/// takes quadratic time in a file with one line.
const MAX_COUNTED: usize = 4096;

/// The lines of one text.
pub(crate) struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        let newlines = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let starts = std::iter::once(0).chain(newlines.map(|(at, _)| at + 1));
        Self {
            text,
            starts: starts.collect(),
        }
    }

    /// The place of the byte at `offset`.
    pub(crate) fn place(&self, offset: usize) -> Location {
        // The number of line starts up to the offset is the line, counted from 1.
        let line = self.starts.partition_point(|start| *start <= offset);
        let start = self.starts.get(line.saturating_sub(1)).copied();
        let start = start.unwrap_or(0);
        let before = offset.saturating_sub(start);
        let counted = (before <= MAX_COUNTED)
            .then(|| self.text.get(start..offset))
            .flatten();
        let column = counted.map_or(before, |text| text.chars().count()) + 1;
        Location {
            line: u32::try_from(line).unwrap_or(u32::MAX),
            column: u32::try_from(column).unwrap_or(u32::MAX),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_in_any_order_have_their_line_and_their_column_in_characters() {
        let lines = Lines::new("a = 1\nü = 2\n");
        let places = [9, 0, 12, 6].map(|offset| {
            let place = lines.place(offset);
            (place.line, place.column)
        });
        assert_eq!(places, [(2, 3), (1, 1), (2, 6), (2, 1)]);
    }
}
