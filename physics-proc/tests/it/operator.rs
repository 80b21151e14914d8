//! What people do to the scene.

use crate::support;

use cell_model::{Cell, Data};
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::world::OBJECT_DRAGGED;
use ipc_types::{OperatorRequest, Wire};
use support::Rig;

fn drag(object: u32, to: [f64; 3], seconds: f64) -> OperatorRequest {
    let mut request = OperatorRequest::zeroed();
    request.action = OperatorAction::Drag.code();
    request.object = object;
    request.pose = ipc_types::Pose {
        position: to,
        ..ipc_types::Pose::IDENTITY
    };
    request.seconds = seconds;
    request
}

#[test]
fn a_dragged_cube_arrives_gently_and_is_let_go() {
    let mut rig = Rig::new(1);
    let goal = [0.6, 0.1, 0.025];
    assert_eq!(
        rig.world
            .execute_request(OperatorAction::Drag, &drag(0, goal, 3.0))
            .0,
        ReplyCode::Accepted
    );
    let mut fastest: f64 = 0.0;
    let mut arrived = None;
    for tick in 0..3_000 {
        rig.stay(1);
        let object = rig.state().objects[0];
        fastest = fastest.max(
            object
                .twist
                .linear
                .iter()
                .map(|v| v * v)
                .sum::<f64>()
                .sqrt(),
        );
        if object.flags & OBJECT_DRAGGED == 0 {
            arrived = arrived.or(Some(tick));
        }
    }
    let end = rig.object(0).translation.vector;
    assert!(
        arrived.is_some_and(|tick| (1_000..2_500).contains(&tick)),
        "{arrived:?}"
    );
    assert!(
        (end.x - goal[0]).abs() < 0.012 && (end.y - goal[1]).abs() < 0.012,
        "{end}"
    );
    assert!(fastest < 0.8, "{fastest}");
}

#[test]
fn a_held_cube_can_be_pulled_out_of_the_hand() {
    let mut rig = Rig::new(1);
    rig.pick(0, 0.2);
    let place = rig.object(0).translation.vector;
    let beside = [place.x + 0.35, place.y, place.z];
    rig.world
        .execute_request(OperatorAction::Drag, &drag(0, beside, 2.0));
    let mut before = rig.object(0).translation.vector;
    for _ in 0..2_500 {
        rig.stay(1);
        let now = rig.object(0).translation.vector;
        assert!(
            (now - before).norm() < 0.01,
            "a step of {} m in a tick",
            (now - before).norm()
        );
        before = now;
    }
    let state = rig.state();
    assert_eq!(state.arms[0].gripper.held_object, 0);
    assert!(before.x > place.x + 0.1 && before.z < 0.1, "{before}");
    let error = state.arms[0]
        .joint_positions
        .iter()
        .zip(&rig.joints)
        .map(|(m, c)| (m - c).abs())
        .fold(0.0, f64::max);
    assert!(error < 0.01, "{error}");
}

#[test]
fn requests_that_make_no_sense_are_answered() {
    let mut rig = Rig::new(1);
    let code = |rig: &mut Rig, action, request: &OperatorRequest| {
        rig.world.execute_request(action, request).0
    };
    assert_eq!(
        code(&mut rig, OperatorAction::Drag, &drag(4, [0.0; 3], 1.0)),
        ReplyCode::UnknownObject
    );
    assert_eq!(
        code(
            &mut rig,
            OperatorAction::Drag,
            &drag(0, [500.0, 0.0, 0.0], 1.0)
        ),
        ReplyCode::OutOfRange
    );
    assert_eq!(
        code(
            &mut rig,
            OperatorAction::Drag,
            &drag(0, [f64::NAN, 0.0, 0.0], 1.0)
        ),
        ReplyCode::OutOfRange
    );
    assert_eq!(
        code(&mut rig, OperatorAction::AddBin, &drag(0, [0.0; 3], 1.0)),
        ReplyCode::NotInThisCell
    );
    let mut other_arm = drag(0, [0.0; 3], 1.0);
    other_arm.arm = 1;
    assert_eq!(
        code(&mut rig, OperatorAction::Target, &other_arm),
        ReplyCode::UnknownArm
    );
}

#[test]
fn the_panel_counts_requests_and_keeps_the_last_target() {
    let mut rig = Rig::new(1);
    let request = drag(0, [0.4, 0.1, 0.3], 0.0);
    rig.world.execute_request(OperatorAction::Target, &request);
    rig.world.execute_request(OperatorAction::Target, &request);
    rig.world
        .execute_request(OperatorAction::TaskPause, &request);
    let panel = rig.state().panel;
    assert_eq!(
        (panel.target_seq, panel.task_paused, panel.target.position),
        (2, 1, [0.4, 0.1, 0.3])
    );
    rig.world
        .execute_request(OperatorAction::TaskResume, &request);
    assert_eq!(rig.state().panel.task_paused, 0);
}

#[test]
fn an_answer_says_what_a_request_does_not_do_yet() {
    let mut rig = Rig::new(1);
    let mut ask = |action| {
        let (code, message) = rig
            .world
            .execute_request(action, &OperatorRequest::zeroed_at_identity());
        assert_eq!(code, ReplyCode::Accepted);
        // And the note of a plant whose time is paused.
        assert!(
            message.len() + "; time is paused, too".len() <= 120,
            "{message}"
        );
        message
    };
    assert_eq!(ask(OperatorAction::TaskStart), "");
    assert!(ask(OperatorAction::TaskStart).contains("given before"));
    assert_eq!(ask(OperatorAction::TaskPause), "");
    assert!(ask(OperatorAction::TaskPause).contains("was paused before"));
    assert!(ask(OperatorAction::TaskStart).contains("at `robocell task resume`"));
    assert!(ask(OperatorAction::Reset).contains("the task is still paused"));
    assert_eq!(ask(OperatorAction::TaskResume), "");
    assert!(ask(OperatorAction::TaskResume).contains("was not paused"));
    assert_eq!(ask(OperatorAction::Reset), "");
    let reset = ask(OperatorAction::TaskReset);
    for part in [
        "gripper open",
        "start and targets cleared",
        "default pose",
        "paused until",
    ] {
        assert!(reset.contains(part), "{reset}");
    }
    let panel = rig.state().panel;
    assert_eq!((panel.task_paused, panel.task_started), (1, 0));
}

#[test]
fn a_drag_that_cannot_lift_its_object_says_so() {
    let mut cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
    cell.objects[0].mass = 20.0;
    let mut rig = Rig::with(cell);
    let mut ask = |object| {
        let request = drag(object, [0.6, 0.1, 0.2], 1.0);
        rig.world.execute_request(OperatorAction::Drag, &request)
    };
    let (code, message) = ask(0);
    assert_eq!(code, ReplyCode::Accepted);
    assert!(
        message.contains("20.0 kg") && message.contains("does not lift"),
        "{message}"
    );
    assert_eq!(ask(1), (ReplyCode::Accepted, String::new()));
}
