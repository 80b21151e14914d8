//! Objects at rest on a plane stay where they are.

use nalgebra::{Translation3, Vector3};

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
