//! Node types for arms in a shared cell: zones in which one arm works at a time, and objects on
//! which one arm works at a time.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

use std::sync::Arc;

use behavior::board::{Access, Fault, In, Scope};
use behavior::tree::{Leaf, Library, NodeType};
use behavior::{Status, Str};

use super::guarded::zone;
use super::{Context, WorkKeys};
use crate::setup::Setup;
use crate::shared::{Lease, Owner, Reservations, Turn};
use crate::skill::Station;

/// Adds the node types.
pub(super) fn add(
    library: Library<Station>,
    setup: &Arc<Setup>,
    keys: WorkKeys,
) -> Library<Station> {
    library
        .with(enter(keys))
        .with(leave(setup, keys))
        .with(reserve(setup, keys))
        .with(unreserve(setup, keys))
}

struct EnterZone(Lease);

impl Leaf<Station> for EnterZone {
    type State = Turn;

    fn start(&self, state: &mut Turn, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        *state = Turn::default();
        Ok(())
    }

    fn tick(&self, state: &mut Turn, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        Ok(if state.comes(&self.0, cx)? {
            Status::Success
        } else {
            Status::Running
        })
    }
}

fn enter(keys: WorkKeys) -> NodeType<Station> {
    NodeType::new(
        "EnterZone",
        "Waits until no other arm owns the zone, and takes it. The arm owns it until \
         LeaveZone, until its tree ends, or until it does not answer for half a second.",
        move |binder| {
            let zone = zone(binder, keys)?;
            Ok(EnterZone(Lease::bind(binder, &zone)?))
        },
    )
    .keywords(&["lock", "wait", "mutex", "lease"])
    .input_or(
        "zone",
        Str::EMPTY,
        "name of the zone; the tree's own without",
    )
}

struct LeaveZone {
    lease: Lease,
    owners: Reservations,
    object: In<Str>,
}

impl Leaf<Station> for LeaveZone {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let object = cx.world.setup.object(cx.get(&self.object)?.as_str());
        if let Some(object) = object.filter(|object| cx.world.held() == Some(*object)) {
            // From here on the object is lost, not moved, if it is no longer in the gripper
            // (`reconcile`).
            self.owners.set(cx, object, Owner::Carried)?;
        }
        self.lease.release(cx)?;
        Ok(Status::Success)
    }
}

fn leave(setup: &Arc<Setup>, keys: WorkKeys) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "LeaveZone",
        "Gives the zone back, and notes that the object the tree works at is carried \
         now, if it is in the gripper.",
        move |binder| {
            let zone = zone(binder, keys)?;
            let object = Some(Str::EMPTY);
            let object = binder.writes(Scope::Local, keys.object, object, Access::Read)?;
            Ok(LeaveZone {
                lease: Lease::bind(binder, &zone)?,
                owners: Reservations::bind(&setup, binder, keys.owners)?,
                object: In::Key(object.slot),
            })
        },
    )
    .aliases(&["ReleaseCenter", "FrankaReleaseCenter"])
    .keywords(&["lock", "unlock", "carried"])
    .input_or(
        "zone",
        Str::EMPTY,
        "name of the zone; the tree's own without",
    )
}

/// Reserves an object, or makes it available again.
struct Reserve {
    owners: Reservations,
    object: In<Str>,
    to: Owner,
}

impl Leaf<Station> for Reserve {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let object = cx.world.setup.object(cx.get(&self.object)?.as_str());
        let Some(object) = object else {
            return Ok(Status::Failure);
        };
        // An arm cannot take the object of another one: the other would be sent to an object
        // that is gone.
        if self.owners.owner(cx, object)? == Owner::Other {
            return Ok(Status::Failure);
        }
        self.owners.set(cx, object, self.to)?;
        Ok(Status::Success)
    }
}

fn reservation(
    (name, doc): (&'static str, &'static str),
    setup: &Arc<Setup>,
    keys: WorkKeys,
    to: Owner,
) -> NodeType<Station> {
    let setup = Arc::clone(setup);
    NodeType::new(name, doc, move |binder| {
        Ok(Reserve {
            owners: Reservations::bind(&setup, binder, keys.owners)?,
            object: binder.input("object")?,
            to,
        })
    })
    .keywords(&["claim", "lock", "object"])
    .input::<Str>("object", "the object")
}

fn reserve(setup: &Arc<Setup>, keys: WorkKeys) -> NodeType<Station> {
    let doc = "Reserves an object for this arm. Fails while it is another arm's.";
    reservation(("Reserve", doc), setup, keys, Owner::Reserved)
}

fn unreserve(setup: &Arc<Setup>, keys: WorkKeys) -> NodeType<Station> {
    let doc = "Gives an object that this arm reserved back. Fails where it is another arm's.";
    reservation(("Unreserve", doc), setup, keys, Owner::Available)
}
