//! Which way the fingers point around a cube.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;

use super::geometry::nearest_quarter;
use super::scene::View;
use super::setup::StackSetup;

/// Half of the open width, a finger's thickness and half of a turned cube: a
/// cube with its centre nearer than this along the fingers' axis is in their
/// way (m).
const FINGER_REACH_M: f64 = 0.09;
/// Half a finger's breadth and half of a turned cube (m).
const FINGER_BREADTH_M: f64 = 0.045;
/// The same for what is as high as the palm: half of the hand, which is 0.2 m
/// long and 0.063 m broad, and half of a turned cube (m).
const HAND_REACH_M: f64 = 0.135;
/// See [`HAND_REACH_M`] (m).
const HAND_BREADTH_M: f64 = 0.065;
/// A wrist turned further than this (rad) starts again from the nearest quarter.
const MAX_TURN_RAD: f64 = 1.8;

/// Turn of the tool for a new pick-up (rad): the cube's own, unless a neighbour
/// is in the way of the fingers and not of fingers turned by a quarter; every
/// other attempt takes the other way.
pub fn choose(setup: &StackSetup, scene: &View, cube: usize, failed_attempts: u32) -> f64 {
    let along = scene.cube(cube).yaw;
    let across = if along > 0.0 {
        along - FRAC_PI_2
    } else {
        along + FRAC_PI_2
    };
    let (a, b) = (
        crowding(setup, scene, cube, along),
        crowding(setup, scene, cube, across),
    );
    if b < a || (a == b && failed_attempts % 2 == 1) {
        across
    } else {
        along
    }
}

/// The turn of a cube that is being followed, without jumps of the wrist (rad).
pub fn follow(scene: &View, cube: usize, last: f64) -> f64 {
    let reference = if last.abs() > MAX_TURN_RAD { 0.0 } else { last };
    nearest_quarter(scene.cube(cube).yaw, reference)
}

/// Cubes in the way of fingers that close along the tool's y axis.
fn crowding(setup: &StackSetup, scene: &View, cube: usize, yaw: f64) -> usize {
    let centre = scene.cube(cube).position;
    let across = Vector2::new(libm::cos(yaw), libm::sin(yaw));
    let along = Vector2::new(-across.y, across.x);
    let in_the_way = |other: &usize| {
        let offset = scene.cube(*other).position - centre;
        // A palm is about a cube above the TCP.
        let (reach, breadth) = if offset.z > 0.5 * setup.spec.layer_height_m {
            (HAND_REACH_M, HAND_BREADTH_M)
        } else {
            (FINGER_REACH_M, FINGER_BREADTH_M)
        };
        *other != cube
            && offset.z > -0.7 * setup.spec.layer_height_m
            && offset.xy().dot(&along).abs() < reach
            && offset.xy().dot(&across).abs() < breadth
    };
    (0..setup.cubes.len()).filter(in_the_way).count()
}
