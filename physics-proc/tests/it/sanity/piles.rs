//! A pile that falls loses energy until it is at rest.

use cell_model::Shape;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use super::scene::{FRICTION, Scene, cube, cylinder};

/// Share of the energy at the start that springs of contacts may give back in 10 ms.
const GIVEN_BACK: f64 = 2.0e-5;

fn shape(index: usize) -> Shape {
    match index % 3 {
        0 => cube(),
        1 => Shape::Capsule {
            radius_m: 0.02,
            height_m: 0.04,
        },
        _ => cylinder(),
    }
}

fn check(parts: usize, arm: bool, seconds: f64) {
    let mut scene = Scene::new(arm);
    let tub = Shape::Bin {
        size_m: [0.4, 0.4, 0.3],
        wall_m: 0.01,
    };
    scene.fixture("tub", tub, Isometry3::translation(0.0, 0.0, 0.15), FRICTION);
    for index in 0..parts {
        let (column, row) = ((index % 4) as f64, (index / 4 % 4) as f64);
        let layer = (index / 16) as f64;
        let place = Translation3::new(
            -0.135 + 0.09 * column + 0.003 * layer,
            -0.135 + 0.09 * row,
            0.1 + 0.125 * layer,
        );
        let number = index as f64;
        let turn = UnitQuaternion::from_euler_angles(0.3 * number, 0.7 * number, 0.0);
        scene.object(shape(index), 0.1, Isometry3::from_parts(place, turn));
    }
    let mut running = scene.start();
    let start = running.energy();
    let mut energy = start;
    for _ in 0..(seconds * 100.0) as usize {
        running.run(0.01);
        let now = running.energy();
        let tick = running.world.tick();
        assert!(
            now - energy < GIVEN_BACK * start,
            "{energy} -> {now} J at {tick}"
        );
        energy = now;
    }
    assert!(energy < 0.5 * start, "{start} -> {energy} J");
    let depth = running.world.penetration();
    assert!(depth < 0.5e-3, "{depth} m");
    for part in 0..parts {
        let place = running.place(part);
        let inside = place.x.abs().max(place.y.abs()) < 0.2 && place.z > 0.0;
        assert!(inside, "part {part} is at {place}");
    }
}

#[test]
fn a_falling_pile_only_loses_energy() {
    check(32, false, 2.0);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_large_falling_pile_only_loses_energy() {
    check(100, false, 5.0);
    check(100, true, 5.0);
}
