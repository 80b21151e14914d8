//! Copies a part of a recording to a new file.

use std::path::Path;

use crate::channel::Channel;
use crate::error::RecordError;
use crate::recording::Recording;
use crate::writer::{Preamble, RecordingWriter};

/// Time before the span that is copied as well (ns): a replay starts at a keyframe, and there
/// is one every second.
// A second, and a tenth for a keyframe that was late.
const LEAD_NS: u64 = 1_100_000_000;

/// A copied span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Copied {
    /// Size of the new file (bytes).
    pub bytes: u64,
    /// Messages of the span that the recorder missed.
    pub missing: u64,
}

impl Recording {
    /// Writes the messages from `from_s` to `to_s`, and the second before, which has the
    /// keyframes, to a new file.
    ///
    /// # Errors
    ///
    /// When the file is there already or cannot be written, or a chunk cannot
    /// be read. A file that cannot be finished is removed.
    pub fn copy_span(&self, from_s: f64, to_s: f64, out: &Path) -> Result<Copied, RecordError> {
        let preamble = Preamble::new(self.run(), self.scene());
        let mut writer = RecordingWriter::create(out, &preamble)?;
        let copied = self.copy_to(&mut writer, from_s, to_s);
        let finished = copied.and_then(|missing| {
            let bytes = writer.finish()?;
            Ok(Copied { bytes, missing })
        });
        // Half a copy looks like a recording with less in it.
        finished.inspect_err(|_| {
            let _gone = std::fs::remove_file(out).is_ok();
        })
    }

    /// Copies the span; returns the number of its messages that the recorder missed.
    fn copy_to(
        &self,
        to: &mut RecordingWriter,
        from_s: f64,
        to_s: f64,
    ) -> Result<u64, RecordError> {
        let ns = |time_s: f64| (time_s * 1.0e9).round().max(0.0) as u64;
        let span = ns(from_s).saturating_sub(LEAD_NS)..=ns(to_s);
        let (mut entries, mut epoch) = (self.messages_from(*span.start()), None);
        let mut missing = 0;
        while let Some(entry) = entries.next() {
            let entry = match entry {
                Ok(entry) => entry,
                // Recording continues meanwhile: its oldest file may be gone.
                Err(RecordError::Io { source, .. })
                    if source.kind() == std::io::ErrorKind::NotFound =>
                {
                    continue;
                }
                Err(error) => return Err(error),
            };
            // The new file has its own preamble and epochs.
            let is_preamble = matches!(
                entry.channel,
                Channel::Run | Channel::Scene | Channel::SceneUpdate | Channel::Epoch
            );
            let of = entries.epoch();
            let is_shown = self.shows(of, &entry);
            // The events that ended an epoch are reported after the start of the next one.
            let is_wanted = is_shown || entry.channel == Channel::Page;
            if !span.contains(&entry.time_ns) || is_preamble || !is_wanted {
                continue;
            }
            // Announced before its first message, so that a chunk has one epoch only.
            if (is_shown || epoch.is_none()) && epoch.replace(of) != Some(of) {
                to.begin_epoch(of, entry.time_ns)?;
            }
            if entry.channel == Channel::Gaps {
                missing += missed(&entry.bytes);
            }
            to.add(&entry.message())?;
        }
        Ok(missing)
    }
}

/// The count of a line of the channel `gaps`.
fn missed(line: &[u8]) -> u64 {
    let gap: Option<serde_json::Value> = serde_json::from_slice(line).ok();
    gap.and_then(|gap| gap.get("count")?.as_u64()).unwrap_or(0)
}
