//! The blackboard keys of the trees, and how nodes get a hold of them.

use behavior::Str;
use behavior::board::{Access, Fault, Out, Scope};
use behavior::tree::{BindError, Binder};
use behavior::value::{Plain, Set};
use robocell_task::TraceEvent;

use super::host::Context;

/// Local: name of the cube the tree works at, empty for none.
pub(super) const CURRENT_CUBE: &str = "current_cube";
/// Local: name of the shared key that asks for a recovery. Like
/// [`COMPLETION_KEY`] and [`INITIALIZED`] for whoever looks at the board; no
/// node reads it.
pub(super) const RECOVERY_KEY: &str = "recovery_key";
/// Local: name of the shared key that tells the stack is complete.
pub(super) const COMPLETION_KEY: &str = "completion_key";
/// Local: where the cube was when its targets were made (m).
pub(super) const PICKUP_REFERENCE: &str = "pickup_reference";
/// Local: the robot was found and its keys are set.
pub(super) const INITIALIZED: &str = "initialized";
/// Local: where the arm rests, a pose of the TCP.
pub(super) const REST: &str = "rest";
/// Local: the cube goes out of the way, not onto the stack.
pub(super) const ASIDE: &str = "aside";
/// Local: the seven targets, poses of the TCP, the last one of the cube.
pub(super) const TARGETS: [&str; 7] = [
    "approach",
    "grasp",
    "lift",
    "place_approach",
    "place",
    "retract",
    "object_goal",
];

/// Shared: name of the arm that owns the centre, empty for none.
pub(super) const CENTER_OWNER: &str = "center_owner";
/// Shared: policy time until which it owns it (s).
pub(super) const CENTER_LEASE: &str = "center_lease";

/// Shared: what happens to a cube.
pub(super) fn cube_state(cube: &str) -> String {
    format!("cube_state:{cube}")
}

/// Beginning of the shared keys with the cubes of a stack.
pub(super) const PLACED: &str = "placed:";

/// Shared: the cubes of the stack of `robot`.
pub(super) fn placed(robot: &str) -> String {
    format!("{PLACED}{robot}")
}

/// Shared: the tree of `robot` shall look after its cube.
pub(super) fn recovery_requested(robot: &str) -> String {
    format!("recovery_requested:{robot}")
}

/// Shared: the stack of `robot` is complete.
pub(super) fn stack_complete(robot: &str) -> String {
    format!("stack_complete:{robot}")
}

/// A key of the tree's own board, declared here unless the file did.
pub(super) fn local<T: Plain>(
    binder: &mut Binder<'_>,
    key: &str,
    default: Option<T>,
    access: Access,
) -> Result<Out<T>, BindError> {
    binder.writes(Scope::Local, key, default, access)
}

/// A key of the shared board, declared here unless the file did.
pub(super) fn shared<T: Plain>(
    binder: &mut Binder<'_>,
    key: &str,
    default: T,
    access: Access,
) -> Result<Out<T>, BindError> {
    binder.writes(Scope::Shared, key, Some(default), access)
}

/// Name of the tree's arm.
pub(super) fn robot(binder: &Binder<'_>) -> Result<Str, BindError> {
    let name = binder.text_constant("robot")?;
    Str::new(name).ok_or_else(|| BindError::Host(format!("'{name}' is no name of an arm")))
}

/// Asks for a recovery.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recovery {
    flag: Out<bool>,
}

impl Recovery {
    pub(super) fn bind(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let key = recovery_requested(robot(binder)?.as_str());
        let flag = shared(binder, &key, false, Access::Write)?;
        Ok(Self { flag })
    }

    /// Raises the flag; counted and logged once until it is lowered.
    pub(super) fn request(
        &self,
        cx: &mut Context<'_, '_>,
        why: std::fmt::Arguments<'_>,
    ) -> Result<(), Fault> {
        if cx.read(&self.flag)? {
            return Ok(());
        }
        cx.set(&self.flag, true)?;
        cx.world.counters.recoveries += 1;
        let name = cx.world.name();
        cx.world
            .out
            .event(TraceEvent::Recover, format_args!("[recover] {name}: {why}"));
        Ok(())
    }

    pub(super) fn clear(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        cx.set(&self.flag, false)
    }
}

/// The set of the arm's placed cubes, to read and write.
pub(super) fn placed_set(binder: &mut Binder<'_>) -> Result<Out<Set>, BindError> {
    let key = placed(robot(binder)?.as_str());
    shared(binder, &key, Set::default(), Access::Write)
}
