//! What motions and grips keep an eye on: the cube they are about.

use behavior::Str;
use behavior::board::{Access, Fault, Out};
use behavior::tree::{BindError, Binder};
use nalgebra::Vector3;

use crate::pyramid::center::Center;
use crate::pyramid::host::Context;
use crate::pyramid::keys::{self, Recovery};

/// Decisions a grip has to be missed for: contacts flicker while the cube
/// settles between the pads.
pub(super) const LOST_DECISIONS: u32 = 5;

/// A node's hold of the cube the tree works at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    current: Out<Str>,
    reference: Out<[f64; 3]>,
    pub(super) recovery: Recovery,
    pub(super) center: Center,
}

impl Watch {
    pub(super) fn bind(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            current: keys::local(binder, keys::CURRENT_CUBE, Some(Str::EMPTY), Access::Read)?,
            reference: keys::local(binder, keys::PICKUP_REFERENCE, None, Access::Read)?,
            recovery: Recovery::bind(binder)?,
            center: Center::bind(binder)?,
        })
    }

    /// The cube, `None` between two of them.
    pub(super) fn cube(&self, cx: &Context<'_, '_>) -> Result<Option<usize>, Fault> {
        let name = cx.read(&self.current)?;
        Ok(cx.world.setup.cube_named(name.as_str()))
    }

    /// Whether the cube is in the hand.
    pub(super) fn holds(&self, cx: &Context<'_, '_>) -> Result<bool, Fault> {
        let cube = self.cube(cx)?;
        Ok(cube.is_some() && cx.world.cube_in_hand() == cube)
    }

    /// Whether the cube is further than `movement` (m) from where it was when
    /// its targets were made; asks for a recovery then. A cube that is not seen
    /// has moved.
    pub(super) fn has_moved(&self, cx: &mut Context<'_, '_>, movement: f64) -> Result<bool, Fault> {
        let Some(cube) = self.cube(cx)? else {
            return Ok(false);
        };
        let reference = Vector3::from(cx.read(&self.reference)?);
        let moved = cx
            .world
            .cube_position(cube)
            .map_or(f64::INFINITY, |p| (p - reference).norm());
        if moved <= movement {
            return Ok(false);
        }
        let name = cx.world.setup.cube_name(cube);
        self.recovery
            .request(cx, format_args!("{name} moved by {:.0} mm", moved * 1.0e3))?;
        Ok(true)
    }

    /// Whether the cube has left the hand: it is further from the TCP than
    /// `max_distance` (m), or the fingers have missed it for a while, which
    /// `missed` counts. Asks for a recovery then.
    pub(super) fn is_lost(
        &self,
        cx: &mut Context<'_, '_>,
        max_distance: f64,
        missed: &mut u32,
    ) -> Result<bool, Fault> {
        let Some(cube) = self.cube(cx)? else {
            return Ok(false);
        };
        *missed = if cx.world.cube_in_hand() == Some(cube) {
            0
        } else {
            missed.saturating_add(1)
        };
        let distance = cx.world.distance_to_tcp(cube).unwrap_or(f64::INFINITY);
        if distance <= max_distance && *missed < LOST_DECISIONS {
            return Ok(false);
        }
        let name = cx.world.setup.cube_name(cube);
        self.recovery
            .request(cx, format_args!("{name} left the hand"))?;
        Ok(true)
    }
}
