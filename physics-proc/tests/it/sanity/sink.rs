//! How far the contacts of a stack give way: as springs of docs/limits.md.

use nalgebra::Isometry3;

use super::scene::{Scene, box_of};

const GRAVITY: f64 = 9.81;
/// Natural frequencies of a contact with a fixture, and of one of two objects (rad/s).
const FIXED_RAD_S: f64 = 2.0 * std::f64::consts::PI * 500.0;
const FREE_RAD_S: f64 = 2.0 * std::f64::consts::PI * 250.0;

/// How far the highest of `count` boxes on each other sinks within three seconds (m).
fn sinks(count: usize, size: [f64; 3], mass: f64) -> f64 {
    let mut scene = Scene::new(false);
    for level in 0..count {
        let height = size[2] * (level as f64 + 0.5);
        scene.object(box_of(size), mass, Isometry3::translation(0.0, 0.0, height));
    }
    let mut running = scene.start();
    let before = running.place(count - 1).z;
    running.run(3.0);
    before - running.place(count - 1).z
}

/// The same by the springs: each contact carries what is above it, with the effective mass of
/// the two bodies.
fn by_springs(count: usize) -> f64 {
    let floor = count as f64 * GRAVITY / FIXED_RAD_S.powi(2);
    let others: f64 = (1..count).map(|above| above as f64 * 2.0).sum();
    floor + others * GRAVITY / FREE_RAD_S.powi(2)
}

#[test]
fn a_stack_sinks_as_its_contacts_are_stiff() {
    for (count, side, mass) in [(1, 0.05, 0.1), (4, 0.05, 0.1), (16, 0.1, 0.5)] {
        let (sunk, right) = (sinks(count, [side; 3], mass), by_springs(count));
        assert!(
            (sunk / right - 1.0).abs() < 0.02,
            "{count}: {sunk}, {right}"
        );
    }
    // Thin plates sink further, and no further than twice.
    let (sunk, right) = (sinks(20, [0.1, 0.07, 0.001], 0.005), by_springs(20));
    assert!(sunk < 2.0 * right, "{sunk}, {right}");
}
