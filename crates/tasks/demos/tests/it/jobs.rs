//! Whole jobs, disturbed and not, with both policies.

use crate::common;

use common::{ALL, BLUE, BOTH, FakeCell, GREEN, RED, YELLOW, minus, norm};
use ipc_types::GripperGoal;
use ipc_types::decision::{GoalKind, Outcome};

#[test]
fn four_cubes_are_stacked_in_order_and_nothing_is_dropped() {
    for policy in ALL {
        for seed in 0..5 {
            let mut cell = FakeCell::new("franka-stack", policy, seed);
            cell.run_until(150.0, |c| {
                let told = c.decision.goals[0].gripper;
                let free = ["", "RELEASE", "RETRACT", "PRE_GRASP", "APPROACH", "DONE"];
                assert!(told != GripperGoal::Open.code() || free.contains(&c.phase()));
                c.outcome() == Outcome::Done
            });
            cell.assert_stacked();
            let wanted = [
                "stack red_cube",
                "stack blue_cube",
                "stack green_cube",
                "stack yellow_cube",
                "all stacked",
            ];
            assert_eq!(cell.decided(), wanted);
            let decision = &cell.decision;
            let counters = [
                decision.drops,
                decision.resyncs,
                decision.aborts,
                decision.recoveries,
            ];
            assert_eq!((counters, decision.phase_entry), ([0; 4], 33));
            assert_eq!(cell.state.arms[0].gripper.width, 0.08);
        }
    }
}

#[test]
fn the_log_names_the_phases_as_each_demo_does() {
    let mut fsm = FakeCell::stack("fsm");
    fsm.run_to_done();
    assert_eq!(fsm.count("[red_cube] LIFT done (settled)"), 1);
    assert_eq!(fsm.count("[red_cube] GRASP done (ok)"), 1);
    let mut ifelse = FakeCell::stack("ifelse");
    ifelse.run_to_done();
    assert_eq!(ifelse.count("[red_cube] phase 3 done (settled)"), 1);
    assert_eq!(ifelse.count("[yellow_cube] phase 6 done (ok)"), 1);
}

#[test]
fn both_policies_give_the_same_commands_for_the_same_disturbances() {
    let mut runs = BOTH.map(FakeCell::stack);
    for step in 0..6000 {
        for cell in &mut runs {
            match step {
                150 => cell.drag(RED, [0.4, -0.1, 0.025]),
                900 => cell.drag(RED, [0.5, 0.0, 0.025]),
                1200 => cell.drag(BLUE, [0.6, -0.2, 0.025]),
                _ => {}
            }
            cell.step();
        }
        let [fsm, ifelse] = &runs;
        assert_eq!(
            fsm.decision.goals, ifelse.decision.goals,
            "step {step}: {:#?}",
            fsm.lines
        );
    }
    runs[0].assert_stacked();
}

#[test]
fn the_bottom_cube_dragged_away_sends_the_held_one_back_and_comes_first() {
    for policy in ALL {
        for phase in ["GRASP", "LIFT", "TRANSPORT"] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until_carrying(BLUE, phase);
            cell.drag(RED, [0.42, 0.05, 0.025]);
            cell.run_until(60.0, |c| c.phase() == "RETRACT");
            let spawn = cell.cell.objects[BLUE].pose.translation.vector.into();
            assert!(
                norm(minus(cell.position(BLUE), spawn)) < 0.01,
                "{policy} {phase}"
            );
            cell.run_to_done();
            assert_eq!((cell.decision.aborts, cell.count("[abort]")), (1, 1));
            let order = [
                "stack red_cube",
                "stack blue_cube",
                "stack red_cube",
                "stack blue_cube",
            ];
            assert_eq!(cell.decided()[..4], order);
        }
    }
}

#[test]
fn a_cube_that_drifts_during_the_approach_makes_the_tree_restart_the_pick_up() {
    let mut cell = FakeCell::stack("bt");
    cell.run_until(60.0, |c| c.phase() == "APPROACH");
    cell.drag(RED, [0.35, 0.0, 0.025]);
    // The decision is published in the tick that fails, too.
    cell.step();
    assert_eq!((cell.phase(), cell.decision.resyncs), ("APPROACH", 1));
    cell.step();
    assert_eq!(cell.phase(), "PRE_GRASP");
    cell.run_to_done();
    assert_eq!(
        cell.count("[Approach] target drifted, restarting pickup"),
        1
    );
}

#[test]
fn a_cube_dragged_while_it_is_approached_restarts_the_pick_up() {
    // The tree looks for that in the approach only.
    for policy in BOTH {
        for phase in ["PRE_GRASP", "APPROACH"] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until(60.0, |c| c.phase() == phase);
            cell.drag(RED, [0.35, 0.0, 0.025]);
            cell.step();
            assert_eq!((cell.phase(), cell.decision.resyncs), ("PRE_GRASP", 1));
            cell.run_to_done();
            assert_eq!(cell.count("[resync] red_cube"), 1);
        }
    }
}

#[test]
fn a_cube_pulled_out_of_the_hand_is_let_go_and_picked_up_again() {
    for policy in ALL {
        for phase in ["LIFT", "TRANSPORT", "LOWER"] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until_carrying(GREEN, phase);
            cell.drag(GREEN, [0.35, -0.2, 0.025]);
            cell.step();
            let goal = cell.decision.goals[0];
            assert_eq!(
                (goal.kind, goal.gripper),
                (GoalKind::Hold.code(), GripperGoal::Open.code())
            );
            assert_eq!(cell.count("[drop] green_cube"), 1);
            cell.step();
            assert_eq!(
                (cell.phase(), cell.decided().last()),
                ("PRE_GRASP", Some(&"stack green_cube"))
            );
            cell.run_to_done();
            assert_eq!(cell.decision.drops, 1);
        }
    }
}

#[test]
fn a_cube_out_of_reach_is_waited_for_and_then_named() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until(60.0, |c| c.phase() == "APPROACH");
        cell.drag(RED, [1.0, 0.3, 0.025]);
        cell.run_until(1.0, |c| c.phase() == "HOLD");
        cell.run_until(9.5, |c| c.count("[wait] red_cube") == 1);
        cell.drag(RED, [0.4, 0.0, 0.025]);
        cell.run_until(1.0, |c| c.phase() == "PRE_GRASP");
        cell.drag(RED, [1.0, 0.3, 0.025]);
        cell.run_until(10.5, |c| c.outcome() == Outcome::Failed);
        assert_eq!(cell.decision.reason.as_str(), "cube_out_of_reach");
        let goal = cell.decision.goals[0];
        assert_eq!(
            (goal.kind, goal.gripper),
            (GoalKind::Hold.code(), GripperGoal::Keep.code())
        );
        cell.state.panel.task_start += 1;
        cell.drag(RED, [0.4, 0.0, 0.025]);
        cell.run_to_done();
    }
}

#[test]
fn phantom_grasps_end_in_a_named_outcome() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.slippery = true;
        cell.run_until(120.0, |c| c.outcome() == Outcome::Failed);
        assert_eq!(cell.decision.reason.as_str(), "cube_cannot_be_gripped");
        assert_eq!(cell.decision.drops, 5);
    }
}

#[test]
fn a_gripper_that_stays_shut_ends_in_a_named_outcome() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until_carrying(RED, "LOWER");
        cell.jammed = true;
        cell.run_until(60.0, |c| c.outcome() == Outcome::Failed);
        assert_eq!(cell.decision.reason.as_str(), "gripper_blocked");
    }
}

#[test]
fn a_cube_off_the_table_ends_in_a_named_outcome() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until_carrying(RED, "LIFT");
        cell.drag(YELLOW, [0.5, -1.2, 0.025]);
        cell.run_until(60.0, |c| c.outcome() == Outcome::Failed);
        assert_eq!(cell.decision.reason.as_str(), "cube_lost");
        assert_eq!(cell.placed(), [0], "the transfer under way is finished");
    }
}

#[test]
fn a_finished_stack_is_built_again_when_somebody_takes_it_apart() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_to_done();
        cell.drag(YELLOW, [0.4, -0.2, 0.025]);
        cell.step();
        assert_eq!(cell.outcome(), Outcome::Running);
        cell.run_to_done();
        assert_eq!(cell.count("all stacked"), 2);
        assert_eq!(cell.decision.recoveries, 1, "it was taken away once");
    }
}

#[test]
fn cubes_that_fell_onto_the_place_of_another_are_cleared_first() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_to_done();
        // The stack comes down by one layer: blue is at the place of red.
        cell.drag(RED, [0.4, -0.2, 0.025]);
        cell.run_to_done();
        let decided = cell.decided();
        assert_eq!(
            decided[5..8],
            ["clear yellow_cube", "clear green_cube", "clear blue_cube"]
        );
        // Four left their places, and three were cleared.
        assert_eq!(cell.decision.recoveries, 7);
    }
}

#[test]
fn a_cube_with_another_on_it_is_freed_first() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.drag(YELLOW, cell.position(RED).map(|c| c + 0.001));
        cell.state.objects[YELLOW].pose.position[2] = 0.075;
        cell.run_to_done();
        assert_eq!(cell.decided()[..2], ["clear yellow_cube", "stack red_cube"]);
    }
}

#[test]
fn a_lower_cube_pushed_aside_is_set_again_before_it_has_to_carry() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until(60.0, |c| c.decided().last() == Some(&"stack blue_cube"));
        cell.drag(RED, [0.573, 0.2, 0.025]);
        cell.drag(BLUE, [0.4, -0.1, 0.025]);
        cell.run_until(60.0, |c| c.phase() == "GRASP");
        cell.drag(BLUE, [0.4, -0.2, 0.025]);
        cell.run_to_done();
        assert_eq!(
            cell.decided()[..4],
            [
                "stack red_cube",
                "stack blue_cube",
                "stack red_cube",
                "stack blue_cube"
            ]
        );
    }
}

#[test]
fn fingers_do_not_go_where_a_neighbour_stands() {
    let mut cell = FakeCell::stack("fsm");
    let [x, y, z] = cell.position(RED);
    cell.drag(GREEN, [x, y - 0.055, z]);
    cell.run_until(60.0, |c| c.phase() == "GRASP");
    // Turned by about a quarter: the fingers come from the sides in x.
    let [_, c, s, _] = cell.decision.goals[0].target.orientation_wxyz;
    assert!((c.abs() - s.abs()).abs() < 0.2, "{c} {s}");
    cell.run_to_done();
}

#[test]
fn a_cube_dragged_to_the_place_of_the_held_one_is_cleared_before_it_is_tried_again() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until_carrying(RED, "LIFT");
        cell.drag(GREEN, [0.56, 0.22, 0.025]);
        cell.run_to_done();
        assert_eq!(
            cell.decided()[..3],
            ["stack red_cube", "clear green_cube", "stack red_cube"]
        );
        assert_eq!(cell.decision.aborts, 1);
    }
}

#[test]
fn a_cube_at_the_foot_of_the_stack_is_lifted_above_it_first() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until(100.0, |c| c.decided().last() == Some(&"stack yellow_cube"));
        cell.drag(YELLOW, [0.55, 0.29, 0.025]);
        cell.run_until(10.0, |c| c.phase() == "GRASP");
        let [_, c, s, _] = cell.decision.goals[0].target.orientation_wxyz;
        assert!(
            (c - s.abs()).abs() < 0.2,
            "the hand stands along the stack's side"
        );
        cell.run_until(10.0, |c| c.phase() == "LIFT");
        let [x, y, z] = cell.decision.goals[0].target.position;
        assert_eq!([x, y], cell.position(YELLOW)[..2]);
        assert!(
            (z - 0.275).abs() < 1e-9,
            "as high as the place in the stack: {z}"
        );
        cell.run_to_done();
        assert_eq!(cell.decision.recoveries, 0);
    }
}
