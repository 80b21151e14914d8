//! Reads a recording: a file, or the directory of a flight recorder.
//!
//! A directory may be of a recorder that is running: its oldest file can disappear and its
//! newest grow between two calls. A chunk that cannot be read is an error of that chunk; the
//! rest of the recording stays readable. After a restart of physics the same time occurs more
//! than once, so every search is along one history (`Line`).

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cell_run::spec::RunSpec;
use ipc_types::TraceLine;
use serde_json::Value;

use crate::channel::Channel;
use crate::chunk::Chunk;
use crate::entry::Entry;
use crate::epoch::{self, EpochSpan, Line, Span};
use crate::error::RecordError;
use crate::flight;
use crate::frame::{Backwards, Frame};
use crate::index::FileIndex;

/// Unpacked chunks that are kept for the next request.
// A page that drags its slider back and forth reads the same few chunks again.
const KEPT: usize = 6;
/// Chunks that are searched for one moment: some seconds.
// Bounds the time of a request where a recording lacks the state.
const MAX_BACK: usize = 48;

/// A recording that is open for reading.
pub struct Recording {
    path: PathBuf,
    files: Vec<FileIndex>,
    /// File and chunk, in the order of recording.
    places: Vec<(usize, usize)>,
    run: RunSpec,
    scene: Value,
    epochs: Vec<Span>,
    line: Line,
    kept: VecDeque<(usize, Arc<Vec<Entry>>)>,
}

impl Recording {
    /// Opens a file, or the newest run in the directory of a flight recorder.
    ///
    /// # Errors
    ///
    /// When there is nothing that can be read, and why.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        if !path.try_exists().unwrap_or(true) {
            return Err(RecordError::NoRecording {
                path: path.to_owned(),
                reason: "no such file or directory".to_owned(),
            });
        }
        let files = if path.is_dir() {
            // A file that was started or removed at this moment is not an error.
            let segments = flight::segments(path)?;
            let scanned = segments.iter().filter_map(|s| FileIndex::scan(s).ok());
            scanned.filter(|file| !file.chunks.is_empty()).collect()
        } else {
            vec![FileIndex::scan(path)?]
        };
        Self::of(path, files)
    }

    fn of(path: &Path, files: Vec<FileIndex>) -> Result<Self, RecordError> {
        let nothing = |reason: String| RecordError::NoRecording {
            path: path.to_owned(),
            reason,
        };
        let mut places = Vec::new();
        for (number, file) in files.iter().enumerate() {
            // Files in order, chunks in order: the order of recording, across epochs.
            places.extend((0..file.chunks.len()).map(|chunk| (number, chunk)));
        }
        let cut = files.first().and_then(|file| file.cut.clone());
        // The reason of the cut is given: "empty" would be wrong
        // for a file cut in its first chunk.
        let Some(first) = files.first().and_then(|f| Some((f, f.chunks.first()?))) else {
            return Err(nothing(cut.unwrap_or_else(|| "it is empty".to_owned())));
        };
        let begin = first.0.entries(first.1)?;
        let json = |channel: Channel| {
            let entry = begin.iter().find(|entry| entry.channel == channel);
            entry.ok_or_else(|| nothing(format!("it has no {:?}", channel.name())))
        };
        let refuse = |error: serde_json::Error| nothing(format!("of another version: {error}"));
        // Other fields than expected: a version error, not a damaged file.
        let run = serde_json::from_slice(&json(Channel::Run)?.bytes).map_err(refuse)?;
        let scene = serde_json::from_slice(&json(Channel::Scene)?.bytes).map_err(refuse)?;
        let epochs = epoch::merged(files.iter().flat_map(FileIndex::spans));
        Ok(Self {
            line: Line::of(&epochs, None),
            epochs,
            path: path.to_owned(),
            files,
            places,
            run,
            scene,
            kept: VecDeque::new(),
        })
    }

    /// The file or directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The epochs in it, oldest first.
    pub fn epochs(&self) -> Vec<EpochSpan> {
        self.epochs.iter().copied().map(EpochSpan::from).collect()
    }

    /// Shows the history of `epoch` from now on, a generation of physics; that of the newest
    /// one where `epoch` is `None` or not recorded.
    pub fn show_epoch(&mut self, epoch: Option<u32>) {
        self.line = Line::of(&self.epochs, epoch);
    }

    /// First and last simulated time of the history shown (s).
    pub fn span_s(&self) -> (f64, f64) {
        let (from, to) = self.line.span_ns;
        (from as f64 / 1.0e9, to as f64 / 1.0e9)
    }

    /// The run it is of.
    pub fn run(&self) -> &RunSpec {
        &self.run
    }

    /// The scene of the page.
    pub fn scene(&self) -> &Value {
        &self.scene
    }

    /// Reason why the recording ends early; `None` if every file was closed.
    pub fn cut(&self) -> Option<&str> {
        self.files.iter().rev().find_map(|file| file.cut.as_deref())
    }

    /// The last messages at or before `time_s`, combined to one moment.
    ///
    /// # Errors
    ///
    /// When no complete state is found, or the chunk cannot be read.
    pub fn at(&mut self, time_s: f64) -> Result<Frame, RecordError> {
        let time_ns = nanoseconds(time_s);
        let arms = usize::from(self.run.arms);
        let (mut look, mut back) = (Backwards::at(time_ns), 0);
        // A paused cell fills chunks with one state as long as it is paused.
        let mut instant = None;
        // Backwards from the newest chunk: most of the moment is found there.
        for place in (0..self.places.len()).rev() {
            let Some(epoch) = self.epoch_of(place, |c| c.start_ns <= time_ns) else {
                continue;
            };
            let of_instant = self.instant(place);
            // A chunk of the same instant repeats state and
            // status; reading it again adds nothing.
            let repeats = of_instant.is_some() && of_instant == instant;
            let adds = |channel| look.lacks(channel, arms) && !(repeats && channel.is_of_state());
            if back > 0 && !self.has(place, adds) {
                continue;
            }
            instant = of_instant;
            let entries = self.unpacked(place)?;
            let shown = |entry: &&Entry| self.line.has(epoch, entry.time_ns);
            entries
                .iter()
                .rev()
                .filter(shown)
                .for_each(|e| look.take(e));
            back += 1;
            // The search for a task that has not decided yet is given up early.
            if look.is_complete(arms) || back >= MAX_BACK || (look.has_world() && back > 8) {
                break;
            }
        }
        let (from_s, to_s) = self.span_s();
        look.frame().ok_or(RecordError::NoState {
            time_s,
            from_s,
            to_s,
        })
    }

    /// The trace after `from_s` up to `to_s`, oldest first.
    ///
    /// # Errors
    ///
    /// When a chunk cannot be read.
    pub fn trace(&mut self, from_s: f64, to_s: f64) -> Result<Vec<TraceLine>, RecordError> {
        let (from, to) = (nanoseconds(from_s), nanoseconds(to_s));
        // By chunk times: a chunk outside is not unpacked.
        let wanted = |c: &Chunk| c.end_ns > from && c.start_ns <= to;
        let mut lines = Vec::new();
        for place in 0..self.places.len() {
            let Some(epoch) = self.epoch_of(place, wanted) else {
                continue;
            };
            for entry in self.unpacked(place)?.iter() {
                let time = entry.time_ns;
                let is_trace = matches!(entry.channel, Channel::Trace | Channel::Log);
                if is_trace && time > from && time <= to && self.line.has(epoch, time) {
                    lines.push(entry.read()?);
                }
            }
        }
        Ok(lines)
    }

    /// The last `count` lines for people up to `time_s`, oldest first.
    ///
    /// # Errors
    ///
    /// When a chunk cannot be read.
    pub fn log_until(&mut self, time_s: f64, count: usize) -> Result<Vec<TraceLine>, RecordError> {
        let to = nanoseconds(time_s);
        let mut lines = Vec::new();
        for place in (0..self.places.len()).rev() {
            if lines.len() >= count {
                break;
            }
            let epoch = self.epoch_of(place, |c| c.start_ns <= to);
            // The indices tell which chunks have log lines; the others are not unpacked.
            let has_log = || self.has(place, |channel| channel == Channel::Log);
            let Some(epoch) = epoch.filter(|_| has_log()) else {
                continue;
            };
            // Backwards here and in the chunks, so only as many chunks as needed are read.
            for entry in self.unpacked(place)?.iter().rev() {
                let wanted = entry.channel == Channel::Log && entry.time_ns <= to;
                if wanted && lines.len() < count && self.line.has(epoch, entry.time_ns) {
                    lines.push(entry.read()?);
                }
            }
        }
        lines.reverse();
        Ok(lines)
    }

    /// All messages, in the order they were recorded. A chunk that cannot be read is one error,
    /// and the following chunks are read.
    pub fn messages(&self) -> Entries<'_> {
        self.messages_from(0)
    }

    /// The messages of the history shown from `from_s` to `to_s`, in the order they were
    /// recorded. A chunk that cannot be read is one error, and the following chunks are read.
    pub fn history(
        &self,
        from_s: f64,
        to_s: f64,
    ) -> impl Iterator<Item = Result<Entry, RecordError>> {
        let (from, to) = (nanoseconds(from_s), nanoseconds(to_s));
        let mut entries = self.messages_from(from);
        std::iter::from_fn(move || {
            loop {
                let entry = match entries.next()? {
                    Ok(entry) => entry,
                    Err(error) => return Some(Err(error)),
                };
                // Chunks are chosen by their time, messages by theirs:
                // a chunk may reach over the span.
                let wanted = (from..=to).contains(&entry.time_ns);
                if wanted && self.shows(entries.epoch(), &entry) {
                    return Some(Ok(entry));
                }
            }
        })
    }

    /// As [`Self::messages`], without the chunks that end before `time_ns`.
    pub(crate) fn messages_from(&self, time_ns: u64) -> Entries<'_> {
        Entries {
            recording: self,
            next: 0,
            from_ns: time_ns,
            epoch: 0,
            waiting: Vec::new().into_iter(),
        }
    }

    /// Whether `entry` of `epoch` is part of the history shown.
    pub(crate) fn shows(&self, epoch: u32, entry: &Entry) -> bool {
        self.line.has(epoch, entry.time_ns)
    }

    /// Epoch of a chunk that is `wanted` and may be part of the history shown.
    fn epoch_of(&self, place: usize, wanted: impl FnOnce(&Chunk) -> bool) -> Option<u32> {
        let (_, chunk) = self.file_and_chunk(place)?;
        // With the start of the chunk: a history is left at the
        // time at which the next one resumed.
        let wanted = wanted(chunk) && self.line.has(chunk.epoch, chunk.start_ns);
        wanted.then_some(chunk.epoch)
    }

    fn file_and_chunk(&self, place: usize) -> Option<(&FileIndex, &Chunk)> {
        let (file, chunk) = *self.places.get(place)?;
        let file = self.files.get(file)?;
        Some((file, file.chunks.get(chunk)?))
    }

    /// The time of all messages of a chunk; `None` where they differ.
    fn instant(&self, place: usize) -> Option<u64> {
        let (_, chunk) = self.file_and_chunk(place)?;
        (chunk.start_ns == chunk.end_ns).then_some(chunk.start_ns)
    }

    /// Number of chunks, which are numbered in the order of recording.
    pub(crate) fn chunk_count(&self) -> usize {
        self.places.len()
    }

    /// Whether a chunk may have messages of a channel that is `wanted`.
    pub(crate) fn has(&self, place: usize, wanted: impl Fn(Channel) -> bool) -> bool {
        self.file_and_chunk(place).is_some_and(|(file, chunk)| {
            let channel = |id: &u16| file.names.get(id).copied().flatten();
            let is_wanted = |id: &u16| channel(id).is_some_and(&wanted);
            // Unknown channels: the chunk has to be read to know.
            chunk.channels.is_empty() || chunk.channels.iter().any(is_wanted)
        })
    }

    /// The messages of a chunk.
    pub(crate) fn unpacked(&mut self, place: usize) -> Result<Arc<Vec<Entry>>, RecordError> {
        if let Some((_, kept)) = self.kept.iter().find(|(kept, _)| *kept == place) {
            return Ok(kept.clone());
        }
        let Some((file, chunk)) = self.file_and_chunk(place) else {
            return Ok(Arc::default());
        };
        let entries = Arc::new(file.entries(chunk)?);
        // The oldest request first, not the least used: a
        // slider moves on and rarely returns far.
        if self.kept.len() >= KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back((place, entries.clone()));
        Ok(entries)
    }
}

/// The messages of a recording.
pub struct Entries<'a> {
    recording: &'a Recording,
    next: usize,
    from_ns: u64,
    epoch: u32,
    waiting: std::vec::IntoIter<Entry>,
}

impl Entries<'_> {
    /// Epoch of the last message returned.
    pub(crate) fn epoch(&self) -> u32 {
        self.epoch
    }
}

impl Iterator for Entries<'_> {
    type Item = Result<Entry, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(entry) = self.waiting.next() {
                return Some(Ok(entry));
            }
            let (file, chunk) = self.recording.file_and_chunk(self.next)?;
            self.next += 1;
            // Chunks before the span are skipped unread.
            if chunk.end_ns < self.from_ns {
                continue;
            }
            match file.entries(chunk) {
                Ok(entries) => {
                    self.epoch = chunk.epoch;
                    self.waiting = entries.into_iter();
                }
                // One error, then the next chunk: damage in the middle must not hide the end.
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

/// Ticks are whole milliseconds: the rounding of a time in seconds is far below half of one.
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1.0e9).round().max(0.0) as u64
}
