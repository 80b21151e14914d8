//! The cell's equipment as the task and the operator meet it: belt, supply,
//! dispenser, light barriers, and what fell out.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "a test may fail"
)]

use crate::plc;

use ipc_types::equipment::SupplyRefusal;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::world::{OBJECT_ASLEEP, OBJECT_ENABLED};
use nalgebra::Vector3;
use plc::{BINS, PARTS, Plc, TRAY};

#[test]
fn the_belt_runs_as_long_as_it_is_told() {
    let mut plc = Plc::new(1);
    plc.io.add_bin = 1;
    plc.run(1_500);
    assert_eq!(plc.state().equipment.conveyor_speed, 0.0);
    let start = plc.position(0);
    plc.io.conveyor_running = 1;
    plc.run(500);
    let before = plc.position(0);
    plc.run(1_000);
    let way = plc.position(0) - before;
    assert!((way.y + 0.3).abs() < 4.0e-3, "0.3 m in a second: {way}");
    assert!(way.x.abs() < 1.0e-3 && way.z.abs() < 1.0e-4, "{way}");
    assert!((plc.state().equipment.conveyor_speed - 0.3).abs() < 1e-12);
    assert!(before.y < start.y);
    // The task dies: its last word counts for its age limit.
    plc.silent = true;
    plc.run(cell_model::stop::DECISION_AGE_FIFO_TICKS);
    assert_eq!(plc.state().equipment.conveyor_speed, 0.3);
    plc.run(300);
    assert_eq!(plc.state().equipment.conveyor_speed, 0.0);
    let rest = plc.position(0);
    plc.run(1_000);
    assert!((plc.position(0) - rest).norm() < 1.0e-5);
}

#[test]
fn the_belt_does_not_follow_a_decision_about_the_scene_before_a_reset() {
    let mut plc = Plc::new(1);
    plc.io.conveyor_running = 1;
    plc.run(504);
    assert!((plc.state().equipment.conveyor_speed - 0.3).abs() < 1e-12);
    assert_eq!(plc.ask(OperatorAction::Reset, 0).0, ReplyCode::Accepted);
    // The decision of tick 500 is the newest one until tick 510.
    for _ in 505..510 {
        plc.run(1);
        assert_eq!(plc.state().equipment.conveyor_speed, 0.0);
    }
    plc.run(1);
    assert!((plc.state().equipment.conveyor_speed - 0.3).abs() < 1e-12);
}

#[test]
fn a_bin_that_slept_on_the_belt_goes_on_with_it() {
    let mut plc = Plc::new(1);
    plc.io.add_bin = 1;
    plc.run(4_000);
    assert_ne!(plc.state().objects[0].flags & OBJECT_ASLEEP, 0);
    let start = plc.position(0);
    plc.io.conveyor_running = 1;
    plc.run(1_000);
    assert!(plc.position(0).y < start.y - 0.2);
}

#[test]
fn bins_come_one_by_one_until_enough_wait_and_the_sensor_sees_them() {
    let mut plc = Plc::new(3);
    let enabled = |plc: &Plc| {
        let state = plc.state();
        let bins = state.objects().iter().take(BINS);
        bins.filter(|bin| bin.flags & OBJECT_ENABLED != 0).count()
    };
    plc.run(10);
    assert_eq!(enabled(&plc), 0);
    plc.io.add_bin += 3;
    plc.io.conveyor_running = 1;
    plc.run(20);
    assert_eq!(enabled(&plc), 1);
    plc.run(900);
    assert_eq!(enabled(&plc), 1, "the supply cools down");
    plc.run(8_000);
    // Two may wait, the third comes when there is room.
    assert_eq!(enabled(&plc), 2);
    let state = plc.state().equipment;
    assert_eq!((state.bins_supplied, state.supply_refusals), (2, 0));
    assert_eq!(
        state.sensors[0], 1,
        "the first bin is at the end of the belt"
    );
    let reply = plc.ask(OperatorAction::AddBin, 0);
    assert_eq!(reply.0, ReplyCode::OutOfRange);
    assert!(reply.1.contains("wait on the belt"), "{}", reply.1);
    let state = plc.state().equipment;
    assert_eq!(
        (state.supply_refusals, state.supply_refusal),
        (1, SupplyRefusal::TooManyWaiting.code())
    );
    // A user takes the first away: the third comes.
    plc.drag(0, [1.7, -0.3, 0.4], 5.0);
    plc.run(6_000);
    assert_eq!(enabled(&plc), 3);
}

#[test]
fn a_bin_on_a_shelf_above_the_belt_does_not_wait_on_it() {
    let mut plc = Plc::with(3, |cell| {
        let mut shelf = cell.fixtures[0].clone();
        shelf.name = "shelf".to_owned();
        let size_m = [0.5, 0.5, 0.02];
        shelf.shape = cell_model::Shape::Box { size_m };
        shelf.pose = nalgebra::Isometry3::translation(1.2, 0.3, 0.6);
        cell.fixtures.push(shelf);
    });
    plc.io.add_bin += 1;
    plc.run(1_500);
    // Up, and over the shelf before the first drag ends.
    plc.drag(0, [1.2, 1.4, 0.9], 5.0);
    plc.run(1_000);
    plc.drag(0, [1.2, 0.3, 0.72], 5.0);
    plc.run(6_000);
    assert!(plc.position(0).z > 0.6, "{}", plc.position(0));
    plc.io.conveyor_running = 1;
    plc.io.add_bin += 2;
    plc.run(6_000);
    assert_eq!(plc.state().equipment.bins_supplied, 3);
}

#[test]
fn the_seed_turns_bins_over_and_the_operator_may_ask_for_it() {
    let up = |plc: &Plc, bin: usize| (plc.pose(bin).rotation * Vector3::z()).z;
    let mut turned = 0;
    for seed in 0..16 {
        let mut plc = Plc::new(seed);
        plc.io.add_bin = 1;
        plc.run(1_500);
        let z = up(&plc, 0);
        assert!(z.abs() > 0.999, "it lies flat: {z}");
        turned += u32::from(z < 0.0);
        let mut other = Plc::new(seed);
        other.run(700);
        assert_eq!(other.ask(OperatorAction::AddBin, 1).0, ReplyCode::Accepted);
        other.run(1_500);
        assert!(up(&other, 0) < -0.999);
        assert_eq!(other.state().panel.add_bin, 1);
    }
    assert!((3..=13).contains(&turned), "half of them: {turned}");
}

#[test]
fn only_the_bins_of_the_job_come_and_an_impossible_request_is_counted() {
    let mut plc = Plc::with(5, |cell| cell.limit_bins(1).unwrap());
    plc.io.add_bin += 2;
    plc.run(4_000);
    let state = plc.state().equipment;
    assert_eq!((state.bins_supplied, state.supply_refusals), (1, 1));
    assert_eq!(state.supply_refusal, SupplyRefusal::NoneLeft.code());
}

#[test]
fn what_falls_out_is_put_away_and_can_come_again() {
    let mut plc = Plc::new(3);
    let parked = plc.position(0);
    plc.io.add_bin = 1;
    plc.run(500);
    plc.drag(0, [2.4, 1.0, 0.5], 6.0);
    plc.run(8_000);
    let state = plc.state();
    assert_eq!(state.equipment.cleared, 1);
    assert_eq!(state.objects[0].flags & OBJECT_ENABLED, 0);
    assert!((plc.position(0) - parked).norm() < 1.0e-9);
    plc.io.add_bin += 1;
    plc.run(100);
    assert_ne!(plc.state().objects[0].flags & OBJECT_ENABLED, 0);
}

#[test]
fn what_rolls_off_the_floor_is_lost_until_a_reset_and_nothing_else() {
    let mut plc = Plc::new(3);
    let start = plc.position(TRAY);
    plc.drag(TRAY, [-2.6, 0.8, 0.2], 6.0);
    plc.run(10_000);
    let state = plc.state();
    assert_eq!((plc.lost(), state.equipment.cleared), (1, 1));
    let words = plc.lost_words();
    assert!(
        words.contains("'tray'") && words.contains("-0.50 m"),
        "{words}"
    );
    let tray = state.objects[TRAY];
    assert_eq!(
        (tray.flags & OBJECT_ENABLED, tray.twist.linear),
        (0, [0.0; 3])
    );
    let place = plc.position(TRAY);
    assert!(place.z < -0.5 && place.z > -0.6, "where it left: {place}");
    plc.run(100);
    assert_eq!(plc.position(TRAY), place);
    plc.ask(OperatorAction::Reset, 0);
    assert_eq!(plc.lost(), 0);
    assert!((plc.position(TRAY) - start).norm() < 1.0e-6);
}

#[test]
fn a_cell_without_a_height_to_clear_below_loses_what_falls_all_the_same() {
    let mut plc = Plc::with(3, |cell| cell.clear_below_m = None);
    plc.drag(TRAY, [-2.6, 0.8, 0.2], 6.0);
    plc.run(10_000);
    assert_eq!(plc.lost(), 1);
    // The floor is 0.1 m thick.
    assert!((-1.2..-1.1).contains(&plc.position(TRAY).z));
}

#[test]
fn parts_fall_into_the_tray_and_stay_there_until_none_is_left() {
    let mut plc = Plc::new(4);
    plc.run(20);
    plc.io.drop_parts += 1;
    plc.run(200);
    let state = plc.state().equipment;
    assert_eq!((state.parts_dropped, state.parts_waiting), (3, 0));
    assert_eq!(plc.ask(OperatorAction::DropParts, 5).0, ReplyCode::Accepted);
    plc.run(20);
    let state = plc.state();
    assert_eq!(
        (state.equipment.parts_dropped, state.equipment.parts_waiting),
        (6, 2)
    );
    assert_eq!(state.panel.drop_parts, 1);
    plc.run(4_000);
    assert_eq!(plc.state().equipment.parts_dropped, 8);
    assert_eq!(inside(&plc), 8);
    let reply = plc.ask(OperatorAction::DropParts, 9);
    assert!(reply.1.contains("4 are left"), "{}", reply.1);
    assert_eq!(plc.ask(OperatorAction::DropParts, 4).0, ReplyCode::Accepted);
    plc.run(4_000);
    assert_eq!(inside(&plc), PARTS);
    let reply = plc.ask(OperatorAction::DropParts, 0);
    assert!(reply.1.contains("no part is left"), "{}", reply.1);
    assert!(plc.penetration() < 2.0e-3, "{}", plc.penetration());
}

/// Parts within the tray.
fn inside(plc: &Plc) -> usize {
    let tray = plc.position(TRAY);
    let parts = (BINS..BINS + PARTS).filter(|part| {
        let from = plc.position(*part) - tray;
        from.x.abs() < 0.15 && from.y.abs() < 0.1 && from.z.abs() < 0.075
    });
    parts.count()
}

#[test]
fn a_reset_brings_everything_back_and_what_was_asked_before_does_not_come() {
    let mut plc = Plc::new(6);
    let before = plc.state();
    plc.run(10);
    (plc.io.add_bin, plc.io.drop_parts) = (2, 4);
    plc.run(700);
    plc.ask(OperatorAction::Reset, 0);
    let state = plc.state();
    for (object, before) in state.objects().iter().zip(before.objects()) {
        let way = Vector3::from(object.pose.position) - Vector3::from(before.pose.position);
        assert_eq!(object.flags, before.flags);
        assert!(way.norm() < 1.0e-4, "{way}");
    }
    assert_eq!(state.equipment.parts_waiting, 0);
    plc.run(100);
    assert_eq!(plc.state().equipment.bins_supplied, 0);
}

#[test]
fn two_runs_and_a_restored_one_are_equal_to_the_bit() {
    let job = |plc: &mut Plc| {
        plc.io.conveyor_running = 1;
        plc.io.add_bin += 1;
        plc.run(700);
        plc.io.drop_parts += 1;
        plc.run(800);
    };
    let mut first = Plc::new(8);
    let mut second = Plc::new(8);
    job(&mut first);
    job(&mut second);
    assert_eq!(first.state(), second.state());
    let mut third = Plc::new(8);
    third.restore_from(&first);
    for tick in 0..1_500 {
        first.run(1);
        third.run(1);
        assert_eq!(first.state(), third.state(), "{tick}");
    }
    assert_ne!(first.state().state_hash, Plc::new(9).state().state_hash);
}

#[test]
fn a_refused_bin_is_told_when_it_may_come() {
    let mut plc = Plc::new(0);
    plc.run(10);
    assert_eq!(plc.ask(OperatorAction::AddBin, 0).0, ReplyCode::Accepted);
    plc.run(100);
    let (code, why) = plc.ask(OperatorAction::AddBin, 0);
    assert_eq!(code, ReplyCode::OutOfRange);
    assert!(
        why.contains("can be added at") && why.contains(" s, in "),
        "{why}"
    );
    let left: f64 = why
        .split(" s, in ")
        .nth(1)
        .unwrap()
        .trim_end_matches(" s")
        .parse()
        .unwrap();
    let waits = (0..10_000).take_while(|tick| f64::from(*tick) * 1.0e-3 < left);
    waits.for_each(|_| plc.run(1));
    let (_, why) = plc.ask(OperatorAction::AddBin, 0);
    assert!(!why.contains("can be added at"), "{why}");
}

#[test]
fn a_reset_scene_counts_its_own_bins_and_parts() {
    let mut plc = Plc::new(3);
    plc.run(10);
    plc.ask(OperatorAction::AddBin, 0);
    plc.ask(OperatorAction::AddBin, 0);
    plc.ask(OperatorAction::DropParts, 3);
    plc.run(2_000);
    let before = plc.state().equipment;
    let counted = (
        before.bins_supplied,
        before.supply_refusals,
        before.parts_dropped,
    );
    assert_eq!(counted, (1, 1, 3));
    assert_eq!(plc.ask(OperatorAction::Reset, 0).0, ReplyCode::Accepted);
    let after = plc.state().equipment;
    let counted = (
        after.bins_supplied,
        after.supply_refusals,
        after.parts_dropped,
    );
    assert_eq!(counted, (0, 0, 0));
    assert_eq!((after.supply_refusal, after.cleared), (0, 0));
}
