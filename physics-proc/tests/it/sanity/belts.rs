//! A belt moves objects at the speed of its surface.

use ipc_types::world::OBJECT_ASLEEP;
use nalgebra::{Isometry3, Translation3, Vector3};

use super::scene::{Scene, about, box_of, cube, cylinder, every_shape};

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

/// A belt along x with a smooth table of the same height beside it, which starts at y = 0.3.
fn beside_table() -> Scene {
    let mut scene = Scene::new(false);
    let belt = Isometry3::translation(0.0, 0.0, 0.45);
    scene.fixture("belt", box_of([20.0, 0.6, 0.1]), belt, 0.6);
    scene.belt("belt", [0.2, 0.0, 0.0]);
    let table = Isometry3::translation(0.0, 0.6, 0.45);
    scene.fixture("table", box_of([20.0, 0.6, 0.1]), table, 0.05);
    scene
}

#[test]
fn objects_asleep_on_a_part_of_the_belt_wake_when_it_starts() {
    let mut scene = beside_table();
    let mut placed = Vec::new();
    for (index, (name, shape, pose)) in every_shape().into_iter().enumerate() {
        // The centre is over the table, by 5 mm; a ball has one point of contact.
        let aside = if name == "ball" { 0.29 } else { 0.305 };
        // A round one has its axis across the belt's edge.
        let turn = about(Vector3::z_axis(), 90.0);
        let at = Translation3::new(index as f64 - 4.0, aside, 0.5) * turn;
        placed.push((name, scene.object(shape, 0.1, at * pose)));
    }
    // A bar across both, most of it beside the belt.
    let bar = Isometry3::translation(5.0, 0.44, 0.525);
    placed.push(("bar", scene.object(box_of([0.06, 0.6, 0.05]), 0.5, bar)));
    // A beam that leans on the belt from a rest lower than it.
    let rest = Isometry3::translation(6.5, -0.5, 0.2);
    scene.fixture("rest", box_of([0.4, 0.1, 0.4]), rest, 0.05);
    let lean = Translation3::new(6.5, -0.43, 0.48) * about(Vector3::x_axis(), 20.0);
    placed.push(("beam", scene.object(box_of([0.05, 0.5, 0.03]), 0.5, lean)));
    let mut running = scene.start();
    running.run_belt(false);
    running.run(3.0);
    let before: Vec<_> = placed.iter().map(|(_, o)| running.place(*o)).collect();
    let asleep = placed.iter().filter(|(_, object)| {
        let flags = running.state().objects[*object].flags;
        flags & OBJECT_ASLEEP != 0
    });
    assert!(asleep.count() >= 8, "most of them sleep");
    running.run_belt(true);
    running.run(1.0);
    for ((name, object), before) in placed.iter().zip(&before) {
        let way = running.place(*object) - before;
        assert!(way.x > 0.02, "{name} moved by {way}");
    }
    // Once more, after a stop at which nothing is where it was put.
    running.run_belt(false);
    running.run(4.0);
    let before: Vec<_> = placed.iter().map(|(_, o)| running.place(*o)).collect();
    running.run_belt(true);
    running.run(1.0);
    for ((name, object), before) in placed.iter().zip(before) {
        let place = running.place(*object);
        let is_over = place.y.abs() < 0.3 || (*name == "bar" && place.y < 0.5);
        assert!(
            !is_over || place.x > before.x + 0.02,
            "{name} is at {place}"
        );
    }
}
