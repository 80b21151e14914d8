//! The suction gripper measures its load, and releases one that is too large.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may fail, and say what it measured"
)]

mod hold;
mod moving;
mod touching;

use cell_model::Shape;
use ipc_types::OperatorRequest;
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal};
use ipc_types::operator::OperatorAction;
use ipc_types::world::OBJECT_TOUCHED;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use self::hold::{CELL, Hold};
use crate::engine::convert;
use crate::world::World;

#[test]
fn the_read_out_is_the_weight_on_the_axis_and_the_lever_off_it() {
    for mass in [0.2, 0.6, 2.0, 5.0] {
        let mut hold = Hold::new(mass, [0.0, 0.0], 0.004, 0.0);
        hold.run(1_500);
        let (gripper, weight) = (hold.gripper(), mass * 9.81);
        assert_eq!((gripper.attached, gripper.held_object), (1, 1), "{mass} kg");
        let share = gripper.suction_force / weight;
        assert!((share - 1.0).abs() < 0.01, "{mass} kg: {share}");
        assert!(gripper.suction_torque < 0.02, "{}", gripper.suction_torque);
        assert!((gripper.load - weight / 50.0).abs() < 0.01);
        assert_ne!(hold.state().objects[0].flags & OBJECT_TOUCHED, 0);
    }
    for mass in [0.6, 2.0] {
        let mut hold = Hold::new(mass, [0.02, 0.01], 0.004, 0.0);
        hold.run(1_500);
        let torque = mass * 9.81 * (0.02_f64.powi(2) + 0.01_f64.powi(2)).sqrt();
        let share = hold.gripper().suction_torque / torque;
        assert!((share - 1.0).abs() < 0.01, "{mass} kg: {share}");
    }
}

#[test]
fn slowly_loaded_it_breaks_at_its_limits_by_weight() {
    let down = -Vector3::z();
    for (arm, limit, value) in [
        (Vector3::zeros(), BreakLimit::Force, 50.0),
        (Vector3::new(0.04, 0.0, 0.0), BreakLimit::Force, 50.0),
        (Vector3::new(0.25, 0.0, 0.0), BreakLimit::Torque, 5.0),
        (Vector3::new(0.0, -0.4, 0.0), BreakLimit::Torque, 5.0),
    ] {
        let mut hold = Hold::new(0.6, [0.0, 0.0], 0.003, 0.0);
        hold.run(500);
        let mut pull = 0.0;
        while hold.gripper().breaks == 0 {
            pull += 0.005;
            assert!(pull < 80.0, "{limit:?}: it holds forever");
            hold.pull(down * pull, arm);
        }
        let gripper = hold.gripper();
        assert_eq!(gripper.break_limit, limit.code(), "{arm}");
        assert_eq!(gripper.break_cause, BreakCause::Weight.code(), "{arm}");
        let at = match limit {
            BreakLimit::Torque => pull * arm.norm(),
            _ => pull + 0.6 * 9.81,
        };
        assert!((at / value - 1.0).abs() < 0.1, "{limit:?}: {at}");
        assert_eq!((gripper.attached, gripper.held_object), (0, 0));
    }
}

#[test]
fn a_light_load_is_held_for_a_minute() {
    let mut hold = Hold::new(0.6, [0.02, 0.0], 0.004, 0.0);
    hold.run(1_000);
    let place = |hold: &Hold| Vector3::from(hold.state().objects[0].pose.position);
    let a = place(&hold);
    hold.run(60_000);
    let b = place(&hold);
    assert_eq!(hold.gripper().attached, 1);
    assert!((a - b).norm() < 1.0e-5, "it creeps {}", (a - b).norm());
}

#[test]
fn a_cup_that_is_pressed_on_holds() {
    let mut hold = Hold::new(0.6, [0.0, 0.0], 0.0, 0.0);
    hold.run(10);
    for _ in 0..500 {
        hold.pull(Vector3::new(0.0, 0.0, 80.0), Vector3::zeros());
    }
    let pressed = hold.gripper();
    assert_eq!((pressed.attached, pressed.breaks), (1, 0), "{pressed:?}");
    assert!(pressed.load < 0.1, "load {}", pressed.load);
}

#[test]
fn a_blow_breaks_it_as_one() {
    let mut hold = Hold::new(0.6, [0.0, 0.0], 0.004, 0.0);
    hold.run(500);
    for _ in 0..20 {
        hold.pull(Vector3::new(0.0, 0.0, -120.0), Vector3::zeros());
    }
    let gripper = hold.gripper();
    assert_eq!(
        (gripper.breaks, gripper.attached, gripper.suction),
        (1, 0, 1)
    );
    assert_eq!(gripper.break_cause, BreakCause::Impulse.code());
    assert!(gripper.peak_force > 100.0, "{}", gripper.peak_force);
    // A spike of one tick is none: the mean of 17 ticks counts.
    let mut hold = Hold::new(0.6, [0.0, 0.0], 0.004, 0.0);
    hold.run(500);
    hold.pull(Vector3::new(0.0, 0.0, -300.0), Vector3::zeros());
    hold.pull(Vector3::zeros(), Vector3::zeros());
    hold.run(100);
    let gripper = hold.gripper();
    assert_eq!((gripper.breaks, gripper.attached), (0, 1));
    assert!(gripper.peak_force > 200.0, "{}", gripper.peak_force);
}

#[test]
fn it_refuses_with_a_reason_until_it_is_switched_again() {
    for (offset, gap, tilt, why) in [
        ([0.0, 0.0], 0.015, 0.0, SuctionRefusal::NothingThere),
        ([0.5, 0.0], 0.005, 0.0, SuctionRefusal::NothingThere),
        ([0.0, 0.0], 0.005, 0.35, SuctionRefusal::TooOblique),
        ([0.04, 0.0], 0.005, 0.0, SuctionRefusal::TooOblique),
    ] {
        let mut hold = Hold::new(0.6, offset, gap, tilt);
        hold.run(3);
        let gripper = hold.gripper();
        assert_eq!(
            (gripper.refusals, gripper.refusal),
            (1, why.code()),
            "{offset:?}"
        );
        assert_eq!((gripper.attached, gripper.suction), (0, 1));
    }
    let mut hold = Hold::new(0.6, [0.0, 0.0], 0.015, 0.0);
    hold.run(3);
    let (engine, arms) = hold.world.engine_and_arms();
    let tcp = arms.tcp(engine, 0).unwrap().translation.vector;
    let near = convert::to_pose(&Isometry3::translation(tcp.x, tcp.y, tcp.z - 0.054));
    let put = |hold: &mut Hold| {
        let (engine, _) = hold.world.engine_and_arms();
        let body = engine.object_mut(0).unwrap();
        body.set_linvel(rapier3d_f64::math::Vector::ZERO, true);
        body.set_position(near, true);
    };
    put(&mut hold);
    hold.run(2);
    assert_eq!(hold.gripper().attached, 0);
    hold.suction = 0;
    put(&mut hold);
    hold.run(2);
    hold.suction = 1;
    hold.run(2);
    assert_eq!((hold.gripper().attached, hold.gripper().refusals), (1, 1));
    hold.suction = 0;
    hold.run(2);
    assert_eq!((hold.gripper().attached, hold.gripper().breaks), (0, 0));
}

#[test]
fn what_stands_still_is_refused_as_such() {
    let mut cell = Hold::new(0.6, [0.0, 0.0], 0.004, 0.0).cell;
    let mut fixture = cell.fixtures[0].clone();
    fixture.pose = cell.objects[0].pose;
    fixture.shape = Shape::Box { size_m: [0.1; 3] };
    cell.fixtures.push(fixture);
    cell.objects[0].pose = Isometry3::translation(-2.0, 0.0, 0.0);
    let mut hold = Hold::new(0.6, [0.0, 0.0], 0.004, 0.0);
    hold.world = World::new(&cell).unwrap();
    hold.run(2);
    let gripper = hold.gripper();
    assert_eq!(gripper.refusal, SuctionRefusal::NotMovable.code());
}

#[test]
fn a_snapshot_with_something_attached_goes_on_bit_for_bit() {
    let mut hold = Hold::new(2.0, [0.02, 0.01], 0.004, 0.0);
    hold.run(300);
    let mut copy = Hold::new(2.0, [0.02, 0.01], 0.004, 0.0);
    copy.world.restore(&hold.world.snapshot()).unwrap();
    copy.seq = hold.seq;
    for tick in 0..600 {
        // The pull breaks the grip on the way.
        let down = Vector3::new(0.0, 0.0, -0.2 * f64::from(tick));
        hold.pull(down, Vector3::zeros());
        copy.pull(down, Vector3::zeros());
        assert_eq!(hold.state(), copy.state(), "{tick}");
    }
    assert_eq!(hold.gripper().breaks, 1);
}

/// The content of a held bin.
const PARTS: &str = r#"
[[object]]
name = "part"
count = 60
shape = { kind = "box", size_m = [0.03, 0.03, 0.03] }
mass_kg = 0.1
friction = 0.6
position_m = [3.0, 3.0, 0.0]
parked = true
sleeps = true
colour = [0.5, 0.5, 0.5]

[dispenser]
objects = "part"
position_m = [0.0, 0.0, 0.0]
spread_m = [0.02, 0.03]
layer_m = 0.05
per_drop = 3
interval_s = 0.5
"#;

#[test]
fn parts_that_fall_into_a_held_bin_are_felt_until_it_falls_and_spills() {
    let mut hold = Hold::with(&format!("{CELL}{PARTS}"), |cell, cup| {
        cell.objects[0].mass = 0.6;
        cell.objects[0].shape = Shape::Bin {
            size_m: [0.3, 0.2, 0.147],
            wall_m: 0.004,
        };
        let centre = cup + Vector3::new(0.0, 0.0, 0.5 * 0.147 - 0.004 - 0.004);
        cell.objects[0].pose = Isometry3::from_parts(centre.into(), UnitQuaternion::identity());
        let dispenser = cell.dispenser.as_mut().unwrap();
        // From so low that three parts at once do not break it by their impulse.
        dispenser.position_m = (cup + Vector3::new(-0.09, 0.0, 0.17)).into();
    });
    hold.run(300);
    assert_eq!(hold.gripper().attached, 1, "{:?}", hold.gripper());
    let height = hold.state().objects[0].pose.position[2];
    let mut request = OperatorRequest::zeroed_at_identity();
    request.count = 12;
    let reply = hold
        .world
        .execute_request(OperatorAction::DropParts, &request);
    assert_eq!(reply.1, "");
    hold.run(6_000);
    // It contains twelve parts.
    let gripper = hold.gripper();
    let share = gripper.suction_force / ((0.6 + 12.0 * 0.1) * 9.81);
    assert!((share - 1.0).abs() < 0.02, "{share}");
    assert!(gripper.peak_force > 20.0 && gripper.suction_torque > 0.5);
    request.count = 40;
    hold.world
        .execute_request(OperatorAction::DropParts, &request);
    let mut ticks = 0;
    while hold.gripper().breaks == 0 {
        hold.run(10);
        ticks += 10;
        assert!(ticks < 30_000, "{:?}", hold.gripper());
    }
    let dropped = hold.state().equipment.parts_dropped;
    assert!(
        (15..=48).contains(&dropped),
        "{dropped} parts: {:?}",
        hold.gripper()
    );
    let gripper = hold.gripper();
    assert_ne!(gripper.break_limit, BreakLimit::None.code());
    assert_ne!(gripper.break_cause, BreakCause::None.code());
    println!("{dropped} parts, {gripper:?}");
    hold.run(3_000);
    let fallen = height - hold.state().objects[0].pose.position[2];
    assert!(fallen > 0.3, "it fell {fallen} m");
    assert_eq!(hold.gripper().attached, 0, "it has to be switched again");
}
