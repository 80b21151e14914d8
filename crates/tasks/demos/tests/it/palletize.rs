//! Palletizing without physics: the tool goes straight to its goal, suction holds the object at
//! the cup, the belt carries bins, and the jig turns bins that are released above it. The rows
//! Z are those of the behaviours' conformance table.

use crate::palletize_cell;

use ipc_types::GripperGoal;
use ipc_types::decision::{GoalKind, Outcome};
use palletize_cell::PalletCell;

#[test]
fn two_bins_of_either_lie_end_in_their_places() {
    let mut cell = PalletCell::new(2, &[false, true]);
    cell.run(20_000);
    assert_eq!(cell.outcome(), Outcome::Done, "{:#?}", cell.lines);
    assert_eq!(cell.placed(), [0, 1]);
    for words in [
        "<no flip> bin_01",
        "<flip> bin_02",
        "<palletizing complete>",
    ] {
        assert!(cell.said(words), "{words}: {:#?}", cell.lines);
    }
    assert_eq!(
        cell.flips,
        [1],
        "only what lies upside down goes over the jig"
    );
    let states = cell.states();
    let wanted = [
        "picking", "placing", "idle", "picking", "flipping", "picking", "placing", "done",
    ];
    assert_eq!(states, wanted);
}

#[test]
fn nobody_notices_a_task_that_is_restarted_before_every_decision() {
    let mut plain = PalletCell::new(2, &[true, false]);
    plain.run(20_000);
    let mut killed = PalletCell::new(2, &[true, false]);
    killed.restarts = true;
    killed.run(20_000);
    assert_eq!(killed.outcome(), Outcome::Done, "{:#?}", killed.lines);
    assert_eq!(killed.lines, plain.lines);
    assert_eq!(killed.now(), plain.now());
}

#[test]
fn suction_is_never_switched_off_with_a_bin_in_the_air() {
    let mut cell = PalletCell::new(1, &[true]);
    for _ in 0..10_000 {
        cell.step();
        let open = cell.decision.goals[0].gripper == GripperGoal::Open.code();
        let phase = cell.decision.phase.as_str().to_owned();
        assert!(
            !open || cell.held.is_none() || phase == "OpenSuctionGripper",
            "open in {phase}"
        );
        if cell.outcome() == Outcome::Done {
            return;
        }
    }
    panic!("never done: {:#?}", cell.lines);
}

#[test]
fn z09_the_belt_stops_after_a_second_and_only_then_the_arm_moves() {
    let mut cell = PalletCell::new(1, &[false]);
    cell.run_until("WaitForBin");
    let (began, home) = (cell.now(), cell.decision.goals[0].target.position);
    while cell.decision.phase.as_str() == "WaitForBin" {
        let late = cell.now() - began >= 1000;
        assert_eq!(cell.decision.io.conveyor_running == 0, late);
        assert_eq!(cell.decision.goals[0].target.position, home);
        cell.step();
    }
    assert_eq!(cell.now() - began, 1010);
    assert_eq!(cell.decision.phase.as_str(), "ReachToPick");
    assert_ne!(cell.decision.goals[0].target.position, home);
}

#[test]
fn z15_of_several_bins_the_first_on_the_belt_is_taken() {
    let mut cell = PalletCell::new(2, &[false, false]);
    cell.put(0, [0.1, 0.65, -0.151], false);
    cell.put(1, [-0.1, 0.45, -0.151], false);
    cell.run_until("ReachToPick");
    let target = cell.decision.goals[0].target.position;
    assert!((target[0] + 0.1).abs() < 1.0e-6, "{target:?}");
}

#[test]
fn z11_the_tool_backs_off_along_itself() {
    let mut cell = PalletCell::new(1, &[true]);
    cell.run_until("ReleaseFlipStationBin");
    let goal = cell.decision.goals[0];
    let z = goal.target.position[2];
    assert!((z - (-0.029 - 0.3 * 0.875)).abs() < 2.0e-3, "{z}");
    assert!(goal.has_posture == 1 && goal.approach_std_dev > 0.0);
    cell.run_until("OrientToHome");
    assert_eq!(cell.decision.goals[0].kind, GoalKind::Joints.code());
}

#[test]
fn a_bin_that_is_lost_on_the_way_is_taken_again() {
    let mut cell = PalletCell::new(1, &[false]);
    cell.run_until("ReachToPlace");
    cell.held = None;
    cell.put(0, [0.0, 0.4, -0.151], false);
    cell.run(20_000);
    assert_eq!(cell.outcome(), Outcome::Done, "{:#?}", cell.lines);
    assert!(
        cell.said("[lost] bin_01 while placing"),
        "{:#?}",
        cell.lines
    );
    assert_eq!(cell.decision.drops, 1);
}

#[test]
fn z07_a_bin_beside_its_place_is_taken_up_again() {
    let mut cell = PalletCell::new(1, &[false]);
    cell.run_until("OrientToHome");
    let [x, y, z] = cell.state.objects[0].pose.position;
    cell.put(0, [x - 0.05, y, z], false);
    cell.run(20_000);
    assert_eq!(cell.outcome(), Outcome::Done, "{:#?}", cell.lines);
    assert!(cell.said("[missed] bin_01 is not in its place"));
    assert_eq!(cell.placed(), [0]);
}

#[test]
fn a_bin_the_operator_set_down_counts() {
    let mut cell = PalletCell::new(1, &[false]);
    cell.put(0, [1.05, -0.62, -0.43], false);
    cell.turn(0, std::f64::consts::FRAC_PI_2);
    cell.run(100);
    assert_eq!(cell.outcome(), Outcome::Done, "{:#?}", cell.lines);
    assert_eq!(cell.states(), ["done"]);
}

#[test]
fn a_task_that_starts_with_a_bin_on_the_cup_goes_on_with_it() {
    let mut cell = PalletCell::new(1, &[false]);
    cell.run_until("SwingOut");
    cell.forget();
    cell.run(20_000);
    assert_eq!(cell.outcome(), Outcome::Done, "{:#?}", cell.lines);
    assert!(cell.said("[resume] bin_01 is on the cup"));
    assert_eq!(cell.decision.drops, 0);
}

#[test]
fn a_bin_suction_cannot_hold_ends_the_job_with_that_reason() {
    let mut cell = PalletCell::new(1, &[false]);
    cell.slippery = true;
    cell.run(30_000);
    assert_eq!(cell.outcome(), Outcome::Failed);
    assert_eq!(cell.decision.reason.as_str(), "bin_cannot_be_gripped");
}

#[test]
fn what_is_between_the_sides_counts_only_on_the_way_across() {
    let mut cell = PalletCell::new(1, &[false]);
    let between = cell.obstacle_bit("navigation_dome");
    let jig = cell.obstacle_bit("flip_sphere");
    cell.run_until("ReachToPick");
    let mask = cell.decision.goals[0].obstacle_mask;
    assert_eq!((mask & between, mask & jig), (0, jig));
    cell.run_until("ReachToPlace");
    assert_eq!(cell.decision.goals[0].obstacle_mask & between, between);
    cell.run_until("WaitAtPlace");
    assert_eq!(cell.decision.goals[0].obstacle_mask & between, 0);
}
