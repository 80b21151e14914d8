//! Other objects of the cell change nothing, as long as nothing touches.

use nalgebra::{Isometry3, Vector3};

use super::scene::{Running, Scene, about, ball, box_of, cube, cylinder, lying};

/// Some things fall, tumble and roll on the floor and on nothing else, beside `others` objects.
fn scattered(others: usize, arm: bool) -> Running {
    let mut scene = Scene::new(arm);
    let up = |x: f64, height: f64| Isometry3::translation(x, 0.0, height);
    scene.object(cube(), 0.1, up(0.0, 0.2) * about(Vector3::x_axis(), 20.0));
    scene.object(box_of([0.1, 0.1, 0.02]), 0.5, up(0.2, 0.1));
    scene.object(cylinder(), 0.1, up(0.4, 0.05) * lying());
    scene.object(ball(), 0.1, up(0.6, 0.2));
    scene.others(others);
    scene.start()
}

/// Four boxes on each other.
fn tower(others: usize, arm: bool) -> Running {
    let mut scene = Scene::new(arm);
    for level in 0..4 {
        let height = 0.025 + 0.05 * f64::from(level);
        scene.object(cube(), 0.1, Isometry3::translation(0.0, 0.0, height));
    }
    scene.others(others);
    scene.start()
}

/// Largest way between the first four objects of two scenes in `seconds` (m).
fn apart(mut one: Running, mut other: Running, seconds: f64) -> f64 {
    let mut largest = 0.0_f64;
    for _ in 0..(seconds * 10.0) as usize {
        one.run(0.1);
        other.run(0.1);
        for object in 0..4 {
            let way = (one.place(object) - other.place(object)).norm();
            largest = largest.max(way);
        }
    }
    largest
}

#[test]
fn a_scene_moves_the_same_beside_others_and_beside_an_arm() {
    for (others, arm) in [(20, false), (140, false), (0, true), (20, true)] {
        let way = apart(scattered(0, false), scattered(others, arm), 1.0);
        assert!(way < 1.0e-9, "{way} m beside {others} objects, arm: {arm}");
        let way = apart(tower(0, false), tower(others, arm), 0.5);
        // The engine solves the contacts of a tower in the order in which it found them, and
        // that depends on all objects.
        assert!(way < 1.0e-5, "{way} m beside {others} objects, arm: {arm}");
    }
}
