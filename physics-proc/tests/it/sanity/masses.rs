//! Heavy things on light ones.

use cell_model::Shape;
use nalgebra::Isometry3;

use super::scene::{Scene, box_of, cube, cylinder};

/// What a load is allowed to sink in (m): contacts are springs, and the depth grows with the
/// ratio of the masses, by about 5 um each.
fn allowed(ratio: f64) -> f64 {
    0.1e-3 + 6.0e-6 * ratio
}

fn check(light: f64, ratio: f64, below: &Shape, height: f64, arm: bool, seconds: f64) {
    let mut scene = Scene::new(arm);
    let half = Isometry3::translation(0.0, 0.0, 0.5 * height);
    let over = Isometry3::translation(0.0, 0.0, height + 0.025);
    scene.object(below.clone(), light, half);
    let load = scene.object(box_of([0.1, 0.1, 0.05]), light * ratio, over);
    let mut running = scene.start();
    running.run(seconds);
    let moved = running.place(load) - over.translation.vector;
    let said = format!("{ratio} times {light} kg on {below:?}, arm {arm}: {moved}");
    assert!(moved.z < 1.0e-6 && -moved.z < allowed(ratio), "{said}");
    assert!(moved.xy().norm() < 1.0e-3, "{said}");
    assert!(running.pose(load).rotation.angle() < 0.035, "{said}");
}

#[test]
fn two_hundred_times_its_own_mass_is_carried() {
    check(0.1, 10.0, &cube(), 0.05, false, 2.0);
    check(0.1, 200.0, &cube(), 0.05, true, 1.0);
    check(0.01, 200.0, &cylinder(), 0.06, false, 2.0);
}

#[test]
#[ignore = "slow: .ci/long"]
fn two_hundred_times_its_own_mass_is_carried_for_long() {
    for arm in [false, true] {
        for light in [0.01, 0.1, 1.0] {
            for ratio in [1.0, 10.0, 50.0, 100.0, 200.0] {
                check(light, ratio, &cube(), 0.05, arm, 20.0);
                check(light, ratio, &cylinder(), 0.06, arm, 20.0);
            }
        }
    }
}
