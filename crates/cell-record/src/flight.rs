//! The flight recorder: a ring of whole files in a directory.

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
const SEGMENT_BYTES: u64 = 8 << 20;
/// ... but there are at least this many in the ring, ...
const LEAST_SEGMENTS: u64 = 8;
/// ... and at this length (simulated ns).
const SEGMENT_NS: u64 = 10_000_000_000;
/// The open segment is readable up to this long ago.
const FLUSH_NS: u64 = 1_000_000_000;
/// Time between two attempts on a disk that does not take anything.
const RETRY_NS: u64 = 1_000_000_000;
const ENDING: &str = ".mcap";

struct Segment {
    path: PathBuf,
    bytes: u64,
    /// What is in it; nothing of another run.
    spans: Vec<Span>,
}

struct Open {
    writer: RecordingWriter,
    path: PathBuf,
    span: Span,
}

/// Keeps the newest messages, as many as fit into a number of bytes. A disk that
/// is full, or a directory that is gone, costs messages, which are counted; it
/// continues by itself.
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
    /// The ring of run `run` in `dir`, of at most `limit_bytes`; what earlier
    /// runs left there goes first. Nothing is written before the first message.
    pub fn new(
        mut storage: Box<dyn Storage>,
        dir: &Path,
        run: u64,
        limit_bytes: u64,
        mut preamble: Preamble,
    ) -> Self {
        let mut found: Vec<_> = storage
            .list(dir)
            .into_iter()
            .filter_map(|(path, bytes)| Some((number_and_run(&path)?, path, bytes)))
            .collect();
        found.sort();
        let number = found.last().map_or(0, |((number, _), _, _)| number + 1);
        // Segments of an earlier start of the recorder are still looked into.
        let closed = found.into_iter().map(|((_, of), path, bytes)| {
            let index = (of == run).then(|| FileIndex::scan(&path).ok()).flatten();
            let spans = index.map_or_else(Vec::new, |index| epoch::merged(index.spans()));
            Segment { path, bytes, spans }
        });
        let closed: VecDeque<Segment> = closed.collect();
        // Until the first state says otherwise, physics is the one it was.
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

    /// Adds a message at `now_ns` of any clock, whose struct has been through
    /// [`crate::pack()`]; false when it was lost.
    pub fn append_packed(&mut self, message: &Message<'_>, now_ns: u64) -> bool {
        let put = self.try_append(message, now_ns);
        if let Err(why) = &put {
            self.give_up(why, now_ns);
        }
        let kept = matches!(put, Ok(true));
        if !kept {
            let lost = self.lost.entry(message.channel).or_insert((0, message.seq));
            *lost = (lost.0 + 1, message.seq);
            self.lost_total += 1;
        }
        kept
    }

    /// Writes down what was added; all of it can be read afterwards.
    pub fn flush(&mut self, now_ns: u64) {
        let Some(open) = &mut self.open else {
            return;
        };
        self.flush_ns = now_ns + FLUSH_NS;
        if let Err(error) = open.writer.flush() {
            self.give_up(&error.to_string(), now_ns);
        }
    }

    /// Flushes where it is time for it.
    pub fn flush_if_due(&mut self, now_ns: u64) {
        if now_ns >= self.flush_ns {
            self.flush(now_ns);
        }
    }

    /// Says that what follows is of `epoch`, a generation of physics.
    pub fn begin_epoch(&mut self, epoch: u32) {
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

    /// Messages the disk did not take.
    pub fn lost(&self) -> u64 {
        self.lost_total
    }

    /// What is wrong now.
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    /// Closes the open segment.
    pub fn close(&mut self) {
        if let Some(open) = self.open.take() {
            let bytes = open.writer.bytes();
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
        let limit = SEGMENT_BYTES.min(self.limit_bytes / LEAST_SEGMENTS);
        let long = span.to_ns - span.from_ns >= SEGMENT_NS;
        if long || open.writer.bytes() >= limit {
            self.close();
            self.make_room();
        }
        Ok(true)
    }

    fn begin(&mut self, time_ns: u64, now_ns: u64) -> Result<(), String> {
        self.make_room();
        let path = self.dir.join(name(self.number, self.run));
        self.number += 1;
        let file = self.storage.create(&path).map_err(|e| e.to_string())?;
        let writer = RecordingWriter::new(file, &self.preamble);
        let begun = writer.and_then(|mut writer| {
            writer.begin_at(time_ns)?;
            for (channel, (count, before)) in &self.lost {
                let gap = gap(*channel, *count, *before, "disk");
                writer.add(&gap_message(&gap, time_ns))?;
            }
            writer.flush()?;
            Ok(writer)
        });
        let writer = begun.map_err(|error: RecordError| {
            // An empty file says nothing, and takes room.
            let _gone = self.storage.remove(&path).is_ok();
            error.to_string()
        })?;
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
        self.close();
    }

    /// Removes the oldest until there is room for one more segment.
    fn make_room(&mut self) {
        let next = SEGMENT_BYTES.min(self.limit_bytes / LEAST_SEGMENTS);
        while self.bytes() + next > self.limit_bytes {
            let Some(oldest) = self.closed.pop_front() else {
                return;
            };
            // What is gone already takes no room.
            let _gone = self.storage.remove(&oldest.path).is_ok();
        }
    }
}

impl Drop for Flight {
    fn drop(&mut self) {
        self.close();
    }
}

/// A line of the channel `gaps`: `count` messages of `channel` were not
/// recorded, the last of them right before or at number `before`.
pub fn gap(channel: Channel, count: u64, before: u64, why: &str) -> Vec<u8> {
    let channel = channel.name();
    json!({ "channel": channel, "count": count, "before_seq": before, "why": why })
        .to_string()
        .into_bytes()
}

/// The message that says it.
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
    let of_run = found
        .into_iter()
        .filter(|((_, run), _)| Some(*run) == newest);
    Ok(of_run.map(|(_, path)| path).collect())
}
