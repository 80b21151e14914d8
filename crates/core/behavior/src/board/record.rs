//! A board as a checkpoint: its values by the hash of the key's name.

use super::bytes::{Carried, Reader, RecordError, close, open, with_length};
use super::store::Board;
use crate::value::Value;

const MAGIC: [u8; 4] = *b"BBrd";
// A change of the layout needs another number: entries have no field names.
const VERSION: u16 = 1;

impl Board {
    /// Appends all values as a checkpoint. Uses no heap once `record` has room.
    pub fn save(&self, record: &mut Vec<u8>) {
        let start = open(record, MAGIC, VERSION);
        // By the hash of the name: keys may be reordered, added and removed in an edited file.
        for (hash, value) in self.hashed() {
            record.extend_from_slice(&hash.to_le_bytes());
            with_length(record, |record| {
                if let Some(value) = value {
                    // Writing plain data to memory does not fail.
                    let _written = bincode::serialize_into(record, value).is_ok();
                }
            });
        }
        close(record, start);
    }

    /// Restores values by the names of their keys. Keys that are not in the
    /// record get their default.
    ///
    /// # Errors
    /// [`RecordError`], and no change, for bytes that are not such a checkpoint.
    pub fn restore(&mut self, record: &[u8]) -> Result<Carried, RecordError> {
        let mut entries = Reader::open(record, MAGIC, VERSION, "blackboard")?;
        // A first pass over the lengths alone: after it no error can occur in the middle.
        let mut checked = entries.clone();
        while checked.end().is_err() {
            checked.u64()?;
            checked.sized()?;
        }
        self.reset();
        let mut carried = Carried::default();
        while entries.end().is_err() {
            let hash = entries.u64()?;
            if self.take(hash, entries.sized()?) {
                carried.keys += 1;
            } else {
                carried.lost += 1;
            }
        }
        Ok(carried)
    }

    fn take(&mut self, hash: u64, bytes: &[u8]) -> bool {
        let Some(index) = self.hashed().position(|(known, _)| known == hash) else {
            return false;
        };
        // No bytes are a key without a value, which differs from one that is not in the record.
        if bytes.is_empty() {
            self.unset(index);
            return true;
        }
        match bincode::deserialize::<Value>(bytes) {
            // `set` checks the type: the key may have another one in an edited file.
            Ok(value) => self.set(index, value),
            Err(_) => false,
        }
    }
}
