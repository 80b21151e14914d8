//! The engine's own leaves in files.

use crate::board::{Board, Fault, Scope, Slot};
use crate::status::Status;
use crate::tree::{Cx, Host, Leaf, Test};
use crate::value::Value;

/// Succeeds where a test of a key holds.
pub(super) struct CheckKey {
    pub slot: Slot,
    pub test: Test,
}

impl<H: Host> Leaf<H> for CheckKey {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, H>) -> Result<Status, Fault> {
        let value = value(cx.local, cx.shared, self.slot);
        Ok(if holds(self.test, value) {
            Status::Success
        } else {
            Status::Failure
        })
    }
}

/// The source of a written value.
pub(super) enum From {
    Literal(Value),
    Key(Slot),
}

/// Writes a key and succeeds.
pub(super) struct SetKey {
    pub slot: Slot,
    pub from: From,
}

impl<H: Host> Leaf<H> for SetKey {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, H>) -> Result<Status, Fault> {
        let written = match self.from {
            From::Literal(value) => value,
            From::Key(slot) => value(cx.local, cx.shared, slot).ok_or(Fault::Unset(slot))?,
        };
        if cx.board(self.slot.scope).set(self.slot.index, written) {
            Ok(Status::Success)
        } else {
            Err(Fault::NotFinite(self.slot))
        }
    }
}

fn value(local: &Board, shared: &Board, slot: Slot) -> Option<Value> {
    match slot.scope {
        Scope::Local => local.value(slot.index),
        Scope::Shared => shared.value(slot.index),
    }
}

fn holds(test: Test, value: Option<Value>) -> bool {
    let number = match value {
        Some(Value::Integer(integer)) => Some(integer as f64),
        Some(Value::Number(number)) => Some(number),
        _ => None,
    };
    match test {
        Test::IsSet => value.is_some(),
        Test::IsUnset => value.is_none(),
        Test::Equals(wanted) => value == Some(wanted),
        Test::Differs(other) => value != Some(other),
        Test::Below(limit) => number.is_some_and(|number| number < limit),
        Test::Above(limit) => number.is_some_and(|number| number > limit),
    }
}
