//! The values of signals, out of a recording.

use cell_record::{Channel, Entry, RecordError, Recording};
use evaluation::charts::Line;
use ipc_types::{ArmStatus, Decision, Wire, WorldPiece, WorldState};

use super::signals::{Signal, Source};

/// Objects at rest are recorded at every tenth tick: a look this much earlier finds all (s).
const LEAD_S: f64 = 0.05;

/// A line for each of `signals`, of the times from `from_s` to `to_s`.
pub(super) fn lines(
    recording: &Recording,
    signals: &[Signal],
    (from_s, to_s): (f64, f64),
) -> Result<Vec<Line>, RecordError> {
    let mut reader = Reader {
        signals,
        lines: signals.iter().map(line).collect(),
        from_s,
        state: Box::new(WorldState::zeroed()),
        whole: false,
        waiting: false,
        decision: None,
    };
    for entry in recording.history((from_s - LEAD_S).max(0.0), to_s) {
        reader.take(&entry?)?;
    }
    // A state is sampled when a piece of a later tick arrives: none follows the last one.
    reader.sample_state();
    Ok(reader.lines)
}

fn line(signal: &Signal) -> Line {
    Line {
        name: signal.name.clone(),
        points: Vec::new(),
    }
}

struct Reader<'a> {
    signals: &'a [Signal],
    lines: Vec<Line>,
    from_s: f64,
    state: Box<WorldState>,
    /// Whether `state` has all objects.
    whole: bool,
    /// Whether `state` was not sampled yet: the rest of it may follow in another piece.
    waiting: bool,
    decision: Option<Box<Decision>>,
}

impl Reader<'_> {
    fn take(&mut self, entry: &Entry) -> Result<(), RecordError> {
        match entry.channel {
            Channel::World => {
                let piece = entry.read::<WorldPiece>()?;
                if piece.state.tick != self.state.header.tick {
                    self.sample_state();
                }
                self.whole |= piece.all_objects == 1 && piece.piece == 0;
                piece.put(&mut self.state);
                self.waiting = true;
            }
            Channel::Decision => self.decision = Some(Box::new(entry.read()?)),
            Channel::Status(arm) if self.wants_status(arm) => {
                let status = entry.read::<ArmStatus>()?;
                self.sample_status(arm, &status, entry.time_s());
            }
            _ => {}
        }
        Ok(())
    }

    fn wants_status(&self, arm: u8) -> bool {
        let of_arm = |s: &Signal| matches!(s.source, Source::Status(of, _) if of == arm);
        self.signals.iter().any(of_arm)
    }

    fn sample_state(&mut self) {
        let at = self.state.header.sim_time_ns as f64 / 1.0e9;
        if !std::mem::take(&mut self.waiting) || !self.whole || at < self.from_s {
            return;
        }
        for (signal, line) in self.signals.iter().zip(&mut self.lines) {
            if matches!(signal.source, Source::World(_)) {
                line.points.push((at, signal.of_world(&self.state)));
            }
        }
    }

    fn sample_status(&mut self, arm: u8, status: &ArmStatus, at: f64) {
        if at < self.from_s {
            return;
        }
        for (signal, line) in self.signals.iter().zip(&mut self.lines) {
            if matches!(signal.source, Source::Status(of, _) if of == arm) {
                let value = signal.of_status(status, &self.state, self.decision.as_deref());
                line.points.push((at, value));
            }
        }
    }
}
