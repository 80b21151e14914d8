//! What the monitor added to the page: the channel `page`.

use serde_json::Value;

use crate::channel::Channel;
use crate::error::RecordError;
use crate::recording::Recording;

impl Recording {
    /// The messages of the channel `page`, of every history, in the order they were recorded:
    /// what ended an epoch belongs to the history that follows it.
    ///
    /// # Errors
    ///
    /// When a chunk cannot be read.
    pub fn page_messages(&mut self) -> Result<Vec<Value>, RecordError> {
        let mut messages = Vec::new();
        for place in 0..self.chunk_count() {
            // Few chunks have any; the others are not unpacked.
            if !self.has(place, |channel| channel == Channel::Page) {
                continue;
            }
            let entries = self.unpacked(place)?;
            let of_page = entries.iter().filter(|e| e.channel == Channel::Page);
            messages.extend(of_page.filter_map(|e| serde_json::from_slice(&e.bytes).ok()));
        }
        Ok(messages)
    }
}
