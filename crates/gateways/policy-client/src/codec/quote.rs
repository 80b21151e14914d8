//! Values of a server in a message to a person.

use std::fmt::{self, Write as _};

use super::QUOTED;

/// Bytes of a text that are kept: a character has at most four.
const TAIL_BYTES: usize = 4 * QUOTED;

/// The end of a text of any length, as it is written.
// The text of binary data is five times as long as the data.
pub(super) struct Tail(String);

impl Tail {
    /// The end of the texts of `values`, joined by commas.
    pub(super) fn of<T: fmt::Display>(values: impl IntoIterator<Item = T>) -> String {
        let mut tail = Self(String::new());
        for (index, value) in values.into_iter().enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            // Writing to memory cannot fail.
            write!(tail, "{comma}{value}").ok();
        }
        tail.0
    }
}

impl fmt::Write for Tail {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.push_str(end_of(text));
        if self.0.len() > 4 * TAIL_BYTES {
            self.0 = end_of(&self.0).to_owned();
        }
        Ok(())
    }
}

/// The last [`TAIL_BYTES`] bytes of a text, without a part of a character.
fn end_of(text: &str) -> &str {
    let start = text.len().saturating_sub(TAIL_BYTES);
    let mut starts = start..=text.len();
    let start = starts.find(|at| text.is_char_boundary(*at));
    start.map_or("", |start| &text[start..])
}
