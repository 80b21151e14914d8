//! In lockstep physics does not run ahead of the recorder, so that no tap overflows.

use cell_bus::{Bus, BusError, Latest};
use ipc_types::topic::TopicId;
use ipc_types::{Health, RECORDER_LAG_TICKS};

/// A recorder that sends nothing for this long is not waited for until it sends
/// again (ns): its process was given up, or is killed again and again. On a busy machine
/// a recorder that works may be without a core or a disk for some seconds; after 20 s of
/// the same tick the launcher gives the run up.
const RECORDER_PATIENCE_NS: u64 = 10_000_000_000;

/// Progress of the recorder.
pub(crate) struct RecorderPace {
    progress: Latest<Health>,
    /// Whether physics waits for it.
    is_expected: bool,
    waits_since_ns: Option<u64>,
}

impl RecorderPace {
    /// Expects the recorder from the first tick if it `is_expected` to keep the whole run;
    /// otherwise from its first message.
    pub(crate) fn new(bus: &Bus, is_expected: bool) -> Result<Self, BusError> {
        Ok(Self {
            progress: bus.latest(TopicId::Recorder)?,
            is_expected,
            waits_since_ns: None,
        })
    }

    /// Takes the newest progress of the recorder.
    pub(crate) fn refresh(&mut self) {
        // Any message ends the present wait; a recorder that was given up is expected again.
        if self.progress.refresh() {
            self.is_expected = true;
            self.waits_since_ns = None;
        }
    }

    /// Whether physics of `generation` has to wait with `tick`.
    // Progress under another generation is about ticks that are run again; it does not count.
    pub(crate) fn is_behind(&self, generation: u32, tick: u64) -> bool {
        let progress = self.progress.get();
        let progress = progress.filter(|progress| progress.header.answers(generation));
        self.is_expected
            && progress.is_none_or(|progress| {
                tick.saturating_sub(progress.header.tick) > RECORDER_LAG_TICKS
            })
    }

    /// Accounts for a wait that is still running at `now_ns`; gives the recorder up after the
    /// patience.
    pub(crate) fn waited(&mut self, now_ns: u64) {
        let since_ns = *self.waits_since_ns.get_or_insert(now_ns);
        if now_ns.saturating_sub(since_ns) > RECORDER_PATIENCE_NS {
            self.is_expected = false;
            // Without this a recorder killed again and again would stop the run; a gap is
            // reported.
            self.waits_since_ns = None;
            cell_worker::warn(format_args!(
                "the recorder has sent nothing for {} s: physics continues without it, and \
                 the recording will have gaps",
                RECORDER_PATIENCE_NS / 1_000_000_000
            ));
        }
    }
}
