//! Which way the fingers close around a cube.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;

use super::host::World;
use super::setup::ArmSetup;
use crate::stack::geometry;

/// Thickness of a finger of the hand, along the axis on which it closes (m).
const FINGER_THICK_M: f64 = 0.015;
/// Half of a finger's breadth (m).
const FINGER_BREADTH_M: f64 = 0.010;
/// Half of the hand, which is 0.2 m long and 0.063 m broad (m).
const HAND_LENGTH_M: f64 = 0.10;
/// See [`HAND_LENGTH_M`] (m).
const HAND_BREADTH_M: f64 = 0.03;
/// Half of a cube that is turned (cube edges).
const TURNED_EDGES: f64 = 0.7;

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
    let numbers = &world.setup.numbers;
    let edge = numbers.layer_height_m;
    // With its centre nearer than this, another cube is in the way: of the open
    // fingers, and of the palm above them.
    let turned = TURNED_EDGES * edge;
    let fingers = (
        0.5 * numbers.open_width_m + FINGER_THICK_M + turned,
        FINGER_BREADTH_M + turned,
    );
    let palm = (HAND_LENGTH_M + turned, HAND_BREADTH_M + turned);
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
        let high = offset.z > 0.5 * edge;
        let (reach, breadth) = if high { palm } else { fingers };
        *other != cube
            && !world.is_held(*other)
            && offset.z > -0.7 * edge
            && offset.xy().dot(&along).abs() < reach
            && offset.xy().dot(&across).abs() < breadth
    };
    (0..world.setup.cubes.len()).filter(in_the_way).count()
}
