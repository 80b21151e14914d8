//! Contacts of the arm.

use cell_model::Shape;
use nalgebra::{Isometry3, Vector3};

use super::hold::{CELL, Hold};
use crate::arm::touches::Touched;

#[test]
fn the_face_of_the_cup_and_the_side_of_its_tube_are_told_apart() {
    let mut hold = Hold::new(0.6, [0.0, 0.0], 0.0005, 0.0);
    hold.suction = 0;
    hold.run(1);
    let contacts = hold.world.arm_contacts(0);
    assert_eq!(contacts.len(), 1, "{contacts:?}");
    assert_eq!(
        (contacts[0].link, contacts[0].with),
        (6, Touched::Object(0))
    );
    assert!(contacts[0].at_cup && contacts[0].depth < 0.0);
    // Beside the tube, which has a radius of 20 mm.
    let mut hold = Hold::new(0.6, [0.0705, 0.0], -0.1, 0.0);
    hold.suction = 0;
    hold.run(1);
    let contacts = hold.world.arm_contacts(0);
    assert_eq!(contacts.len(), 1, "{contacts:?}");
    assert!(!contacts[0].at_cup, "{contacts:?}");
    // The held object does not count; after its release it does.
    let mut hold = Hold::new(0.6, [0.0, 0.0], 0.0005, 0.0);
    hold.run(20);
    assert_eq!(hold.gripper().attached, 1);
    assert_eq!(hold.world.arm_contacts(0), []);
    hold.suction = 0;
    hold.run(2);
    assert_eq!(hold.world.arm_contacts(0).len(), 1);
}

#[test]
fn a_fixture_is_told_by_its_place_among_the_solid_ones() {
    let mut hold = Hold::with(CELL, |cell, cup| {
        cell.objects[0].pose = Isometry3::translation(-2.0, 0.0, 0.0);
        let mut ghost = cell.fixtures[0].clone();
        ghost.solid = false;
        ghost.pose = Isometry3::from(cup);
        let mut table = cell.fixtures[0].clone();
        table.shape = Shape::Box { size_m: [0.1; 3] };
        table.pose = Isometry3::from(cup + Vector3::new(0.0, 0.0, -0.051));
        cell.fixtures.insert(0, ghost);
        cell.fixtures.push(table);
    });
    hold.run(1);
    let contacts = hold.world.arm_contacts(0);
    let fixtures: Vec<_> = contacts.iter().map(|contact| contact.with).collect();
    assert_eq!(fixtures, [Touched::Fixture(1)], "{contacts:?}");
    assert_eq!(hold.world.arm_contacts(1), []);
}
