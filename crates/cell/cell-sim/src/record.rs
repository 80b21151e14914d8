//! Records an episode while it runs in this process: all decisions, and a whole state at the
//! start of each action.

use std::path::{Path, PathBuf};

use cell_model::draft::Draft;
use cell_record::{Channel, Cut, Message, Preamble, RecordError, RecordingWriter, wire_bytes};
use cell_run::spec::{RecordSpec, RunSpec};
use ipc_types::tap::Pieces;
use ipc_types::{DECISION_TICKS, TICK_NS, Wire, WorldPiece};

use crate::OneProcess;
use crate::action::Hold;

/// A recording under way. Its file has another name until it is complete.
pub(crate) struct Recorder {
    writer: RecordingWriter,
    hold: Hold,
    file: PathBuf,
    draft: Draft,
    /// Of the next message.
    seq: u64,
}

impl Recorder {
    /// Starts the recording of a run, in place of an earlier one in `file`.
    pub(crate) fn create(spec: &RunSpec, file: &Path, hold: Hold) -> Result<Self, RecordError> {
        let draft = Draft::beside(file).map_err(|source| RecordError::Io {
            path: file.to_owned(),
            source,
        })?;
        // A page draws by the scene; this file is read by programs.
        let spec = RunSpec {
            // The place of the file does not belong to the episode.
            record: RecordSpec::default(),
            ..spec.clone()
        };
        let preamble = Preamble::new(&spec, &serde_json::json!({}));
        Ok(Self {
            writer: RecordingWriter::create(draft.path(), &preamble)?,
            hold,
            file: file.to_owned(),
            draft,
            seq: 0,
        })
    }

    /// Adds the messages of the present tick.
    pub(crate) fn take(&mut self, sim: &OneProcess) -> Result<(), RecordError> {
        let tick = sim.state().header.tick;
        if self.hold.begins(tick) {
            self.add_state(sim)?;
        }
        if tick.is_multiple_of(DECISION_TICKS) {
            self.add(Channel::Decision, tick, sim.decision())?;
        }
        Ok(())
    }

    /// Adds the last state and gives the file its name.
    pub(crate) fn finish(mut self, sim: &OneProcess) -> Result<(), RecordError> {
        if !self.hold.begins(sim.state().header.tick) {
            self.add_state(sim)?;
        }
        let path = self.file;
        self.writer.finish()?;
        let published = self.draft.publish();
        published.map_err(|source| RecordError::Io { path, source })
    }

    fn add_state(&mut self, sim: &OneProcess) -> Result<(), RecordError> {
        let state = sim.state();
        let mut piece = Box::new(WorldPiece::zeroed());
        let mut pieces = Pieces::whole(state);
        while pieces.write_next(state, &mut piece) {
            self.add(Channel::World, state.header.tick, &*piece)?;
        }
        Ok(())
    }

    fn add<T: Cut>(&mut self, channel: Channel, tick: u64, message: &T) -> Result<(), RecordError> {
        self.seq += 1;
        self.writer.add(&Message {
            channel,
            time_ns: tick * TICK_NS,
            // Wall time would make the bytes of two equal episodes differ.
            publish_ns: tick * TICK_NS,
            seq: self.seq,
            bytes: wire_bytes(message),
        })
    }
}
