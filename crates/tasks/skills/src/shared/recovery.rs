//! Requests for a recovery: a node that cannot do its work does not fail, but sets a key that a
//! guard of the tree's recovery branch reads.

use std::time::Duration;

use behavior::Value;
use behavior::board::{Board, Fault, Out};
use behavior::tree::{BindError, Binder};
use robocell_task::TraceEvent;
use serde::{Deserialize, Serialize};

use super::reserve::CARRIED;
use crate::nodes::Context;
use crate::shared;
use crate::world::World;

/// Prefix of the shared key that requests a recovery of an arm.
const REQUESTED: &str = "recovery_requested:";

/// Access of a node to the shared key `recovery_requested:ROBOT`.
#[derive(Clone, Copy, Debug)]
pub struct Recovery {
    flag: Out<bool>,
}

impl Recovery {
    /// The key of the tree's arm.
    ///
    /// # Errors
    /// Returns a [`BindError`] if the key is declared with another type.
    #[allow(clippy::result_large_err, reason = "happens at load, once")]
    pub fn bind(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let key = Self::key(shared::robot(binder)?.as_str());
        let flag = shared::key(binder, &key, false)?;
        Ok(Self { flag })
    }

    /// The shared key of an arm.
    pub fn key(robot: &str) -> String {
        format!("{REQUESTED}{robot}")
    }

    /// Sets the key; a request is counted and logged once until the key is cleared.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn request(
        &self,
        cx: &mut Context<'_, '_>,
        why: std::fmt::Arguments<'_>,
    ) -> Result<(), Fault> {
        // Nodes request in every tick; without this one loss would count a hundred times a
        // second.
        if cx.read(&self.flag)? {
            return Ok(());
        }
        cx.set(&self.flag, true)?;
        note(cx.world, "recover", why);
        cx.world.job.counters.recoveries += 1;
        Ok(())
    }

    /// Clears the key.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn clear(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        cx.set(&self.flag, false)
    }
}

fn note(world: &mut World<'_>, tag: &str, why: std::fmt::Arguments<'_>) {
    let arm = world.arm_name();
    let out = &mut *world.out;
    out.event(TraceEvent::Recover, format_args!("[{tag}] {arm}: {why}"));
}

/// After missed decisions: an object that the arm carries according to the blackboard and that
/// is no longer in its gripper was lost in the meantime. Nodes observe everything else
/// themselves.
pub(crate) fn reconcile(world: &mut World<'_>, board: &mut Board) {
    let (setup, me, held) = (world.setup, world.arm_name(), world.held());
    let name = |key: &str| key.split_once(':').and_then(|(_, name)| setup.object(name));
    let is_mine = |word: Option<Value>| match word {
        Some(Value::Text(word)) => word.as_str().split_once(':') == Some((CARRIED, me)),
        _ => false,
    };
    let carried = board.keys().enumerate().find_map(|(key, info)| {
        let object = name(&info.name)?;
        is_mine(board.value(key)).then_some(object)
    });
    let Some(lost) = carried else { return };
    if held == carried {
        let name = setup.object_name(lost);
        note(world, "resume", format_args!("{name} is in the gripper"));
        return;
    }
    let name = setup.object_name(lost);
    let why = format_args!("{name} is not in the gripper any more");
    note(world, "resume", why);
    world.job.counters.recoveries += 1;
    if let Some(flag) = board.index(&Recovery::key(me)) {
        board.set(flag, Value::Bool(true));
    }
}

/// Reports repeatedly that a time has passed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Alarm {
    since: Option<Duration>,
}

impl Alarm {
    /// Whether `interval` (s) has passed since the alarm was cleared, or since it was due last.
    pub fn is_due(&mut self, now: Duration, interval: f64) -> bool {
        let since = *self.since.get_or_insert(now);
        let due = has_lasted(since, now, interval);
        if due {
            self.since = Some(now);
        }
        due
    }

    /// Restarts the interval.
    pub fn clear(&mut self) {
        self.since = None;
    }
}

/// Whether `seconds` have passed since `since`.
pub fn has_lasted(since: Duration, now: Duration, seconds: f64) -> bool {
    now.saturating_sub(since).as_secs_f64() >= seconds
}

#[cfg(test)]
mod tests {
    use behavior::Str;
    use cell_model::{Cell, Data};
    use ipc_types::{Wire as _, WorldState};
    use robocell_task::{Job, Observation, Output, PolicyTime};

    use super::*;
    use crate::setup::Setup;

    /// Number of recoveries that are requested if, on the blackboard, the left arm carries the
    /// first cube, and its gripper holds object `held`, from 1.
    fn recoveries(held: u32) -> u32 {
        let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
        let setup = Setup::new(&cell, []);
        let mut board = Board::new();
        let carried = Value::Text(Str::new("carried:left").unwrap());
        let asked = Recovery::key("left");
        for (key, value) in [
            (
                "cube_state:cube_2",
                Value::Text(Str::new("carried:right").unwrap()),
            ),
            ("cube_state:cube_1", carried),
            (asked.as_str(), Value::Bool(false)),
        ] {
            let value_type = value.value_type();
            board.declare(key, value_type, Some(value)).unwrap();
        }
        let mut state = Box::new(WorldState::zeroed());
        (state.arm_count, state.object_count) = (2, 6);
        for object in &mut state.objects[..6] {
            object.flags = ipc_types::world::OBJECT_ENABLED;
        }
        state.arms[0].gripper.held_object = held;
        let observation = Observation::new(&state, &[], PolicyTime::from_ticks(0));
        let (mut job, mut out) = (Job::new(6), Output::default());
        let mut world = World::new(&setup, &observation, &mut job, &mut out, 0);
        reconcile(&mut world, &mut board);
        let flag = board.value(board.index(&asked).unwrap());
        assert_eq!(flag == Some(Value::Bool(true)), job.counters.recoveries > 0);
        job.counters.recoveries
    }

    #[test]
    fn an_object_that_is_not_in_the_gripper_any_more_is_recovered() {
        assert_eq!(recoveries(1), 0);
        assert_eq!(recoveries(0), 1, "lost");
        assert_eq!(recoveries(2), 1, "another one is there");
    }
}
