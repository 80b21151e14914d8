//! Which way the fingers close around a cube.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;

use super::host::World;
use super::setup::ArmSetup;
use crate::stack::geometry;

/// A cube with its centre nearer than this along the fingers' axis is in their
/// way (m): half of the open width, a finger's thickness, half of a turned cube.
const REACH_M: f64 = 0.09;
/// Half a finger's breadth and half of a turned cube (m).
const BREADTH_M: f64 = 0.045;
/// The same for cubes as high as the palm (m): half of the hand, which is 0.2 m
/// long and 0.063 m broad, and half of a turned cube.
const HAND_REACH_M: f64 = 0.135;
/// See [`HAND_REACH_M`] (m).
const HAND_BREADTH_M: f64 = 0.065;

/// Turn of the tool for a pick-up (rad): the cube's own that is nearest to the
/// arm's, unless fingers turned by a quarter meet fewer neighbours. Where both
/// meet as many, every other recovery tries the other one.
pub(super) fn choose(world: &World<'_>, arm: &ArmSetup, cube: usize) -> f64 {
    let (along, across) = turns(world, arm, cube);
    let (a, b) = (crowding(world, cube, along), crowding(world, cube, across));
    let tried = world.counters.recoveries % 2 == 1;
    if b < a || (a == b && a > 0 && tried) {
        across
    } else {
        along
    }
}

/// Whether fingers meet no neighbours on one way around a cube.
pub(super) fn is_free(world: &World<'_>, arm: &ArmSetup, cube: usize) -> bool {
    let (along, across) = turns(world, arm, cube);
    crowding(world, cube, along) == 0 || crowding(world, cube, across) == 0
}

/// The two ways around a cube (rad).
fn turns(world: &World<'_>, arm: &ArmSetup, cube: usize) -> (f64, f64) {
    let own = world
        .cube(cube)
        .map_or(arm.yaw, |pose| geometry::yaw(&pose));
    let along = geometry::nearest_quarter(own, arm.yaw);
    // Of the two quarter turns the one that winds the wrist less.
    let across = if along > 0.0 {
        along - FRAC_PI_2
    } else {
        along + FRAC_PI_2
    };
    (along, across)
}

/// Cubes in the way of fingers that close along the tool's y axis.
fn crowding(world: &World<'_>, cube: usize, yaw: f64) -> usize {
    let edge = world.setup.numbers.layer_height_m;
    let Some(centre) = world.cube_position(cube) else {
        return 0;
    };
    let across = Vector2::new(libm::cos(yaw), libm::sin(yaw));
    let along = Vector2::new(-across.y, across.x);
    let in_the_way = |other: &usize| {
        let Some(position) = world.cube_position(*other) else {
            return false;
        };
        let offset = position - centre;
        let (reach, breadth) = if offset.z > 0.5 * edge {
            (HAND_REACH_M, HAND_BREADTH_M)
        } else {
            (REACH_M, BREADTH_M)
        };
        *other != cube
            && !world.is_held(*other)
            && offset.z > -0.7 * edge
            && offset.xy().dot(&along).abs() < reach
            && offset.xy().dot(&across).abs() < breadth
    };
    (0..world.setup.cubes.len()).filter(in_the_way).count()
}
