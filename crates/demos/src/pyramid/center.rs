//! The centre, where the pyramid stands: one arm at a time works there.
//!
//! The lock has an owner and a lease. The policy renews the lease while the
//! owner's tree runs and its arm is alive, and takes the lock away when it runs
//! out: an owner that dies does not block the other for ever.

use behavior::board::{Access, Board, Fault, Out};
use behavior::tree::{BindError, Binder};
use behavior::{Str, Value};

use super::host::Context;
use super::keys;

/// Length of a lease (s).
pub(super) const LEASE_S: f64 = 0.5;

/// A node's hold of the lock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Center {
    me: Str,
    owner: Out<Str>,
    lease: Out<f64>,
}

impl Center {
    pub(super) fn bind(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            me: keys::robot(binder)?,
            owner: keys::shared(binder, keys::CENTER_OWNER, Str::EMPTY, Access::Write)?,
            lease: keys::shared(binder, keys::CENTER_LEASE, 0.0, Access::Write)?,
        })
    }

    /// Whether the arm must not go there: another one owns the centre, or it
    /// is free and this arm does not answer, so that it would block it.
    pub(super) fn is_closed(&self, cx: &Context<'_, '_>) -> Result<bool, Fault> {
        let owner = cx.read(&self.owner)?;
        Ok(owner != self.me && (!owner.is_empty() || !cx.world.is_alive()))
    }

    /// Takes the lock if it is free; whether this arm has it now.
    pub(super) fn take(&self, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        if self.is_closed(cx)? {
            return Ok(false);
        }
        if cx.read(&self.owner)? != self.me {
            cx.set(&self.owner, self.me)?;
            cx.set(&self.lease, cx.now.as_secs_f64() + LEASE_S)?;
        }
        Ok(true)
    }

    /// Gives the lock back, if this arm has it.
    pub(super) fn release(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        if cx.read(&self.owner)? == self.me {
            cx.set(&self.owner, Str::EMPTY)?;
            cx.set(&self.lease, 0.0)?;
        }
        Ok(())
    }
}

/// The lock as the policy sees it, from outside of the trees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lock {
    owner: usize,
    lease: usize,
}

impl Lock {
    /// The lock on `board`, `None` where no tree has one.
    pub(super) fn find(board: &Board) -> Option<Self> {
        Some(Self {
            owner: board.index(keys::CENTER_OWNER)?,
            lease: board.index(keys::CENTER_LEASE)?,
        })
    }

    /// Name of the owner, empty for none.
    pub(super) fn owner(self, board: &Board) -> Str {
        match board.value(self.owner) {
            Some(Value::Text(owner)) => owner,
            _ => Str::EMPTY,
        }
    }

    /// Lengthens the lease of an owner that `is_at_work`; takes the lock from
    /// one whose lease ran out at `now` (s). Gives the name of who lost it.
    pub(super) fn watch(self, board: &mut Board, now: f64, is_at_work: bool) -> Option<Str> {
        let owner = self.owner(board);
        if owner.is_empty() {
            return None;
        }
        if is_at_work {
            board.set(self.lease, Value::Number(now + LEASE_S));
            return None;
        }
        let until = match board.value(self.lease) {
            Some(Value::Number(until)) => until,
            _ => 0.0,
        };
        (now >= until).then(|| {
            self.free(board);
            owner
        })
    }

    /// Takes the lock from whoever has it.
    pub(super) fn free(self, board: &mut Board) {
        board.set(self.owner, Value::Text(Str::EMPTY));
        board.set(self.lease, Value::Number(0.0));
    }
}
