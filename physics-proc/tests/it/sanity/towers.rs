//! Towers stay at rest, with any other objects in the cell.

use nalgebra::Isometry3;

use super::scene::{Scene, cube};

/// Largest way of the top box of a tower (m).
const STANDS_M: f64 = 1.0e-3;
/// Largest turn of the top box (rad).
const UPRIGHT_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// A tower of `boxes`, every other one beside the one below it by `offset` (m), beside
/// `others` objects.
fn check(boxes: usize, offset: f64, others: usize, arm: bool, seconds: f64) {
    let mut scene = Scene::new(arm);
    for level in 0..boxes {
        let aside = if level % 2 == 1 { offset } else { 0.0 };
        let height = 0.025 + 0.05 * level as f64;
        scene.object(cube(), 0.1, Isometry3::translation(0.0, aside, height));
    }
    scene.others(others);
    let mut running = scene.start();
    let before = running.pose(boxes - 1);
    running.run(seconds);
    let after = running.pose(boxes - 1);
    let way = (after.translation.vector - before.translation.vector).norm();
    let turn = before.rotation.angle_to(&after.rotation);
    assert!(
        way < STANDS_M && turn < UPRIGHT_RAD,
        "{boxes} boxes, offset {offset} m, beside {others}, arm {arm}: {way} m, {turn} rad"
    );
}

#[test]
fn towers_stand_beside_few_and_beside_many_objects() {
    check(10, 0.003, 0, false, 10.0);
    check(12, 0.0, 0, true, 4.0);
    check(10, 0.003, 20, false, 4.0);
}

#[test]
#[ignore = "slow: .ci/long"]
fn towers_of_all_heights_stand_for_a_minute() {
    for arm in [false, true] {
        for others in [0, 20, 140] {
            for boxes in [2, 4, 6, 8, 10, 12] {
                for offset in [0.0, 0.003] {
                    check(boxes, offset, others, arm, 60.0);
                }
            }
        }
    }
}
