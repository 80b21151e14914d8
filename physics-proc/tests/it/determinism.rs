//! Equal runs are equal to the last bit, also across a snapshot.

use crate::support;

use ipc_types::operator::OperatorAction;
use ipc_types::{OperatorRequest, Wire};
use support::Rig;

fn job(rig: &mut Rig) {
    rig.pick(0, 0.15);
    let goal = rig.solve([0.5, 0.1, 0.2], 0.0);
    rig.travel(goal, 1.5);
}

#[test]
fn two_runs_give_one_hash() {
    let hash = |seed: u64| {
        let mut rig = Rig::new(seed);
        job(&mut rig);
        rig.world.state_hash()
    };
    assert_eq!(hash(11), hash(11));
    assert_ne!(hash(11), hash(12));
}

#[test]
fn a_restored_world_goes_on_bit_for_bit() {
    let mut rig = Rig::new(7);
    rig.pick(0, 0.15);
    let snapshot = rig.world.snapshot();
    let mut copy = Rig::new(7);
    copy.world.restore(&snapshot).unwrap();
    assert_eq!(copy.world.tick(), rig.world.tick());
    for _ in 0..600 {
        let command = rig.command(&rig.joints.clone(), &[0.0; 7], &[0.0; 7]);
        rig.apply(&command);
        copy.apply(&command);
        assert_eq!(
            rig.world.state_hash(),
            copy.world.state_hash(),
            "at {}",
            rig.world.tick()
        );
    }
    assert_eq!(rig.state(), copy.state());
}

#[test]
fn foreign_and_damaged_snapshots_are_refused_and_change_nothing() {
    let mut rig = Rig::new(7);
    let before = rig.world.state_hash();
    let foreign = Rig::new(8).world.snapshot();
    let own = rig.world.snapshot();
    for bytes in [&foreign[..], &own[..own.len() / 2], &own[..10], &[]] {
        let error = rig.world.restore(bytes).unwrap_err().to_string();
        assert!(error.contains("start from the beginning"), "{error}");
        assert_eq!(rig.world.state_hash(), before);
    }
}

#[test]
fn a_reset_brings_the_scene_back_and_time_goes_on() {
    let mut rig = Rig::new(9);
    let before = rig.state();
    rig.pick(2, 0.1);
    let tick = rig.world.tick();
    rig.world.execute_request(
        OperatorAction::TaskStart,
        &request(OperatorAction::TaskStart),
    );
    rig.world
        .execute_request(OperatorAction::Reset, &request(OperatorAction::Reset));
    let after = rig.state();
    assert_eq!(after.header.tick, tick);
    assert_eq!(after.objects[2].pose, before.objects[2].pose);
    assert_eq!(
        after.arms[0].joint_positions,
        before.arms[0].joint_positions
    );
    assert_eq!((after.panel.scene_reset, after.panel.task_start), (1, 1));
}

fn request(action: OperatorAction) -> OperatorRequest {
    let mut request = OperatorRequest::zeroed();
    request.action = action.code();
    request.pose = ipc_types::Pose::IDENTITY;
    request
}
