//! The health of a process, at 100 Hz.

use crate::Text;
use crate::header::Header;
use crate::validate::{Check, Invalid, Validate, code};
use crate::wire::wire;

/// Bytes of a note.
// One sentence with its numbers; a longer note is cut with a mark.
pub const NOTE_BYTES: usize = 192;

code! {
    /// Scheduling a process was granted.
    pub enum Scheduling {
        /// The normal class.
        Other = 0,
        /// Real-time, first in first out.
        Fifo = 1,
    }
}

wire! {
    /// Health of one process. A frozen `cycles` means it hangs.
    pub struct Health {
        /// Header.
        pub header: Header,
        /// Process id.
        pub pid: u32,
        /// [`Scheduling`].
        pub scheduling: u32,
        /// Cycles run since the start of the process.
        pub cycles: u64,
        /// Missed cycles. Of a controller: `missed_cycles` of its [`ArmStatus`](crate::ArmStatus).
        /// Of physics: `overruns` of the [`WorldState`](crate::WorldState). 0 of all others, which
        /// do not need every tick.
        pub missed_cycles: u64,
        /// Messages refused by validation.
        pub rejected: u64,
        /// Messages of an older generation.
        pub fenced: u64,
        /// Cycles per second over the last second.
        pub rate_hz: f64,
        /// Lateness of the cycle start over the last second, nanoseconds: p50.
        pub lateness_p50_ns: f64,
        /// p99 of the same.
        pub lateness_p99_ns: f64,
        /// Maximum of the same.
        pub lateness_max_ns: f64,
        /// Time a cycle takes, p50 over the last second, nanoseconds.
        pub body_p50_ns: f64,
        /// p99 of the same.
        pub body_p99_ns: f64,
        /// Age of the state when the newest command was applied, nanoseconds,
        /// p50 over the last second (physics) ; 0 elsewhere.
        pub apply_age_p50_ns: f64,
        /// p99 of the same.
        pub apply_age_p99_ns: f64,
        /// Events since the start of the process of which an incident is kept; the note has the
        /// newest.
        pub incidents: u64,
        /// Newest trouble in words, empty if none. A fault starts with [`FAULT`].
        pub note: Text<NOTE_BYTES>,
    }
}

/// Start of a note that people must see at once and after the run: the process works, but a
/// promise of the cell does not hold.
pub const FAULT: &str = "fault: ";

impl Health {
    /// The fault it reports.
    pub fn fault(&self) -> Option<&str> {
        self.note.as_str().strip_prefix(FAULT)
    }
}

impl Validate for Health {
    fn validate(&self) -> Result<(), Invalid> {
        Check::code(
            "scheduling",
            self.scheduling,
            Scheduling::from_code(self.scheduling).is_some(),
        )?;
        let values = [
            self.rate_hz,
            self.lateness_p50_ns,
            self.lateness_p99_ns,
            self.lateness_max_ns,
            self.body_p50_ns,
            self.body_p99_ns,
            self.apply_age_p50_ns,
            self.apply_age_p99_ns,
        ];
        // Figures for people: no control depends on them, so the limit only rejects garbage.
        Check::within("figures", &values, 1.0e15)?;
        self.note.check("note")
    }
}
