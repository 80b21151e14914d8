//! Motions, grips and checks that watch their object. If it is not where it should be they do
//! not fail: they request a recovery and run until a guard of the tree takes over, see
//! [`Recovery`].
#![allow(clippy::result_large_err, reason = "happens at load, once")]

mod checks;
mod gripper;
mod motion;

use behavior::Str;
use behavior::board::{Access, Fault, In, Scope};
use behavior::tree::{BindError, Binder, Library, NodeType};
use behavior::value::{Numbers, Plain};
use nalgebra::Vector3;

use super::{Context, WorkKeys, is_given};
use crate::shared::{Lease, Recovery, Turn};
use crate::skill::Station;

/// Adds the node types.
pub(super) fn add(library: Library<Station>, keys: WorkKeys) -> Library<Station> {
    let library = library
        .with(motion::node_type(keys))
        .with(gripper::node_type(keys));
    checks::add(library)
}

/// The object that a node watches, and the zone in which it works.
#[derive(Clone, Copy)]
struct Guard {
    object: In<Str>,
    /// Position of the object when the motion was aimed at it (m).
    reference: In<[f64; 3]>,
    movement: In<f64>,
    skip_when_held: In<bool>,
    zone: Option<(In<bool>, Lease)>,
    recovery: Recovery,
}

impl Guard {
    fn bind(binder: &mut Binder<'_>, keys: WorkKeys) -> Result<Self, BindError> {
        let in_zone = binder.input("in_zone")?;
        let zone = if in_zone == In::Literal(false) {
            None
        } else {
            let zone = zone(binder, keys)?;
            Some((in_zone, Lease::bind(binder, &zone)?))
        };
        Ok(Self {
            object: port_or_key(binder, "object", keys.object, Some(Str::EMPTY))?,
            reference: port_or_key(binder, "reference", keys.reference, None)?,
            movement: binder.input("movement")?,
            skip_when_held: binder.input("skip_when_held")?,
            zone,
            recovery: Recovery::bind(binder)?,
        })
    }

    /// The object; `None` between two of them.
    fn object(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        let name = cx.get(&self.object)?;
        Ok(cx.world.setup.object(name.as_str()))
    }

    /// Whether the object is in the gripper.
    fn holds(&self, cx: &Context<'_, '_>) -> Result<bool, Fault> {
        let object = self.object(cx)?;
        Ok(object.is_some() && cx.world.held() == object)
    }

    /// Whether the node has nothing to do, because the object is in the gripper.
    fn skips(&self, cx: &Context<'_, '_>) -> Result<bool, Fault> {
        Ok(cx.get(&self.skip_when_held)? && self.holds(cx)?)
    }

    /// Whether the arm may work at its target; it waits while it may not.
    fn may_work(&self, turn: &mut Turn, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        match &self.zone {
            Some((in_zone, lease)) if cx.get(in_zone)? => turn.comes(lease, cx),
            _ => Ok(true),
        }
    }

    /// Whether the object is farther than the allowed movement from its reference; requests a
    /// recovery then. An object that is not observed has moved.
    fn has_moved(&self, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        let Some(object) = self.object(cx)? else {
            return Ok(false);
        };
        let reference = Vector3::from(cx.get(&self.reference)?);
        let position = cx.world.position(object);
        let moved = position.map_or(f64::INFINITY, |p| (p - reference).norm());
        if moved <= cx.get(&self.movement)? {
            return Ok(false);
        }
        let name = cx.world.setup.object_name(object);
        self.recovery
            .request(cx, format_args!("{name} moved by {:.0} mm", moved * 1.0e3))?;
        Ok(true)
    }

    /// Whether the object has left the gripper: it is farther from the TCP than `max_distance`
    /// (m), or was missing for a while, which `missed` counts. Requests a recovery then.
    fn is_lost(
        &self,
        cx: &mut Context<'_, '_>,
        max_distance: f64,
        missed: &mut u32,
    ) -> Result<bool, Fault> {
        let Some(object) = self.object(cx)? else {
            return Ok(false);
        };
        // Both are needed: a distance alone misses an object that slips from the fingers
        // slowly, and the contacts alone may be missing for single ticks.
        let missing = cx.world.is_lost(object, missed);
        let position = cx.world.position(object);
        let near = position.is_some_and(|p| (p - cx.world.tcp_position()).norm() <= max_distance);
        if near && !missing {
            return Ok(false);
        }
        let name = cx.world.setup.object_name(object);
        self.recovery.request(cx, format_args!("{name} was lost"))?;
        Ok(true)
    }
}

/// Adds the ports of a [`Guard`].
fn guarded(node_type: NodeType<Station>) -> NodeType<Station> {
    node_type
        .input_or(
            "movement",
            0.008,
            "an object that moved further has moved (m)",
        )
        .within(1.0e-4, 1.0)
        .also(&["movement_tolerance"])
        .input_or(
            "skip_when_held",
            false,
            "succeeds at once when the object is in the gripper already",
        )
        .input_or(
            "in_zone",
            false,
            "works in the zone: waits while another arm owns it",
        )
        .also(&["in_center"])
        .input_or(
            "zone",
            Str::EMPTY,
            "name of the zone; the tree's own without",
        )
        .input_or(
            "object",
            Str::EMPTY,
            "the object that is watched; the one the tree works at without",
        )
        .input_or(
            "reference",
            Numbers::default(),
            "where it was when it was aimed at: x y z (m); as the tree noted it without",
        )
}

/// The name of a node's zone.
pub(super) fn zone(binder: &mut Binder<'_>, keys: WorkKeys) -> Result<String, BindError> {
    match binder.input::<Str>("zone")? {
        In::Literal(name) if name.is_empty() => Ok(keys.zone.to_owned()),
        In::Literal(name) => Ok(name.as_str().to_owned()),
        // Refused: the lease of a zone is bound to keys of the board while the file is loaded.
        In::Key(_) => Err(BindError::Host(
            "port 'zone' is bound to a key; write the name of the zone".to_owned(),
        )),
    }
}

/// An input from its port, or, if that is not given, from a key of the tree's own blackboard.
fn port_or_key<T: Plain>(
    binder: &mut Binder<'_>,
    port: &str,
    key: &str,
    default: Option<T>,
) -> Result<In<T>, BindError> {
    if is_given(binder, port) {
        return binder.input(port);
    }
    let key = binder.writes(Scope::Local, key, default, Access::Read)?;
    Ok(In::Key(key.slot))
}
