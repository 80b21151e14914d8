//! The flight recorder: a ring of whole files in a directory.
//!
//! What can go wrong: the disk is full or gone, the recorder is killed at any instant, or the
//! directory has files of an earlier run. The rules: the ring consists of closed files and one
//! open file that is readable up to the last flush; the oldest file is removed before a new one
//! is started; a message that the disk does not take is lost, counted, and named in the next
//! file as a gap. Recording never stops for good and never stops the cell.
//!
//! A change must not break: `append_packed` reports every lost message; a file starts with run,
//! scene and epoch, so that each can be read alone; the limit of bytes holds at every moment.

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

use serde_json::json;

use crate::channel::Channel;
use crate::entry::Message;
use crate::epoch::{self, EpochSpan, Line, Span};
use crate::error::RecordError;
use crate::index::FileIndex;
use crate::storage::Storage;
use crate::writer::{Preamble, RecordingWriter};

/// A segment is closed at this size (bytes), ...
// Large files compress no better (chunks are the unit), and a small file is all that is lost of
// the past when the oldest one is removed.
const SEGMENT_BYTES: u64 = 8 << 20;
/// ... but the ring has at least this many files, ...
// Removing one of eight keeps seven eighths of the history.
const LEAST_SEGMENTS: u64 = 8;
/// ... and at this length (simulated ns).
const SEGMENT_NS: u64 = 10_000_000_000;
/// The open file is readable up to this long ago.
// A kill loses a second at most; flushing more often makes chunks small and compression poor.
const FLUSH_NS: u64 = 1_000_000_000;
/// Interval between attempts on a disk that refuses to write.
const RETRY_NS: u64 = 1_000_000_000;
const ENDING: &str = ".mcap";

struct Segment {
    path: PathBuf,
    bytes: u64,
    /// Its spans; none for a file of another run.
    spans: Vec<Span>,
}

struct Open {
    writer: RecordingWriter,
    path: PathBuf,
    span: Span,
}

/// Keeps the newest messages, as many as fit into a number of bytes. A full disk or a removed
/// directory costs messages, which are counted; recording resumes when the disk does.
pub struct Flight {
    storage: Box<dyn Storage>,
    dir: PathBuf,
    run: u64,
    limit_bytes: u64,
    preamble: Preamble,
    epoch: u32,
    closed: VecDeque<Segment>,
    open: Option<Open>,
    number: u64,
    flush_ns: u64,
    retry_ns: u64,
    lost: BTreeMap<Channel, (u64, u64)>,
    lost_total: u64,
    trouble: Option<String>,
}

impl Flight {
    /// The ring of run `run` in `dir`, of at most `limit_bytes`; files of earlier runs are
    /// removed first. Nothing is written before the first message.
    pub fn new(
        mut storage: Box<dyn Storage>,
        dir: &Path,
        run: u64,
        limit_bytes: u64,
        mut preamble: Preamble,
    ) -> Self {
        // All files of the ring count against the limit, also those of other runs.
        let mut found: Vec<_> = storage
            .list(dir)
            .into_iter()
            .filter_map(|(path, bytes)| Some((number_and_run(&path)?, path, bytes)))
            .collect();
        // By number: the number only grows, so the order is that of recording.
        found.sort();
        let number = found.last().map_or(0, |((number, _), _, _)| number + 1);
        // Files of an earlier start of the recorder are still part of the history.
        let closed = found.into_iter().map(|((_, of), path, bytes)| {
            let index = (of == run).then(|| FileIndex::scan(&path).ok()).flatten();
            let spans = index.map_or_else(Vec::new, |index| epoch::merged(index.spans()));
            Segment { path, bytes, spans }
        });
        let closed: VecDeque<Segment> = closed.collect();
        // Until the first state names another one, the epoch is the last recorded one.
        let spans = closed.iter().flat_map(|segment| &segment.spans);
        let epoch = spans.map(|span| span.epoch).max().unwrap_or(0);
        preamble.set_epoch(epoch);
        Self {
            storage,
            dir: dir.to_owned(),
            run,
            limit_bytes,
            preamble,
            epoch,
            closed,
            open: None,
            number,
            flush_ns: 0,
            retry_ns: 0,
            lost: BTreeMap::new(),
            lost_total: 0,
            trouble: None,
        }
    }

    /// Adds a message at `now_ns` of any clock, whose struct was packed by [`crate::pack()`];
    /// false when it was lost.
    pub fn append_packed(&mut self, message: &Message<'_>, now_ns: u64) -> bool {
        let put = self.try_append(message, now_ns);
        if let Err(why) = &put {
            self.give_up(why, now_ns);
        }
        let kept = matches!(put, Ok(true));
        if !kept {
            // Counted by channel with the last number, so that a reader knows where the gap is.
            let lost = self.lost.entry(message.channel).or_insert((0, message.seq));
            *lost = (lost.0 + 1, message.seq);
            self.lost_total += 1;
        }
        kept
    }

    /// Writes all added messages to the file, so that they can be read.
    pub fn flush(&mut self, now_ns: u64) {
        let Some(open) = &mut self.open else {
            return;
        };
        self.flush_ns = now_ns + FLUSH_NS;
        if let Err(error) = open.writer.flush() {
            self.give_up(&error.to_string(), now_ns);
        }
    }

    /// Flushes if the interval is over.
    pub fn flush_if_due(&mut self, now_ns: u64) {
        if now_ns >= self.flush_ns {
            self.flush(now_ns);
        }
    }

    /// Starts `epoch`, a generation of physics: all later messages are of it.
    pub fn begin_epoch(&mut self, epoch: u32) {
        // A new file: simulated time goes back, and the times within a file must not.
        self.close();
        self.preamble.set_epoch(epoch);
        self.epoch = epoch;
    }

    /// Simulated time held of the history of the newest epoch (s).
    pub fn span_s(&self) -> (f64, f64) {
        let (from, to) = Line::of(&self.spans(), None).span_ns;
        (from as f64 / 1.0e9, to as f64 / 1.0e9)
    }

    /// Last simulated time held (ns).
    pub fn end_ns(&self) -> u64 {
        Line::of(&self.spans(), None).span_ns.1
    }

    /// The epochs held, oldest first.
    pub fn epochs(&self) -> Vec<EpochSpan> {
        self.spans().into_iter().map(EpochSpan::from).collect()
    }

    fn spans(&self) -> Vec<Span> {
        let closed = self.closed.iter().flat_map(|segment| &segment.spans);
        let open = self.open.iter().map(|open| &open.span);
        epoch::merged(closed.chain(open).copied())
    }

    /// Bytes on the disk.
    pub fn bytes(&self) -> u64 {
        let open = self.open.as_ref().map_or(0, |open| open.writer.bytes());
        self.closed.iter().map(|segment| segment.bytes).sum::<u64>() + open
    }

    /// Number of messages that the disk refused.
    pub fn lost(&self) -> u64 {
        self.lost_total
    }

    /// The current error of the disk; `None` while it accepts messages.
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    /// Closes the open segment.
    pub fn close(&mut self) {
        if let Some(open) = self.open.take() {
            let bytes = open.writer.bytes();
            // A file whose end could not be written is still read
            // by a scan, so it stays in the ring.
            let bytes = open.writer.finish().unwrap_or(bytes);
            self.closed.push_back(Segment {
                path: open.path,
                bytes,
                spans: vec![open.span],
            });
        }
    }

    fn try_append(&mut self, message: &Message<'_>, now_ns: u64) -> Result<bool, String> {
        if self.open.is_none() {
            // The disk refused a moment ago: attempts at 1 kHz
            // would cost more than the recording.
            if now_ns < self.retry_ns {
                return Ok(false);
            }
            self.begin(message.time_ns, now_ns)?;
        }
        let Some(open) = &mut self.open else {
            return Ok(false);
        };
        let added = open.writer.add_packed(message);
        added.map_err(|e| e.to_string())?;
        let span = &mut open.span;
        span.from_ns = span.from_ns.min(message.time_ns);
        span.to_ns = span.to_ns.max(message.time_ns);
        // Never above an eighth of the ring, also where the ring itself is small.
        let limit = SEGMENT_BYTES.min(self.limit_bytes / LEAST_SEGMENTS);
        let long = span.to_ns - span.from_ns >= SEGMENT_NS;
        if long || open.writer.bytes() >= limit {
            // Closed first: the room is made from closed files only.
            self.close();
            self.make_room();
        }
        Ok(true)
    }

    fn begin(&mut self, time_ns: u64, now_ns: u64) -> Result<(), String> {
        // Before the file is created: on a disk with a quota its
        // first block may be the one too many.
        self.make_room();
        let path = self.dir.join(name(self.number, self.run));
        self.number += 1;
        let file = self.storage.create(&path).map_err(|e| e.to_string())?;
        let writer = RecordingWriter::new(file, &self.preamble);
        let begun = writer.and_then(|mut writer| {
            // The preamble first, then the gaps: a reader learns of missing
            // messages at the start of the file.
            writer.begin_at(time_ns)?;
            for (channel, (count, before)) in &self.lost {
                let gap = gap(*channel, *count, *before, "disk");
                writer.add(&gap_message(&gap, time_ns))?;
            }
            writer.flush()?;
            Ok(writer)
        });
        let writer = begun.map_err(|error: RecordError| {
            // An empty file would be scanned and shown as a recording without content.
            let _gone = self.storage.remove(&path).is_ok();
            error.to_string()
        })?;
        // Only now: the gaps are in the file, so they must not be reported twice.
        self.lost.clear();
        self.trouble = None;
        self.flush_ns = now_ns + FLUSH_NS;
        self.open = Some(Open {
            writer,
            path,
            span: Span {
                epoch: self.epoch,
                from_ns: time_ns,
                to_ns: time_ns,
            },
        });
        Ok(())
    }

    fn give_up(&mut self, why: &str, now_ns: u64) {
        self.trouble = Some(format!("{}: {why}", self.dir.display()));
        self.retry_ns = now_ns + RETRY_NS;
        // The file is closed: continuing after a failed write
        // would leave a hole inside a chunk.
        self.close();
    }

    /// Removes the oldest files until one more fits.
    fn make_room(&mut self) {
        let next = SEGMENT_BYTES.min(self.limit_bytes / LEAST_SEGMENTS);
        while self.bytes() + next > self.limit_bytes {
            let Some(oldest) = self.closed.pop_front() else {
                return;
            };
            // A file that is gone already needs no room.
            let _gone = self.storage.remove(&oldest.path).is_ok();
        }
    }
}

impl Drop for Flight {
    fn drop(&mut self) {
        self.close();
    }
}

/// A line of the channel `gaps`: `count` messages of `channel` were not recorded, the last of
/// them right before or at number `before`.
pub fn gap(channel: Channel, count: u64, before: u64, why: &str) -> Vec<u8> {
    let channel = channel.name();
    json!({ "channel": channel, "count": count, "before_seq": before, "why": why })
        .to_string()
        .into_bytes()
}

/// The message for a line of `gap`.
pub fn gap_message(gap: &[u8], time_ns: u64) -> Message<'_> {
    Message {
        channel: Channel::Gaps,
        time_ns,
        publish_ns: 0,
        seq: 0,
        bytes: gap,
    }
}

fn name(number: u64, run: u64) -> String {
    format!("{number:08}-{run:016x}{ENDING}")
}

// The run is in the name, so that files of another run are known without opening them.
fn number_and_run(path: &Path) -> Option<(u64, u64)> {
    let name = path.file_name()?.to_str()?.strip_suffix(ENDING)?;
    let (number, run) = name.split_once('-')?;
    Some((number.parse().ok()?, u64::from_str_radix(run, 16).ok()?))
}

/// Segments of the newest run in `dir`, oldest first.
pub(crate) fn segments(dir: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let read = std::fs::read_dir(dir).map_err(|source| RecordError::io(dir, source))?;
    let paths = read.filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<_> = paths
        .filter_map(|path| number_and_run(&path).map(|key| (key, path)))
        .collect();
    found.sort();
    let newest = found.last().map(|((_, run), _)| *run);
    // One run only: times of two runs in one history would overlap.
    let of_run = found
        .into_iter()
        .filter(|((_, run), _)| Some(*run) == newest);
    Ok(of_run.map(|(_, path)| path).collect())
}
