//! The first start of a cell waits for its page for some seconds, so that an operator sees the
//! whole job after opening the link.

use std::io::IsTerminal as _;
use std::time::Duration;

use cell_rt::clock::monotonic_ns;
use cell_run::spec::{PageSecrets, RunSpec};
use ipc_types::WorldState;
use ipc_types::operator::OperatorAction;
use ipc_types::world::{FLAG_PAUSED, PauseCause};
use supervisor::run::LiveCell;

use crate::args::RunArgs;

/// Longest wait for a page that is not opened.
pub(super) const PATIENCE: Duration = Duration::from_secs(10);
/// From the use of the link to the first picture in a browser.
const LOADING: Duration = Duration::from_secs(2);
/// Between two looks at the link, and between two requests.
const LOOK: Duration = Duration::from_millis(250);
/// From this tick on physics resumes from a snapshot when it is restarted (1 ms each).
const SETTLED_TICKS: u64 = 3000;

/// Whether the start of this run waits: a page that is missing is not looked at, and a
/// script or a pipe has its own time.
pub(super) fn is_wanted(args: &RunArgs, spec: &RunSpec) -> bool {
    let has_page = spec.page.as_ref().is_some_and(|page| page.hint.is_empty());
    let is_attended = args.open || std::io::stdout().is_terminal();
    let has_own_time = args.paused || args.until_done || args.json || !spec.script.is_empty();
    has_page && is_attended && !has_own_time && spec.real_time
}

/// Resumes a cell that was started paused, once its page is open.
#[derive(Debug, Default)]
pub(super) struct PageWait {
    clock: Clock,
    looked_ns: u64,
    is_over: bool,
}

impl PageWait {
    /// One look at a cell whose processes are ready.
    pub(super) fn look(&mut self, live: &mut LiveCell) {
        let now_ns = monotonic_ns();
        if self.is_over || now_ns < self.looked_ns + nanoseconds(LOOK) {
            return;
        }
        self.looked_ns = now_ns;
        let Some(state) = live.watch().state() else {
            return;
        };
        if !waits(state) {
            // Until then a restart of physics starts paused again, and has to be resumed again.
            self.is_over = state.header.tick > SETTLED_TICKS;
        } else if self.clock.has_passed(now_ns, is_open(live)) {
            live.ask(OperatorAction::Resume);
        }
    }
}

/// Paused since its start. Another cause is the operator's: he resumes it.
fn waits(state: &WorldState) -> bool {
    state.has(FLAG_PAUSED) && state.panel.pause_cause == PauseCause::Start.code()
}

/// Whether a browser used the link: the monitor replaces its token then.
fn is_open(live: &LiveCell) -> bool {
    let Some(page) = &live.spec().page else {
        return false;
    };
    let now = PageSecrets::load(&page.secrets);
    let first = live.secrets();
    now.is_ok_and(|now| first.is_some_and(|first| first.operator_token != now.operator_token))
}

/// When the wait is over.
#[derive(Debug, Default)]
struct Clock {
    began_ns: Option<u64>,
    opened_ns: Option<u64>,
}

impl Clock {
    fn has_passed(&mut self, now_ns: u64, is_open: bool) -> bool {
        let began_ns = *self.began_ns.get_or_insert(now_ns);
        if is_open {
            self.opened_ns.get_or_insert(now_ns);
        }
        let is_loaded = self
            .opened_ns
            .is_some_and(|opened_ns| now_ns >= opened_ns + nanoseconds(LOADING));
        // A page that was opened late still has its time to load.
        is_loaded || (self.opened_ns.is_none() && now_ns >= began_ns + nanoseconds(PATIENCE))
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn the_wait_ends_when_the_page_is_loaded_or_after_ten_seconds() {
        let mut opened = Clock::default();
        assert!(!opened.has_passed(SECOND, false));
        assert!(!opened.has_passed(3 * SECOND, true));
        assert!(!opened.has_passed(4 * SECOND, true));
        assert!(opened.has_passed(5 * SECOND, true));
        let mut alone = Clock::default();
        assert!(!alone.has_passed(SECOND, false));
        assert!(!alone.has_passed(10 * SECOND, false));
        assert!(alone.has_passed(11 * SECOND, false));
        let mut late = Clock::default();
        assert!(!late.has_passed(SECOND, false));
        assert!(!late.has_passed(10 * SECOND, true));
        assert!(!late.has_passed(11 * SECOND, true), "it is loaded first");
        assert!(late.has_passed(12 * SECOND, true));
    }
}
