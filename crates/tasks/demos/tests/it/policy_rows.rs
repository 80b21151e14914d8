//! Rows of the policies' conformance table that single steps show; the others are beside the
//! code and in `jobs.rs`.

use crate::common;

use common::{ALL, BLUE, FakeCell, GREEN, RED, YELLOW};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::trace::TraceKind;

fn on_their_goals(policy: &str) -> FakeCell {
    let mut cell = FakeCell::stack(policy);
    for (cube, level) in [(RED, 0.0), (BLUE, 1.0), (GREEN, 2.0), (YELLOW, 3.0)] {
        cell.state.objects[cube].pose.position = [0.55, 0.20, 0.025 + 0.05 * level];
    }
    cell
}

#[test]
fn p01_all_cubes_at_their_goals_is_done_without_a_phase() {
    for policy in ALL {
        let mut cell = on_their_goals(policy);
        cell.step();
        assert_eq!((cell.outcome(), cell.phase()), (Outcome::Done, "DONE"));
        assert_eq!(cell.decision.goals[0].kind, GoalKind::Hold.code());
        assert_eq!(
            (cell.decision.phase_entry, cell.placed()),
            (1, &[0, 1, 2, 3][..])
        );
    }
}

#[test]
fn p03_exactly_the_tolerance_away_is_not_at_the_goal() {
    for policy in ALL {
        for (offset, outcome) in [
            (0.0249, Outcome::Done),
            (0.025, Outcome::Running),
            (0.0251, Outcome::Running),
        ] {
            let mut cell = on_their_goals(policy);
            // From zero, so that the distance is exact.
            cell.state.objects[YELLOW].pose.position[0] = 0.55 + offset;
            if offset == 0.025 {
                let text = include_str!("../../../../../cells/franka-stack.toml");
                let text = text.replace(
                    "stack_position_m = [0.55, 0.20]",
                    "stack_position_m = [0.0, 0.20]",
                );
                let data = cell_model::Data::checkout();
                let model = cell_model::Cell::from_text(&data, "franka-stack", "f", &text, 7, None)
                    .unwrap();
                cell.task = demos::policies().task(&model, policy).unwrap();
                for cube in [RED, BLUE, GREEN, YELLOW] {
                    cell.state.objects[cube].pose.position[0] = 0.0;
                }
                cell.state.objects[YELLOW].pose.position[0] = offset;
                cell.state.objects[YELLOW].pose.position[2] = 0.025 + 3.0 * 0.05;
            }
            cell.decide();
            assert_eq!(cell.outcome(), outcome, "{policy}, {offset} m");
        }
    }
}

#[test]
fn a_cube_in_the_layer_of_another_is_not_at_its_goal() {
    for policy in ALL {
        let mut cell = on_their_goals(policy);
        cell.state.objects.swap(GREEN, YELLOW);
        cell.step();
        assert_eq!(cell.outcome(), Outcome::Running);
        cell.run_to_done();
    }
}

#[test]
fn p09_the_pickup_is_frozen_on_entering_grasp() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until(60.0, |c| c.phase() == "APPROACH");
        cell.state.objects[RED].pose.position[0] += 0.01;
        cell.decide();
        let live = cell.decision.goals[0].target;
        assert_eq!(live.position[0], cell.position(RED)[0], "live before");
        cell.run_until(60.0, |c| c.phase() == "GRASP");
        cell.state.objects[RED].pose.position[0] += 0.01;
        cell.decide();
        assert_eq!(cell.decision.goals[0].target, live, "frozen after");
    }
}

#[test]
fn live_targets_keep_the_number_of_their_goal_and_phases_change_it() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.step();
        let first = cell.decision.goals[0];
        cell.state.objects[RED].pose.position[0] += 0.02;
        cell.step();
        let moved = cell.decision.goals[0];
        assert_eq!(moved.goal_id, first.goal_id);
        assert_ne!(moved.target, first.target);
        let mut ids = vec![moved.goal_id];
        while cell.phase() != "RETRACT" {
            cell.step();
            let goal = cell.decision.goals[0];
            if Some(&goal.goal_id) != ids.last() {
                assert_eq!(cell.phase(), demos::stack::Phase::RING[ids.len()].name());
                ids.push(goal.goal_id);
            }
        }
        assert_eq!(ids, (1..=8).collect::<Vec<u64>>());
    }
}

#[test]
fn p11_a_cube_far_from_the_hand_in_release_or_retract_is_no_drop() {
    for policy in ALL {
        for phase in ["RELEASE", "RETRACT"] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until(60.0, |c| c.phase() == phase);
            cell.drag(RED, [0.4, 0.0, 0.025]);
            cell.step();
            assert_eq!((cell.phase(), cell.decision.drops), (phase, 0));
        }
    }
}

#[test]
fn p13_a_move_of_the_tolerance_in_the_plane_is_not_a_resync_and_height_never_is() {
    for policy in ALL {
        for (offset, resyncs) in [
            ([0.049, 0.0, 0.0], 0),
            ([0.0, 0.051, 0.0], 1),
            ([0.0, 0.0, 0.2], 0),
        ] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until(60.0, |c| c.phase() == "APPROACH");
            for (p, d) in cell.state.objects[RED].pose.position.iter_mut().zip(offset) {
                *p += d;
            }
            cell.decide();
            assert_eq!(cell.decision.resyncs, resyncs, "{policy}, {offset:?}");
        }
    }
}

#[test]
fn p17_a_second_border_leaves_the_destination_of_an_abort_alone() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until_carrying(BLUE, "LIFT");
        cell.drag(RED, [0.42, 0.05, 0.025]);
        cell.run_until(10.0, |c| c.phase() == "TRANSPORT");
        let [x, y, _] = cell.decision.goals[0].target.position;
        cell.drag(RED, [0.35, -0.1, 0.025]);
        cell.run_until(10.0, |c| c.phase() == "LOWER");
        assert_eq!(cell.decision.goals[0].target.position[..2], [x, y]);
        assert_eq!(cell.decision.aborts, 1);
    }
}

#[test]
fn p23_only_the_echo_of_this_very_goal_settles_a_phase() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until(60.0, |c| c.phase() == "LIFT");
        // The controller never reports that it follows the goal: at the target or not, the
        // phase ends with its time only.
        let start = cell.state.header.tick;
        let mut trace = Vec::new();
        while cell.phase() == "LIFT" {
            cell.task
                .decide(&cell.state, &[None], &mut cell.decision, &mut trace);
            cell.move_on();
        }
        let waited = cell.state.header.tick - start;
        assert!((2500..2530).contains(&waited), "{waited} ticks");
        let left = trace.iter().find(|l| l.kind == TraceKind::Transition);
        assert!(left.unwrap().text.as_str().ends_with("(timeout)"));
    }
}
