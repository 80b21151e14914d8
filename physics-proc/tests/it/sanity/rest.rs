//! Objects at rest on a plane stay where they are.

use cell_model::Shape;
use nalgebra::{Isometry3, Translation3, Vector3};

use super::scene::{FRICTION, Scene, about, box_of, every_shape};

/// Largest way of an object at rest (m).
const AT_REST_M: f64 = 0.1e-3;

/// Each shape is `seconds` at rest on a separate plane, which is tilted by `slope` and turned
/// by `yaw` about its normal (degrees). The axis of a lying shape is along the slope: across
/// it the shape rolls down, as it must.
fn check(arm: bool, slope: f64, yaw: f64, seconds: f64) {
    let mut scene = Scene::new(arm);
    let mut placed = Vec::new();
    for (index, (name, shape, pose)) in every_shape().into_iter().enumerate() {
        if name == "ball" && slope > 0.0 {
            continue;
        }
        let is_held = name.ends_with("lying") && slope > 0.0;
        let turn = about(Vector3::z_axis(), if is_held { 0.0 } else { yaw });
        let at = Translation3::new(index as f64 - 3.0, 1.0, 0.5);
        let plane = at * about(Vector3::y_axis(), slope);
        let below = plane * Translation3::new(0.0, 0.0, -0.05);
        scene.fixture(name, box_of([0.8, 0.8, 0.1]), below, FRICTION);
        let pose = plane * turn * pose;
        placed.push((name, scene.object(shape, 0.1, pose)));
    }
    let mut running = scene.start();
    running.run(0.5);
    let before: Vec<_> = placed.iter().map(|(_, o)| running.place(*o)).collect();
    running.run(seconds);
    for ((name, object), before) in placed.iter().zip(before) {
        let way = (running.place(*object) - before).norm();
        assert!(
            way < AT_REST_M,
            "{name} moved {way} m; arm: {arm}, slope {slope}, yaw {yaw}"
        );
    }
}

#[test]
fn every_shape_stays_where_it_lies() {
    check(false, 0.0, 40.0, 4.0);
    check(false, 20.0, 40.0, 4.0);
    check(true, 20.0, 0.0, 1.0);
}

#[test]
#[ignore = "slow: .ci/long"]
fn every_shape_stays_where_it_lies_for_a_minute() {
    for arm in [false, true] {
        for slope in [0.0, 5.0, 15.0, 25.0] {
            for yaw in [0.0, 40.0, 90.0] {
                check(arm, slope, yaw, 60.0);
            }
        }
    }
}

/// Dropped at each edge of a block, with their centres 20 to 60 mm within it.
#[test]
fn cylinders_that_overhang_an_edge_come_to_rest() {
    let mut scene = Scene::new(false);
    let mut placed = Vec::new();
    for (index, inside) in [0.02, 0.03, 0.04, 0.06].into_iter().enumerate() {
        let block = Isometry3::translation(index as f64 - 1.5, 0.0, 0.2);
        scene.fixture("block", box_of([0.6, 0.6, 0.4]), block, FRICTION);
        let at = 0.3 - inside;
        for (x, y) in [(at, 0.0), (-at, 0.0), (0.0, at), (0.0, -at)] {
            let shape = Shape::Cylinder {
                radius_m: 0.06,
                height_m: 0.12,
            };
            placed.push(scene.object(shape, 0.3, block * Translation3::new(x, y, 0.4)));
        }
    }
    let mut running = scene.start();
    running.run(1.0);
    let before: Vec<_> = placed.iter().map(|object| running.place(*object)).collect();
    running.run(5.0);
    for (object, before) in placed.into_iter().zip(before) {
        let way = (running.place(object) - before).norm();
        assert!(way < AT_REST_M, "{before:?} moved {way} m");
    }
}
