//! Thin things do not fall through thin things.

use cell_model::Shape;
use nalgebra::{Isometry3, Vector3};

use super::scene::{FRICTION, Scene, about, box_of, cylinder};

fn washers() -> [Shape; 4] {
    let disc = |radius_m: f64, height_m: f64| Shape::Cylinder { radius_m, height_m };
    [
        disc(0.006, 0.0016),
        box_of([0.06, 0.04, 0.002]),
        disc(0.0095, 0.001),
        Shape::Sphere { radius_m: 0.001 },
    ]
}

/// Forty things fall onto a sheet at 0.5 m, from `lowest` on, each `step` higher than the last (m).
fn check(thickness: f64, shapes: &[Shape], lowest: f64, step: f64, turned: f64) {
    let mut scene = Scene::new(false);
    let sheet = Isometry3::translation(0.0, 0.0, 0.5);
    scene.fixture("sheet", box_of([3.0, 2.0, thickness]), sheet, FRICTION);
    for index in 0..40 {
        let (column, row) = (f64::from(index % 10), f64::from(index / 10));
        let height = lowest + step * f64::from(index);
        let place = Isometry3::translation(-1.3 + 0.26 * column, -0.75 + 0.5 * row, height);
        let shape = shapes[index as usize % shapes.len()].clone();
        scene.object(shape, 0.01, place * about(Vector3::x_axis(), turned));
    }
    let mut running = scene.start();
    running.run(1.5);
    let through = (0..40).filter(|object| {
        let place = running.place(*object);
        let is_over = place.x.abs() < 1.5 && place.y.abs() < 1.0;
        is_over && place.z < 0.5
    });
    let through: Vec<_> = through
        .map(|object| (object, running.place(object)))
        .collect();
    assert!(through.is_empty(), "{thickness} m: {through:?}");
}

#[test]
fn no_thin_part_falls_through_a_sheet() {
    check(0.001, &washers(), 1.2, 0.0131, 0.0);
    check(0.001, &washers(), 2.0, 0.0317, 30.0);
    check(0.001, &[box_of([0.05; 3]), cylinder()], 2.0, 0.0317, 0.0);
}

#[test]
#[ignore = "slow: .ci/long"]
fn no_thin_part_falls_through_a_sheet_at_twenty_metres_per_second() {
    for thickness in [0.0005, 0.001, 0.002, 0.004] {
        for turned in [0.0, 15.0, 45.0, 90.0] {
            // 19.8 m/s at the sheet.
            check(thickness, &washers(), 16.0, 0.1, turned);
            check(thickness, &washers(), 0.8, 0.0173, turned);
        }
    }
}

#[test]
fn a_thin_plate_stops_on_a_thin_plate() {
    let mut scene = Scene::new(false);
    let plate = || box_of([0.1, 0.1, 0.001]);
    for index in 0..8 {
        let place = Isometry3::translation(0.3 * f64::from(index) - 1.0, 0.0, 0.0005);
        scene.object(plate(), 0.05, place);
        let above = 0.5 + 0.0731 * f64::from(index);
        scene.object(
            plate(),
            0.05,
            place * Isometry3::translation(0.0, 0.0, above),
        );
    }
    let mut running = scene.start();
    running.run(1.5);
    for pair in 0..8 {
        let (low, high) = (running.place(2 * pair), running.place(2 * pair + 1));
        assert!(high.z > low.z + 0.0005, "pair {pair}: {low}, {high}");
    }
}
