//! A zone in which one arm works at a time.
//!
//! It has an owner and a lease. The policy renews the lease while the owner's tree runs and its
//! arm is alive, and frees the zone when the lease has expired: an owner that dies does not
//! block the others for ever.
//!
//! What can go wrong: two arms in one zone collide, and a zone without a living owner stops the
//! job. The rules: only [`Lease::take`] sets an owner, and only for a free zone; an arm that
//! does not answer cannot take one; only the policy, which sees all arms, expires a lease. A
//! change must keep owner and lease on the shared blackboard, where a restored task finds them.

use behavior::board::{Board, Fault, Out};
use behavior::tree::{BindError, Binder};
use behavior::{Str, Value};
use robocell_task::{ArmIntent, PolicyTime};
use serde::{Deserialize, Serialize};

use crate::nodes::Context;
use crate::progress::Step;
use crate::refusal::ZoneWait;
use crate::shared;
use crate::world::World;

/// Length of a lease (s): 50 decisions.
const LEASE_S: f64 = 0.5;
/// Time after which an arm that waits for a zone gives way (s): the owner may need the room.
const PATIENCE_S: f64 = 2.0;
/// Suffix of the shared key with the name of a zone's owner, empty for none.
const OWNER: &str = "_owner";
/// Suffix of the shared key with the policy time at which its lease expires (s).
const LEASE: &str = "_lease";

/// Access of a node to a zone.
#[derive(Clone, Copy, Debug)]
pub struct Lease {
    zone: Str,
    me: Str,
    owner: Out<Str>,
    until: Out<f64>,
}

impl Lease {
    /// The lease of the zone `zone`, with the shared keys `ZONE_owner` and `ZONE_lease`.
    ///
    /// # Errors
    /// Returns a [`BindError`] if the keys are declared with other types.
    #[allow(clippy::result_large_err, reason = "happens at load, once")]
    pub fn bind(binder: &mut Binder<'_>, zone: &str) -> Result<Self, BindError> {
        Ok(Self {
            // A longer name is not bound: its keys are too long as well.
            zone: Str::new(zone).unwrap_or(Str::EMPTY),
            me: shared::robot(binder)?,
            owner: shared::key(binder, &format!("{zone}{OWNER}"), Str::EMPTY)?,
            until: shared::key(binder, &format!("{zone}{LEASE}"), 0.0)?,
        })
    }

    /// Whether the arm must not enter: another arm owns the zone, or it is free and this arm
    /// does not answer, so that it would block it.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn is_closed(&self, cx: &Context<'_, '_>) -> Result<bool, Fault> {
        let owner = cx.read(&self.owner)?;
        Ok(owner != self.me && (!owner.is_empty() || !cx.world.is_alive()))
    }

    /// Whether this arm owns the zone.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn is_mine(&self, cx: &Context<'_, '_>) -> Result<bool, Fault> {
        Ok(cx.read(&self.owner)? == self.me)
    }

    /// Takes the zone if it is free; returns whether this arm owns it.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn take(&self, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        if self.is_closed(cx)? {
            return Ok(false);
        }
        // An owner that takes it again does not extend the lease: that is the policy's part.
        if cx.read(&self.owner)? != self.me {
            cx.set(&self.owner, self.me)?;
            cx.set(&self.until, cx.now.as_secs_f64() + LEASE_S)?;
        }
        Ok(true)
    }

    /// Releases the zone if this arm owns it.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn release(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        if cx.read(&self.owner)? == self.me {
            cx.set(&self.owner, Str::EMPTY)?;
            cx.set(&self.until, 0.0)?;
        }
        Ok(())
    }
}

/// The turn of a node to work in a zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Turn {
    /// The wait while another arm owns the zone.
    step: Step,
    /// The log has it.
    told: bool,
}

impl Turn {
    /// Takes the zone; returns whether this arm owns it. While it does not, the arm waits. A
    /// zone that was lost in the meantime is taken again.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn comes(&mut self, lease: &Lease, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        let mine = lease.take(cx)?;
        if mine {
            *self = Self::default();
            return Ok(true);
        }
        self.wait_for(lease, cx)?;
        Ok(false)
    }

    /// Holds, and after a while moves to the arm's rest pose, and reports the wait.
    ///
    /// # Errors
    /// [`Fault`] of the blackboard.
    pub fn wait_for(&mut self, lease: &Lease, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        let (zone, owner) = (lease.zone, cx.read(&lease.owner)?);
        let world = &mut *cx.world;
        self.wait(world);
        let since = self.step.began;
        // A free zone is closed to an arm that does not answer; that is reported elsewhere.
        let is_long = world.now().since(since) >= PolicyTime::from_seconds(PATIENCE_S);
        if is_long && !owner.is_empty() {
            world.zone_wait = Some(ZoneWait { zone, owner });
            world.note_wait(since, format_args!("zone '{zone}', which {owner} owns"));
            if !std::mem::replace(&mut self.told, true) {
                let arm = world.arm_name();
                let line = format_args!("[wait] {arm} waits for zone '{zone}', which {owner} owns");
                world.out.log(line);
            }
        }
        Ok(())
    }

    fn wait(&mut self, world: &mut World<'_>) {
        let lasted = world.begin(&mut self.step);
        match world.arm_setup() {
            Some(arm) if lasted >= PolicyTime::from_seconds(PATIENCE_S) => {
                world.act(ArmIntent::pose(self.step.key, arm.wait));
            }
            _ => world.hold(),
        }
    }
}

/// All zones of a blackboard, as the policy sees them from outside of the trees.
#[derive(Clone, Debug, Default)]
pub(crate) struct Zones(Vec<Zone>);

#[derive(Clone, Debug)]
struct Zone {
    name: String,
    owner: usize,
    until: usize,
}

impl Zones {
    /// The zones of `board`.
    pub(crate) fn of(board: &Board) -> Self {
        let zone = |(owner, key): (usize, &behavior::board::KeyInfo)| {
            let name = key.name.strip_suffix(OWNER)?.to_owned();
            let until = board.index(&format!("{name}{LEASE}"))?;
            Some(Zone { name, owner, until })
        };
        Self(board.keys().enumerate().filter_map(zone).collect())
    }

    /// Renews the leases of owners that work at `now` (s), and frees zones whose lease has
    /// expired; `lost` is called with the zone and its owner.
    pub(crate) fn watch(
        &self,
        board: &mut Board,
        now: f64,
        works: impl Fn(&str) -> bool,
        mut lost: impl FnMut(&str, Str),
    ) {
        for zone in &self.0 {
            let owner = zone.owner(board);
            if owner.is_empty() {
                continue;
            }
            // The time is that of the policy, so a pause of the task expires no lease.
            if works(owner.as_str()) {
                board.set(zone.until, Value::Number(now + LEASE_S));
                continue;
            }
            let until = match board.value(zone.until) {
                Some(Value::Number(until)) => until,
                _ => 0.0,
            };
            if now >= until {
                zone.free(board);
                lost(&zone.name, owner);
            }
        }
    }

    /// Frees all zones of an arm whose tree has ended.
    pub(crate) fn leave(&self, board: &mut Board, arm: &str) {
        for zone in &self.0 {
            if zone.owner(board).as_str() == arm {
                zone.free(board);
            }
        }
    }
}

impl Zone {
    fn owner(&self, board: &Board) -> Str {
        match board.value(self.owner) {
            Some(Value::Text(owner)) => owner,
            _ => Str::EMPTY,
        }
    }

    fn free(&self, board: &mut Board) {
        board.set(self.owner, Value::Text(Str::EMPTY));
        board.set(self.until, Value::Number(0.0));
    }
}

#[cfg(test)]
mod tests {
    use behavior::value::ValueType;

    use super::*;

    #[test]
    fn the_lease_of_an_owner_that_does_not_work_expires() {
        let mut board = Board::new();
        let text = |text| Value::Text(Str::new(text).unwrap());
        let owner = board.declare("press_owner", ValueType::Text, Some(text("left")));
        board
            .declare("press_lease", ValueType::Number, Some(Value::Number(0.0)))
            .unwrap();
        let zones = Zones::of(&board);
        let mut lost = Vec::new();
        for (now, works) in [(0.0, true), (0.4, false), (0.5, false), (0.6, false)] {
            zones.watch(
                &mut board,
                now,
                |_| works,
                |zone, who| {
                    lost.push((now, zone.to_owned(), who.as_str().to_owned()));
                },
            );
        }
        assert_eq!(lost, [(0.5, "press".to_owned(), "left".to_owned())]);
        assert_eq!(board.value(owner.unwrap()), Some(text("")));
    }
}
