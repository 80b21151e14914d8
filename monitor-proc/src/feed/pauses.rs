//! Pauses of simulated time by a person who uses no page: `robocell pause`, a script, a program.

use ipc_types::WorldState;
use ipc_types::world::PauseCause;

/// A request of a page and the pause it caused are seen within this time of each other (ns).
const SAME_NS: u64 = 300_000_000;

/// Finds pauses and their ends that no request of a page caused.
#[derive(Debug, Default)]
pub(crate) struct PauseWatch {
    cause: Option<u32>,
    /// A change that a request may still explain: its text, simulated time (s) and clock time.
    change: Option<(&'static str, f64, u64)>,
    /// The newest request of a page, with its clock time.
    request: Option<(String, u64)>,
}

impl PauseWatch {
    /// Takes a state at `now_ns`.
    pub(crate) fn state(&mut self, world: &WorldState, now_ns: u64) {
        let cause = world.panel.pause_cause;
        let Some(before) = self.cause.replace(cause).filter(|before| *before != cause) else {
            return;
        };
        let is = |code, cause| PauseCause::from_code(code) == Some(cause);
        let text = if is(cause, PauseCause::Operator) {
            "pause"
        } else if is(before, PauseCause::Operator) && is(cause, PauseCause::None) {
            "resume"
        } else {
            return;
        };
        let time_s = world.header.sim_time_ns as f64 * 1.0e-9;
        self.change = Some((text, time_s, now_ns));
    }

    /// Takes a request of a page at `now_ns`.
    pub(crate) fn request(&mut self, text: &str, now_ns: u64) {
        self.request = Some((text.to_owned(), now_ns));
    }

    /// The change that no request explains, with its simulated time (s).
    pub(crate) fn take_due(&mut self, now_ns: u64) -> Option<(&'static str, f64)> {
        let due = |&(_, _, at_ns): &(_, _, u64)| now_ns >= at_ns + SAME_NS;
        let (text, time_s, at_ns) = self.change.filter(due)?;
        self.change = None;
        let request = self.request.as_ref();
        let is_told = request
            .is_some_and(|(said, said_ns)| said == text && said_ns.abs_diff(at_ns) <= SAME_NS);
        (!is_told).then_some((text, time_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    fn state(cause: PauseCause) -> WorldState {
        let mut world = WorldState::zeroed();
        world.header.sim_time_ns = 2_000_000_000;
        world.panel.pause_cause = cause as u32;
        world
    }

    #[test]
    fn a_pause_without_a_request_of_a_page_is_due_once() {
        let mut watch = PauseWatch::default();
        watch.state(&state(PauseCause::None), 0);
        watch.state(&state(PauseCause::Operator), 100);
        assert_eq!(watch.take_due(200), None);
        assert_eq!(watch.take_due(100 + SAME_NS), Some(("pause", 2.0)));
        assert_eq!(watch.take_due(200 + SAME_NS), None);
        watch.state(&state(PauseCause::None), SAME_NS * 3);
        assert_eq!(watch.take_due(SAME_NS * 4), Some(("resume", 2.0)));
    }

    #[test]
    fn a_pause_by_a_page_is_told_by_its_request_alone() {
        let mut watch = PauseWatch::default();
        watch.state(&state(PauseCause::None), 0);
        watch.state(&state(PauseCause::Operator), 100);
        watch.request("pause", 200);
        assert_eq!(watch.take_due(100 + SAME_NS), None);
    }
}
