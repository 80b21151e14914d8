//! The eleven node types, one file each.

pub(super) mod acquire;
pub(super) mod calibrate;
pub(super) mod check_at_target;
pub(super) mod check_complete;
pub(super) mod check_lifted;
pub(super) mod gripper;
pub(super) mod mark_placed;
pub(super) mod move_to;
pub(super) mod recover;
pub(super) mod release_center;
pub(super) mod reset;
mod watch;

use std::time::Duration;

use behavior::Status;
use ipc_types::GripperGoal;
use serde::{Deserialize, Serialize};

use crate::pyramid::host::Context;

/// Seconds as a length of time; the longest where they are none.
fn seconds(value: f64) -> Duration {
    Duration::try_from_secs_f64(value).unwrap_or(Duration::MAX)
}

/// An arm that waits for the centre longer than this goes out of the way: the
/// one that works there may need the room (s).
const PATIENCE_S: f64 = 2.0;

/// What a node does that waits for the centre since `since`.
fn wait(since: &mut Option<Duration>, key: u64, cx: &mut Context<'_, '_>) -> Status {
    let began = *since.get_or_insert(cx.now);
    if cx.now.saturating_sub(began) >= seconds(PATIENCE_S)
        && let Some(rest) = cx.world.rest()
    {
        cx.world.go(key, rest, GripperGoal::Keep);
    }
    Status::Running
}

/// Says when something has lasted, again and again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Alarm {
    since: Option<Duration>,
}

impl Alarm {
    /// Whether `interval` (s) has passed since the alarm was cleared or since
    /// this was true last.
    fn is_due(&mut self, now: Duration, interval: f64) -> bool {
        let since = *self.since.get_or_insert(now);
        let due = now.saturating_sub(since) >= seconds(interval);
        if due {
            self.since = Some(now);
        }
        due
    }

    fn clear(&mut self) {
        self.since = None;
    }
}
