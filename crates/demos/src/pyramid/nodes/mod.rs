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

use behavior::board::Fault;
use ipc_types::GripperGoal;
use serde::{Deserialize, Serialize};

use crate::pyramid::center::Center;
use crate::pyramid::host::Context;

/// Seconds as a length of time; the longest where they are none.
fn seconds(value: f64) -> Duration {
    Duration::try_from_secs_f64(value).unwrap_or(Duration::MAX)
}

/// An arm that waits for the centre longer than this goes out of the way: the
/// one that works there may need the room (s).
const PATIENCE_S: f64 = 2.0;

/// A node's turn to work in the centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Turn {
    /// Since when another arm owns the centre.
    barred: Option<Duration>,
}

impl Turn {
    /// Takes the centre; whether this arm owns it. While it does not, the arm
    /// waits, with goals under `key`. A lock that was lost while the arm was
    /// away is taken again.
    fn comes(
        &mut self,
        center: &Center,
        key: u64,
        cx: &mut Context<'_, '_>,
    ) -> Result<bool, Fault> {
        let mine = center.take(cx)?;
        if mine {
            self.barred = None;
        } else {
            self.wait(key, cx);
        }
        Ok(mine)
    }

    /// Stays, and goes out of the way after a while.
    fn wait(&mut self, key: u64, cx: &mut Context<'_, '_>) {
        let began = *self.barred.get_or_insert(cx.now);
        if cx.now.saturating_sub(began) >= seconds(PATIENCE_S)
            && let Some(rest) = cx.world.rest()
        {
            cx.world.go(key, rest, GripperGoal::Keep);
        }
    }
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
