//! The link of the page, told when the page listens: before that a browser is refused.

use std::time::Duration;

use cell_rt::clock::monotonic_ns;
use supervisor::run::LiveCell;

use crate::{page, say};

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(50);
/// The monitor tries for five seconds to listen.
const PATIENCE: Duration = Duration::from_secs(10);

/// Tells the link once.
#[derive(Debug)]
pub(super) struct PageLink {
    tells: bool,
    opens: bool,
    is_told: bool,
    looked_ns: u64,
    /// When all processes were ready.
    ready_ns: Option<u64>,
}

impl PageLink {
    /// Prints the link where it `tells`, and hands it to a browser where it `opens`.
    pub(super) fn new(tells: bool, opens: bool) -> Self {
        Self {
            tells,
            opens,
            is_told: !tells && !opens,
            looked_ns: 0,
            ready_ns: None,
        }
    }

    /// One look at the page; whether there is nothing more to tell.
    pub(super) fn look(&mut self, live: &LiveCell) -> bool {
        let Some(page) = &live.spec().page else {
            return true;
        };
        let now_ns = monotonic_ns();
        if self.is_told || now_ns < self.looked_ns + nanoseconds(LOOK) {
            return self.is_told;
        }
        self.looked_ns = now_ns;
        if page::listens(page) {
            if let Some(secrets) = live.secrets().filter(|_| self.tells) {
                page::lines(page, secrets).iter().for_each(say::line);
            }
            if self.opens {
                page::open(Some(page));
            }
            self.is_told = true;
        } else if live.is_ready() {
            let ready_ns = *self.ready_ns.get_or_insert(now_ns);
            if now_ns >= ready_ns + nanoseconds(PATIENCE) {
                say::warn(format_args!(
                    "no page listens at {}; `robocell logs monitor` says why, and `robocell status` has the \
                     link",
                    page.address
                ));
                self.is_told = true;
            }
        }
        self.is_told
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
