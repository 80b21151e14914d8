//! Pads of a hand hold up to their friction, in every direction of the pull.

use cell_model::{Cell, Data, Shape};
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{OperatorRequest, Wire};
use nalgebra::{Isometry3, Vector3};

use crate::support::Rig;

/// Force of each finger (N).
const FORCE_N: f64 = 20.0;
/// Friction of the object, and between object and pads (mean of 0.5 and 1.0).
const OWN_FRICTION: f64 = 0.5;
const FRICTION: f64 = 0.75;
/// Friction is right to this share.
const RIGHT: f64 = 0.03;
/// Stiffness of the operator's spring per mass (1/s²), and speed of its end (m/s): the force
/// on 50 g grows by 0.09 N in a tick.
const SPRING: f64 = 3600.0;
const SPEED_M_S: f64 = 0.5;
/// What is pulled slips when it moves in the hand as fast as this (m/s): faster than while the
/// pads give way a little, and soon after the force exceeds their friction.
const SLIPS_M_S: f64 = 0.03;
/// The same for an object that is turned, which moves at some centimetres per second from 0.8 of the
/// limit on (docs/limits.md).
const TURNS_M_S: f64 = 0.1;
/// A turn is right to this share.
const TURN_RIGHT: f64 = 0.06;
/// Half the lengths of the area in which a pad of the Panda presses something 20 mm high (m).
const PAD_M: [f64; 2] = [0.00875, 0.00925];

/// A hand at rest around a box, `aside` of whose length is on one side of the pads.
fn held(size_m: [f64; 3], mass: f64, aside: f64) -> Rig {
    let mut cell = Cell::load(&Data::checkout(), "cube", 1, None).unwrap();
    let object = &mut cell.objects[0];
    object.shape = Shape::Box { size_m };
    (object.mass, object.friction) = (mass, OWN_FRICTION);
    object.pose = Isometry3::translation(0.5 + aside, 0.0, 0.5 * size_m[2]);
    let mut rig = Rig::with(cell);
    rig.force = FORCE_N;
    rig.pick_at([0.5, 0.0, 0.5 * size_m[2]], 0.2);
    rig.stay(500);
    rig
}

/// Force at which the box slips out of the hand when it is pulled along `direction` (N).
fn pull(rig: &mut Rig, direction: Vector3<f64>, slips: f64) -> f64 {
    let place = rig.object(0).translation.vector;
    let mass = rig.cell.objects[0].mass;
    let mut request = OperatorRequest::zeroed();
    request.pose.position = (place + direction).into();
    request.pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
    request.seconds = 5.0;
    let answer = rig.world.execute_request(OperatorAction::Drag, &request);
    assert_eq!(answer.0, ReplyCode::Accepted, "{}", answer.1);
    let mut before = rig.object_in_hand(0).translation.vector;
    for tick in 1..4_000 {
        rig.stay(1);
        let now = rig.object_in_hand(0).translation.vector;
        if (now - before).norm() > slips * 1.0e-3 {
            let way = (rig.object(0).translation.vector - place).dot(&direction);
            return mass * SPRING * (SPEED_M_S * 1.0e-3 * f64::from(tick) - way);
        }
        before = now;
    }
    f64::INFINITY
}

#[test]
fn pads_hold_a_pull_along_them_up_to_their_friction() {
    let right = 2.0 * FRICTION * FORCE_N;
    for degrees in [0.0_f64, 15.0, 30.0, 45.0, 60.0, 90.0, 120.0, 180.0, 225.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut rig = held([0.05; 3], 0.05, 0.0);
        // Fingers close along y.
        let force = pull(&mut rig, Vector3::new(cos, 0.0, sin), SLIPS_M_S);
        assert!(
            (force / right - 1.0).abs() < RIGHT,
            "{degrees} degrees: slips at {force} N, right {right} N"
        );
    }
}

/// Largest force at the lever `arm` across it (m) that four equal points on each pad hold: the
/// least of all that turns about some centre on the lever asks for (N).
fn turning_limit(arm: f64) -> f64 {
    let [x, z] = PAD_M;
    let point = FRICTION * FORCE_N / 4.0;
    let at = |centre: f64| {
        let near = (x - centre).hypot(z) + (x + centre).hypot(z);
        2.0 * point * 2.0 * near / (arm - centre)
    };
    let centres = (0..400).map(|step| -0.02 + 1.0e-4 * f64::from(step));
    centres
        .filter(|centre| *centre < 0.9 * arm)
        .map(at)
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn pads_hold_a_turn_up_to_their_friction() {
    for (aside, up) in [(0.1, 1.0), (0.1, -1.0), (0.05, 1.0), (-0.08, 1.0)] {
        let mut rig = held([0.3, 0.02, 0.02], 0.01, aside);
        let force = pull(&mut rig, Vector3::new(0.0, 0.0, up), TURNS_M_S);
        let right = turning_limit(f64::abs(aside));
        assert!(
            (force / right - 1.0).abs() < TURN_RIGHT,
            "pulled {aside} m beside the pads, {up}: slips at {force} N, right {right} N"
        );
    }
}
