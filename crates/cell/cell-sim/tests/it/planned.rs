//! Arms that follow planned paths.

use cell_model::Data;
use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::arm::{NotReached, PlanState};
use ipc_types::operator::OperatorAction;
use ipc_types::{ArmStatus, OperatorRequest, Pose, Wire};

const DOWN: [f64; 4] = [0.0, 1.0, 0.0, 0.0];
const LEFT: [f64; 3] = [0.55, 0.25, 0.25];
const RIGHT: [f64; 3] = [0.55, -0.25, 0.25];

/// The shelf; with a planner or without.
fn shelf(planner: bool) -> OneProcess {
    let spec = template("reach-shelf", "follow");
    let mut cell = spec.load_cell_from(&Data::checkout()).unwrap();
    cell.arms[0].planner = planner;
    OneProcess::new(&demos::policies(), &spec, cell).unwrap()
}

fn send(cell: &mut OneProcess, position: [f64; 3]) {
    let mut request = OperatorRequest::zeroed_at_identity();
    request.action = OperatorAction::Target.code();
    request.pose = Pose {
        position,
        orientation_wxyz: DOWN,
    };
    cell.answer_request(&request);
}

/// Ticks until the arm is at `target` for good, `ticks` at most, and its least clearance (m).
fn go(cell: &mut OneProcess, target: [f64; 3], ticks: u64) -> (Option<u64>, f64) {
    let mut clearance = f64::INFINITY;
    for tick in 0..ticks {
        if tick == 0 {
            send(cell, target);
        }
        assert!(cell.tick().unwrap());
        let status = &cell.statuses()[0];
        clearance = clearance.min(status.min_clearance);
        let speed = cell.state().arms()[0].joint_velocities;
        let is_slow = speed.iter().all(|rate| rate.abs() < 0.02);
        if tick > 100 && status.position_error < 0.005 && is_slow {
            return (Some(tick), clearance);
        }
    }
    (None, clearance)
}

fn status(cell: &OneProcess) -> &ArmStatus {
    &cell.statuses()[0]
}

fn reason(cell: &OneProcess) -> NotReached {
    NotReached::from_code(status(cell).not_reached).unwrap()
}

#[test]
fn an_arm_with_a_planner_goes_from_one_compartment_to_the_other_and_touches_nothing() {
    let mut cell = shelf(true);
    assert!(go(&mut cell, LEFT, 10_000).0.is_some());
    for target in [RIGHT, LEFT, RIGHT] {
        let (ticks, clearance) = go(&mut cell, target, 10_000);
        assert!(ticks.is_some(), "{target:?}: {:?}", status(&cell));
        assert!(clearance > 0.0, "{clearance}");
        assert_eq!(reason(&cell), NotReached::None);
    }
    let arm = &cell.state().arms()[0];
    assert_eq!((arm.obstacle_contacts, arm.self_contacts), (0, 0));
}

#[test]
fn without_a_planner_it_stops_at_the_board_and_says_blocked() {
    let mut cell = shelf(false);
    assert!(go(&mut cell, LEFT, 10_000).0.is_some());
    let (ticks, clearance) = go(&mut cell, RIGHT, 12_000);
    assert!(ticks.is_none() && clearance > 0.0, "{ticks:?} {clearance}");
    assert_eq!(reason(&cell), NotReached::Blocked);
    assert_eq!(status(&cell).plan_state, PlanState::None.code());
}

fn drag(cell: &mut OneProcess, position: [f64; 3]) {
    let mut request = OperatorRequest::zeroed_at_identity();
    request.action = OperatorAction::Drag.code();
    request.pose.position = position;
    request.seconds = 1.5;
    cell.answer_request(&request);
}

#[test]
fn a_post_at_the_goal_is_named_and_the_arm_arrives_when_it_is_taken_away() {
    let mut cell = shelf(true);
    assert!(go(&mut cell, LEFT, 10_000).0.is_some());
    drag(&mut cell, [0.55, -0.25, 0.26]);
    let (ticks, clearance) = go(&mut cell, RIGHT, 12_000);
    assert!(ticks.is_none() && clearance > 0.0, "{ticks:?} {clearance}");
    assert_eq!(reason(&cell), NotReached::Blocked);
    assert_eq!(cell.state().arms()[0].obstacle_contacts, 0);
    drag(&mut cell, [0.1, -0.65, 0.26]);
    let arrived = go(&mut cell, RIGHT, 12_000).0;
    assert!(arrived.is_some(), "{:?}", status(&cell));
    assert_eq!(reason(&cell), NotReached::None);
}

#[test]
fn a_post_that_is_dragged_into_the_path_is_planned_around() {
    let mut cell = shelf(true);
    assert!(go(&mut cell, LEFT, 10_000).0.is_some());
    send(&mut cell, RIGHT);
    for _ in 0..1_000 {
        cell.tick().unwrap();
    }
    assert_eq!(status(&cell).plan_state, PlanState::Led.code());
    let answered = status(&cell).answered_plan;
    // Held in the air, before the arm. From 0.65 m it lands upright at the goal.
    drag(&mut cell, [0.55, -0.3, 0.75]);
    let (ticks, clearance) = go(&mut cell, RIGHT, 12_000);
    assert!(ticks.is_some(), "{:?}", status(&cell));
    assert!(clearance > 0.0, "{clearance}");
    assert_eq!(cell.state().arms()[0].obstacle_contacts, 0);
    assert!(status(&cell).answered_plan > answered);
}

#[test]
fn a_goal_beyond_reach_and_one_in_a_board_are_named_with_a_planner_and_without() {
    for planner in [true, false] {
        let mut cell = shelf(planner);
        for (target, named) in [
            ([1.5, 0.25, 0.3], NotReached::Unreachable),
            ([0.55, 0.0, 0.3], NotReached::Blocked),
        ] {
            assert!(go(&mut cell, target, 10_000).0.is_none());
            assert_eq!(reason(&cell), named, "{planner}: {:?}", status(&cell));
        }
    }
}

#[test]
fn a_plan_in_flight_and_one_that_is_followed_are_in_a_snapshot() {
    let mut cell = shelf(true);
    go(&mut cell, LEFT, 10_000);
    send(&mut cell, RIGHT);
    let mut seen = [false; 2];
    for _ in 0..20 {
        for _ in 0..17 {
            cell.tick().unwrap();
        }
        let state = status(&cell).plan_state;
        seen[0] |= state == PlanState::Requested.code();
        seen[1] |= state == PlanState::Led.code();
        let saved = cell.snapshot().unwrap();
        let mut other = shelf(true);
        other.restore(&saved).unwrap();
        for _ in 0..60 {
            cell.tick().unwrap();
            other.tick().unwrap();
            assert_eq!(status(&cell).as_bytes(), status(&other).as_bytes());
        }
        cell.restore(&saved).unwrap();
    }
    assert_eq!(seen, [true; 2]);
}

/// The shelf with a solid box of `size_m` at `position` (m).
fn with_box(
    planner: bool,
    size_m: [f64; 3],
    position: [f64; 3],
) -> Result<OneProcess, cell_sim::SimError> {
    let spec = template("reach-shelf", "follow");
    let mut cell = spec.load_cell_from(&Data::checkout()).unwrap();
    cell.arms[0].planner = planner;
    let mut fixture = cell.fixtures[0].clone();
    "box".clone_into(&mut fixture.name);
    fixture.shape = cell_model::Shape::Box { size_m };
    fixture.pose = nalgebra::Isometry3::translation(position[0], position[1], position[2]);
    (fixture.solid, fixture.obstacle) = (true, true);
    cell.fixtures.push(fixture);
    OneProcess::new(&demos::policies(), &spec, cell)
}

#[test]
fn an_arm_that_starts_in_an_obstacle_is_refused_with_the_link_and_the_remedy() {
    let tool = shelf(true).state().arms()[0].tcp.position;
    // Around the base, and around the hand.
    for (size, position) in [([0.4; 3], [0.0, 0.0, 0.2]), ([0.3; 3], tool)] {
        let error = with_box(true, size, position).err().unwrap().to_string();
        for part in [
            "arm 'arm' starts",
            "fixture 'box'",
            "link 'panda_",
            "solid = false",
        ] {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}

#[test]
fn an_arm_that_starts_against_an_obstacle_leaves_it_and_arrives() {
    let [x, y, z] = shelf(true).state().arms()[0].tcp.position;
    for planner in [true, false] {
        let mut cell = with_box(planner, [0.1; 3], [x, y, z - 0.05]).unwrap();
        assert!(go(&mut cell, RIGHT, 8_000).0.is_some(), "{planner}");
    }
}

#[test]
fn a_target_that_is_no_number_moves_nothing() {
    let (mut cell, mut other) = (shelf(true), shelf(true));
    for position in [
        [f64::NAN, 0.0, 0.3],
        [0.5, f64::INFINITY, 0.3],
        [1e300, 0.0, 0.0],
    ] {
        send(&mut cell, position);
        for _ in 0..500 {
            cell.tick().unwrap();
            other.tick().unwrap();
        }
    }
    let joints = |cell: &OneProcess| cell.state().arms()[0].joint_positions;
    assert_eq!(joints(&cell), joints(&other));
}
