//! Reads a recording: a file, or the directory of a flight recorder.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cell_model::runs::spec::RunSpec;
use cell_model::user_file;
use ipc_types::TraceLine;
use serde_json::Value;

use crate::channel::Channel;
use crate::chunk::{self, Chunk};
use crate::entry::Entry;
use crate::epoch::{self, EpochSpan, Line, Span};
use crate::error::RecordError;
use crate::flight;
use crate::frame::{Backwards, Frame};
use crate::index::FileIndex;

/// Unpacked chunks that are kept for the next look.
const KEPT: usize = 6;
/// Chunks that are looked through for a moment: some seconds.
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
        let files = if path.is_dir() {
            // A segment that was begun this moment, or removed, is no trouble.
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
            places.extend((0..file.chunks.len()).map(|chunk| (number, chunk)));
        }
        let cut = files.first().and_then(|file| file.cut.clone());
        let Some(first) = files.first().and_then(|f| Some((f, f.chunks.first()?))) else {
            return Err(nothing(cut.unwrap_or_else(|| "it is empty".to_owned())));
        };
        let begin = entries(first.0, first.1)?;
        let json = |channel: Channel| {
            let entry = begin.iter().find(|entry| entry.channel == channel);
            entry.ok_or_else(|| nothing(format!("it has no {:?}", channel.name())))
        };
        let refuse = |error: serde_json::Error| nothing(format!("of another version: {error}"));
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

    /// Shows the history of `epoch` from now on, a generation of physics; that of
    /// the newest one where that is `None` or not recorded.
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

    /// Why the recording ends early; `None` where every file was closed.
    pub fn cut(&self) -> Option<&str> {
        self.files.iter().rev().find_map(|file| file.cut.as_deref())
    }

    /// What was said last at or before `time_s`.
    ///
    /// # Errors
    ///
    /// When there is no whole state, or the chunk cannot be read.
    pub fn at(&mut self, time_s: f64) -> Result<Frame, RecordError> {
        let time_ns = nanoseconds(time_s);
        let arms = usize::from(self.run.arms);
        let (mut look, mut back) = (Backwards::at(time_ns), 0);
        // A paused cell fills chunks with one state for as long as it is paused.
        let mut instant = None;
        for place in (0..self.places.len()).rev() {
            let Some(epoch) = self.epoch_of(place, |c| c.start_ns <= time_ns) else {
                continue;
            };
            let of_instant = self.instant(place);
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
            // A task that has not decided yet is not looked for for long.
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
            let has_log = || self.has(place, |channel| channel == Channel::Log);
            let Some(epoch) = epoch.filter(|_| has_log()) else {
                continue;
            };
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

    /// All messages, in the order they were recorded. A chunk that cannot be
    /// read is one error, and those after it follow.
    pub fn messages(&self) -> Entries<'_> {
        self.messages_from(0)
    }

    /// The messages of the history shown from `from_s` to `to_s`, in the order they were
    /// recorded. A chunk that cannot be read is one error, and those after it follow.
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

    /// Whether a chunk may have messages of a channel that is `wanted`.
    fn has(&self, place: usize, wanted: impl Fn(Channel) -> bool) -> bool {
        self.file_and_chunk(place).is_some_and(|(file, chunk)| {
            let channel = |id: &u16| file.names.get(id).copied().flatten();
            let is_wanted = |id: &u16| channel(id).is_some_and(&wanted);
            chunk.channels.is_empty() || chunk.channels.iter().any(is_wanted)
        })
    }

    fn unpacked(&mut self, place: usize) -> Result<Arc<Vec<Entry>>, RecordError> {
        if let Some((_, kept)) = self.kept.iter().find(|(kept, _)| *kept == place) {
            return Ok(kept.clone());
        }
        let Some((file, chunk)) = self.file_and_chunk(place) else {
            return Ok(Arc::default());
        };
        let entries = Arc::new(entries(file, chunk)?);
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
    /// Epoch of the message that came last.
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
            if chunk.end_ns < self.from_ns {
                continue;
            }
            match entries(file, chunk) {
                Ok(entries) => {
                    self.epoch = chunk.epoch;
                    self.waiting = entries.into_iter();
                }
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

fn entries(file: &FileIndex, chunk: &Chunk) -> Result<Vec<Entry>, RecordError> {
    let opened = user_file::open_file(&file.path);
    let mut opened = opened.map_err(|e| RecordError::io(&file.path, e))?;
    chunk::read(&mut opened, &file.path, chunk, &mut file.names.clone())
}

/// Ticks are whole milliseconds: half a one absorbs what the way over seconds
/// cost.
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1.0e9).round().max(0.0) as u64
}
