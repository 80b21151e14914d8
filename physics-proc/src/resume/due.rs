//! When a state is due to be saved. Pure.

use ipc_types::DECISION_TICKS;

/// Ticks between two saved states. A kill must not take physics back by more than
/// [`MAX_LOST_TICKS`]: the other half is the time for writing.
const PERIOD_TICKS: u64 = 500;
/// Ticks between two saved states while people operate the cell.
// A fifth of the period: a request that was obeyed is rarely repeated, and a page in use costs
// at most ten states a second.
const OPERATED_TICKS: u64 = 100;
/// Largest age of the state that physics resumes from (ticks).
// The promise of one second of simulated time; a longer loss is reported.
pub(crate) const MAX_LOST_TICKS: u64 = 1000;

/// State of the operator's switches, as far as it does not change with time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Switches {
    pub(crate) paused: bool,
    /// Requests obeyed so far.
    pub(crate) requests: u64,
}

/// Which state was saved last, or is being written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Due {
    /// Its tick; `None` before the first.
    pub(crate) tick: Option<u64>,
    pub(crate) switches: Switches,
}

impl Due {
    /// Whether the state of `tick` has to be saved. The task keeps its checkpoint for a
    /// state when it decides on it, so ticks without decisions are left out; a cell that
    /// is paused has no other.
    // The first state is saved at once: before it a kill would start the scene again.
    pub(crate) fn is_due(&self, tick: u64, switches: Switches) -> bool {
        let Some(saved) = self.tick else {
            return true;
        };
        // `tick < saved`: time was set back, and the saved state is of a future that will not
        // happen. While paused the tick is constant, so its age would never make a state due.
        let changed = switches != self.switches;
        if switches.paused || tick < saved {
            return changed || tick != saved;
        }
        let age = tick - saved;
        // Only a tick with a decision has a checkpoint of the task that belongs to it.
        let is_old = age >= PERIOD_TICKS || (changed && age >= OPERATED_TICKS);
        is_old && tick.is_multiple_of(DECISION_TICKS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNS: Switches = Switches {
        paused: false,
        requests: 0,
    };

    fn due(saved: u64) -> Due {
        Due {
            tick: Some(saved),
            switches: RUNS,
        }
    }

    #[test]
    fn the_first_state_is_due_and_then_one_every_half_second() {
        let first = Due {
            tick: None,
            ..due(0)
        };
        assert!(first.is_due(0, RUNS));
        let ticks = (0..2_000).filter(|tick| due(0).is_due(*tick, RUNS));
        assert_eq!(ticks.min(), Some(500));
        let latest = (0..PERIOD_TICKS).map(|saved| {
            let mut ticks = saved..saved + 2 * PERIOD_TICKS;
            let due = ticks.find(|tick| due(saved).is_due(*tick, RUNS));
            due.unwrap() - saved
        });
        assert!(latest.max().unwrap() < PERIOD_TICKS + DECISION_TICKS);
    }

    #[test]
    fn a_request_and_a_pause_make_a_state_due_sooner() {
        let operated = Switches {
            paused: false,
            requests: 1,
        };
        let ticks = (0..2_000).filter(|tick| due(0).is_due(*tick, operated));
        assert_eq!(ticks.min(), Some(OPERATED_TICKS));
        let paused = Switches {
            paused: true,
            requests: 1,
        };
        assert!(due(0).is_due(3, paused), "at any tick");
        let saved = Due {
            tick: Some(3),
            switches: paused,
        };
        assert!(!saved.is_due(3, paused), "and once");
    }
}
