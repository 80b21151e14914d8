//! A belt moves objects at the speed of its surface.

use nalgebra::{Isometry3, Translation3};

use super::scene::{Scene, box_of, cube, cylinder, every_shape};

/// Speeds are right to this share.
const RIGHT: f64 = 2.0e-3;

fn on_belt(friction: f64, speed: f64, arm: bool) -> Scene {
    let mut scene = Scene::new(arm);
    let belt = Isometry3::translation(0.0, 0.0, 0.25);
    scene.fixture("belt", box_of([4.0, 6.0, 0.1]), belt, friction);
    scene.belt("belt", [0.0, -speed, 0.0]);
    scene
}

fn check(friction: f64, speed: f64, mass: f64, arm: bool) {
    let mut scene = on_belt(friction, speed, arm);
    let mut carried = Vec::new();
    for (index, (name, shape, pose)) in every_shape().into_iter().enumerate() {
        let place = Translation3::new(0.45 * index as f64 - 1.7, 2.5, 0.3);
        let object = scene.rough_object(shape, mass, friction, place * pose);
        // What has its axis across the belt turns on it.
        let turns = name.ends_with("lying") || name == "ball";
        carried.push((name, object, turns));
    }
    let mut running = scene.start();
    running.run(1.0);
    let before: Vec<_> = carried.iter().map(|(_, o, _)| running.place(*o)).collect();
    running.run(1.0);
    for ((name, object, turns), before) in carried.iter().zip(before) {
        let way = running.place(*object) - before;
        let said = format!("{name} of {mass} kg, friction {friction}, {speed} m/s: {way}");
        assert!(way.x.abs() < 1.0e-4, "aside: {said}");
        if *turns {
            assert!(-way.y > 0.2 * speed && -way.y < 0.5 * speed, "{said}");
        } else {
            assert!((-way.y / speed - 1.0).abs() < RIGHT, "{said}");
        }
    }
}

#[test]
fn a_belt_moves_things_as_fast_as_it_runs() {
    check(0.6, 0.2, 0.1, false);
    check(0.3, 0.5, 5.0, true);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_belt_of_any_speed_moves_things_of_any_mass_and_friction() {
    for arm in [false, true] {
        for friction in [0.2, 0.6, 1.0] {
            for speed in [0.02, 0.05, 0.2, 0.5] {
                for mass in [0.01, 0.1, 5.0] {
                    check(friction, speed, mass, arm);
                }
            }
        }
    }
}

#[test]
fn what_a_stop_holds_on_a_running_belt_stays_upright_and_pushes_with_its_friction() {
    let mut scene = on_belt(0.6, 0.2, false);
    let stop = Isometry3::translation(0.0, 0.0, 0.35);
    scene.fixture("stop", box_of([1.0, 0.05, 0.1]), stop, 0.0);
    let at = |x: f64, height: f64| Isometry3::translation(x, 0.06, 0.3 + height);
    let held = [
        scene.object(cube(), 0.1, at(-0.2, 0.025)),
        scene.object(cylinder(), 1.0, at(0.0, 0.03)),
    ];
    let mut running = scene.start();
    running.run(1.0);
    let before = held.map(|object| running.pose(object));
    running.run(2.0);
    for (object, before) in held.into_iter().zip(before) {
        let pose = running.pose(object);
        let way = pose.translation.vector - before.translation.vector;
        // Along the stop nothing holds them.
        assert!(way.yz().norm() < 1.0e-3, "{object}: {way}");
        assert!(
            (pose.rotation * nalgebra::Vector3::z()).z > 0.999,
            "{object}"
        );
    }
}
