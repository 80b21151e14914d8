//! Round shapes roll with the acceleration of mechanics, and gain no energy.

use cell_model::Shape;
use nalgebra::{Isometry3, Translation3, Vector3};

use super::scene::{FRICTION, Running, Scene, about, ball, box_of, capsule, cylinder, lying};

/// Contacts are springs: energy that they return at once is not a gain (J).
const GIVEN_BACK_J: f64 = 1.0e-5;

/// Runs for `seconds`; the largest rise of energy between two samples (J).
fn largest_rise(running: &mut Running, seconds: f64) -> f64 {
    let (mut energy, mut rise) = (running.energy(), 0.0_f64);
    for _ in 0..(seconds * 100.0) as usize {
        running.run(0.01);
        let now = running.energy();
        rise = rise.max(now - energy);
        energy = now;
    }
    rise
}

/// Rolls `shape` down a slope (degrees) of one metre; its acceleration in parts of that of a
/// body that slides without friction.
fn down(shape: Shape, slope: f64, arm: bool) -> f64 {
    let mut scene = Scene::new(arm);
    let tilt = about(Vector3::y_axis(), slope);
    let plane = Isometry3::from_parts(Translation3::new(0.0, 1.0, 0.5), tilt);
    scene.fixture("slope", box_of([1.0, 1.0, 0.1]), plane, FRICTION);
    let across = about(Vector3::z_axis(), 90.0) * lying();
    let start = plane * Translation3::new(-0.4, 0.0, 0.07) * across;
    let rolls = scene.object(shape, 0.1, start);
    let mut running = scene.start();
    let seconds = 0.6;
    let rise = largest_rise(&mut running, seconds);
    assert!(rise < GIVEN_BACK_J, "energy rises by {rise} J");
    running.velocity(rolls).norm() / (seconds * 9.81 * slope.to_radians().sin())
}

/// 1 / (1 + I / (m r^2)) of a capsule of radius 0.02 m whose cylinder is 0.06 m long.
fn share_of_a_capsule() -> f64 {
    let (r, h) = (0.02_f64, 0.06_f64);
    let (cylinder, ball) = (r * r * h, 4.0 / 3.0 * r * r * r);
    let inertia = (0.5 * cylinder + 0.4 * ball) / (cylinder + ball);
    1.0 / (1.0 + inertia)
}

#[test]
fn round_shapes_roll_down_a_slope_as_fast_as_their_inertia_lets_them() {
    for (shape, share) in [
        (cylinder(), 2.0 / 3.0),
        (capsule(), share_of_a_capsule()),
        (ball(), 5.0 / 7.0),
    ] {
        for (slope, arm) in [(2.0, false), (10.0, false), (5.0, true)] {
            let measured = down(shape.clone(), slope, arm);
            assert!(
                (measured / share - 1.0).abs() < 2.0e-3,
                "{shape:?} on {slope} degrees: {measured} instead of {share}"
            );
        }
    }
}

#[test]
fn what_rolls_on_the_floor_gets_no_faster() {
    for shape in [cylinder(), capsule(), ball()] {
        let mut scene = Scene::new(false);
        let tilt = about(Vector3::y_axis(), 3.0);
        let ramp = Isometry3::from_parts(Translation3::new(-1.5, 0.0, 0.0), tilt);
        scene.fixture("ramp", box_of([1.0, 1.0, 0.04]), ramp, FRICTION);
        let across = about(Vector3::z_axis(), 90.0) * lying();
        let start = ramp * Translation3::new(0.2, 0.0, 0.04) * across;
        let rolls = scene.object(shape.clone(), 0.1, start);
        let mut running = scene.start();
        running.run(3.0);
        let before = running.velocity(rolls).norm();
        let rise = largest_rise(&mut running, 3.0);
        let after = running.velocity(rolls);
        assert!(rise < GIVEN_BACK_J, "{shape:?}: {rise} J");
        assert!(before > 0.3 && after.norm() <= before * 1.0001, "{after}");
        assert!(after.y.abs() < 1.0e-3, "it rolls straight on: {after}");
    }
}
