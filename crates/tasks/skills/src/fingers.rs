//! Which way two fingers close around an object that has neighbours.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};
use robocell_task::job::Placement;

use crate::geometry;
use crate::setup::Tool;
use crate::world::World;

/// Thickness of a finger, along the axis on which it closes (m).
const FINGER_THICK_M: f64 = 0.015;
/// Half of a finger's breadth (m).
const FINGER_BREADTH_M: f64 = 0.010;
/// Half of the hand above the fingers, along the axis on which they close and
/// across it (m).
const HAND_M: (f64, f64) = (0.10, 0.03);
/// Half of an object that is turned, in half heights: a cube's diagonal.
const TURNED_HALVES: f64 = 1.4;

/// The two ways around an object: the turn of the tool about the vertical axis
/// (rad), and how many other objects are in the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ways {
    along: (f64, usize),
    across: (f64, usize),
}

impl Ways {
    /// Around `object`, which is at `seen`; of its sides the one is preferred whose
    /// turn is nearest to `reference` (rad).
    pub fn around(object: usize, seen: Placement, reference: f64, world: &World<'_>) -> Self {
        let along = geometry::nearest_quarter(seen.yaw, reference);
        // Of the two quarter turns the one that winds the wrist less.
        let across = if along > 0.0 {
            along - FRAC_PI_2
        } else {
            along + FRAC_PI_2
        };
        Self {
            along: (along, crowding(object, seen, along, world)),
            across: (across, crowding(object, seen, across, world)),
        }
    }

    /// Whether nothing is in the way on one of them.
    pub fn is_free(&self) -> bool {
        self.along.1 == 0 || self.across.1 == 0
    }

    /// The turn with fewer objects in the way (rad); of two equal ones the
    /// preferred, or with `other` the other one.
    pub fn choose(&self, other: bool) -> f64 {
        let (along, across) = (self.along, self.across);
        if across.1 < along.1 || (across.1 == along.1 && other) {
            across.0
        } else {
            along.0
        }
    }
}

/// Objects in the way of open fingers that close along the tool's y axis, and of
/// the hand above them.
fn crowding(object: usize, seen: Placement, yaw: f64, world: &World<'_>) -> usize {
    let Tool::Fingers { open_width_m, .. } = world.tool() else {
        return 0;
    };
    let half = |object: usize| world.object_setup(object).map_or(0.0, |o| o.half_height_m);
    let fingers = (0.5 * open_width_m + FINGER_THICK_M, FINGER_BREADTH_M);
    let across = Vector2::new(libm::cos(yaw), libm::sin(yaw));
    let along = Vector2::new(-across.y, across.x);
    let in_the_way = |other: &usize| {
        let Some(position) = world.position(*other) else {
            return false;
        };
        let off = position - Vector3::from(seen.position);
        let high = off.z > half(object);
        let (reach, breadth) = if high { HAND_M } else { fingers };
        let turned = TURNED_HALVES * half(*other);
        *other != object
            && off.z > -TURNED_HALVES * half(object)
            && off.xy().dot(&along).abs() < reach + turned
            && off.xy().dot(&across).abs() < breadth + turned
            && !world.is_held(*other)
    };
    (0..world.setup.objects.len()).filter(in_the_way).count()
}
