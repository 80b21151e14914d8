//! Destinations of messages: the ring, and the file being kept.
//!
//! Each can fail without the other: a file that fails is closed and reported, while the ring
//! retries. A restart of physics sets simulated time back, so answers that belong to the time
//! before it are dropped; in a file their time would be in the future.

use std::path::{Path, PathBuf};

use cell_record::{Channel, Disk, Flight, Message, Preamble, RecordingWriter};
use cell_run::record::RecordReport;
use cell_run::spec::RunSpec;
use serde_json::Value;

/// The open file is readable up to this long ago (ns).
const FLUSH_NS: u64 = 1_000_000_000;

/// An answer may be read before the state it answers by this much (simulated ns).
// Taps are read one after the other; within one reading an answer can be ahead of its state.
const EARLY_NS: u64 = 100_000_000;

struct Kept {
    path: PathBuf,
    writer: RecordingWriter,
    from_s: Option<f64>,
    to_s: f64,
    flush_ns: u64,
}

/// Writes messages to the ring and the file.
pub(super) struct Sink {
    flight: Flight,
    preamble: Preamble,
    kept: Option<Kept>,
    /// The file of the whole run, or the part of it that this recorder writes.
    run_file: Option<PathBuf>,
    /// Error of a file.
    trouble: Option<String>,
    /// Bytes of the files that are closed.
    closed_bytes: u64,
    missed: u64,
    now_ns: u64,
    /// Start of the epoch, or of this recorder (simulated ns).
    begin_ns: u64,
    /// Time of the newest state (simulated ns).
    state_ns: u64,
}

impl Sink {
    pub(super) fn new(spec: &RunSpec, scene: &Value) -> Self {
        let preamble = Preamble::new(spec, scene);
        let record = &spec.record;
        let flight = Flight::new(
            Box::new(Disk),
            &record.flight_dir,
            spec.run,
            record.limit_bytes,
            preamble.clone(),
        );
        Self {
            // A process that has not seen a state uses tick 0.
            begin_ns: flight.end_ns(),
            flight,
            preamble,
            kept: None,
            run_file: None,
            trouble: None,
            closed_bytes: 0,
            missed: 0,
            now_ns: 0,
            state_ns: u64::MAX,
        }
    }

    /// Sets the time of the messages that follow.
    pub(super) fn at(&mut self, now_ns: u64) {
        self.now_ns = now_ns;
    }

    /// Writes a packed message.
    pub(super) fn put(&mut self, message: &Message<'_>) {
        match message.channel {
            Channel::Epoch => return self.begin_epoch(message),
            Channel::World => self.state_ns = message.time_ns,
            // An answer to a state of the epoch before belongs to no history.
            _ if message.time_ns > self.state_ns.saturating_add(EARLY_NS) => return,
            _ => {}
        }
        let message = &Message {
            // Not before the epoch: messages of a process without a state have tick 0.
            time_ns: message.time_ns.max(self.begin_ns),
            ..*message
        };
        // The ring counts its own losses; they do not concern the file.
        self.flight.append_packed(message, self.now_ns);
        let Some(kept) = &mut self.kept else {
            return;
        };
        let time_s = message.time_ns as f64 / 1.0e9;
        kept.from_s.get_or_insert(time_s);
        kept.to_s = kept.to_s.max(time_s);
        if let Err(error) = kept.writer.add_packed(message) {
            self.give_up(&error.to_string());
        }
    }

    /// Writes a message of the channel `page`, at the time of the newest state: the recorder may
    /// read the bus later than the monitor.
    pub(super) fn put_page(&mut self, bytes: &[u8]) {
        let has_state = self.state_ns != u64::MAX;
        self.put(&Message {
            channel: Channel::Page,
            time_ns: if has_state {
                self.state_ns
            } else {
                self.begin_ns
            },
            publish_ns: self.now_ns,
            seq: 0,
            bytes,
        });
    }

    /// Starts an epoch: simulated time was set back to that of `message`.
    fn begin_epoch(&mut self, message: &Message<'_>) {
        let epoch = u32::try_from(message.seq).unwrap_or(u32::MAX);
        // Both, so that answers to later ticks of the epoch before are recognised.
        (self.begin_ns, self.state_ns) = (message.time_ns, message.time_ns);
        self.flight.begin_epoch(epoch);
        self.preamble.set_epoch(epoch);
        let begun = self.kept.as_mut();
        let begun = begun.map(|kept| kept.writer.begin_epoch(epoch, message.time_ns));
        if let Some(Err(error)) = begun {
            self.give_up(&error.to_string());
        }
    }

    /// Counts messages that were overwritten before they were read.
    pub(super) fn missed(&mut self, count: u64) {
        self.missed += count;
    }

    pub(super) fn flush(&mut self) {
        self.flight.flush(self.now_ns);
        if let Some(Err(error)) = self.kept.as_mut().map(|kept| kept.writer.flush()) {
            self.give_up(&error.to_string());
        }
    }

    pub(super) fn flush_if_due(&mut self) {
        self.flight.flush_if_due(self.now_ns);
        let now_ns = self.now_ns;
        let due = self.kept.as_mut().filter(|kept| now_ns >= kept.flush_ns);
        let flushed = due.map(|kept| {
            kept.flush_ns = now_ns + FLUSH_NS;
            kept.writer.flush()
        });
        if let Some(Err(error)) = flushed {
            self.give_up(&error.to_string());
        }
    }

    /// Records everything from now on in a new file.
    pub(super) fn start(&mut self, path: &Path) -> Result<String, String> {
        if let Some(kept) = &self.kept {
            let path = kept.path.display();
            return Err(format!("{path} is being recorded already; stop that first"));
        }
        // Never over an existing file: creating it fails instead.
        let writer = RecordingWriter::create(path, &self.preamble);
        self.kept = Some(Kept {
            path: path.to_owned(),
            writer: writer.map_err(|error| error.to_string())?,
            from_s: None,
            to_s: 0.0,
            flush_ns: 0,
        });
        self.trouble = None;
        Ok(format!("recording to {}", path.display()))
    }

    /// As [`Self::start`], for the file of the whole run.
    pub(super) fn start_run(&mut self, path: &Path, generation: u32) {
        let mut path = path.to_owned();
        // An earlier start of this process wrote the first part.
        if generation > 1 && path.exists() {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            path = path.with_file_name(format!("{stem}-part{generation}.mcap"));
        }
        match self.start(&path) {
            Ok(_) => self.run_file = Some(path),
            Err(why) => self.trouble = Some(why),
        }
    }

    /// State of the recording, for the launcher.
    pub(super) fn report(&self) -> RecordReport {
        let open = self.kept.as_ref().map_or(0, |kept| kept.writer.bytes());
        RecordReport {
            gaps: self.gaps(),
            bytes: self.closed_bytes + open,
            error: self.trouble().map(str::to_owned),
            closed: false,
            files: self.run_file.iter().cloned().collect(),
        }
    }

    /// Closes the file.
    pub(super) fn stop(&mut self) -> Result<String, String> {
        let kept = self.kept.take();
        let kept = kept.ok_or_else(|| "nothing is being recorded to a file".to_owned())?;
        let path = kept.path.display();
        let bytes = kept.writer.finish().map_err(|error| {
            let why = format!("recording to {path} stopped: {error}");
            self.trouble = Some(why.clone());
            why
        })?;
        self.closed_bytes += bytes;
        Ok(format!(
            "{path}: {:.1} s to {:.1} s, {:.1} MB",
            kept.from_s.unwrap_or(0.0),
            kept.to_s,
            bytes as f64 / 1.0e6
        ))
    }

    /// Name of the file being recorded.
    pub(super) fn file(&self) -> Option<String> {
        self.kept.as_ref().map(|k| k.path.display().to_string())
    }

    pub(super) fn flight(&self) -> &Flight {
        &self.flight
    }

    /// Messages missing in the ring.
    pub(super) fn gaps(&self) -> u64 {
        self.missed + self.flight.lost()
    }

    pub(super) fn trouble(&self) -> Option<&str> {
        self.flight.trouble().or(self.trouble.as_deref())
    }

    /// Closes file and ring.
    pub(super) fn close(&mut self) {
        if self.kept.is_some() {
            // An error of the file is in the report.
            let _said = self.stop().is_ok();
        }
        self.flight.close();
    }

    fn give_up(&mut self, why: &str) {
        // Not finished: the disk has just refused; the flushed part can be read.
        if let Some(kept) = self.kept.take() {
            self.closed_bytes += kept.writer.bytes();
            let path = kept.path.display();
            self.trouble = Some(format!("recording to {path} stopped: {why}"));
        }
    }
}
