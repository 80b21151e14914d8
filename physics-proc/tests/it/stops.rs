//! Silence, hostile commands and a controller that starts again.

use crate::support;

use ipc_types::arm::StopAction;
use physics_proc::world::StepInput;
use support::{HOME, Rig};

const LIMITS: [(f64, f64); 7] = [
    (15.0, 7_500.0),
    (7.5, 3_750.0),
    (10.0, 5_000.0),
    (12.5, 6_250.0),
    (15.0, 7_500.0),
    (20.0, 10_000.0),
    (20.0, 10_000.0),
];

fn silence(rig: &mut Rig) {
    rig.world.step(&StepInput::default());
}

/// Goes half way and stops sending in full motion.
fn interrupted() -> Rig {
    let mut rig = Rig::new(1);
    let goal = rig.solve([0.5, 0.3, 0.4], 0.0);
    let (start, seconds, ticks) = (rig.joints, 1.6, 800_u64);
    for tick in 1..=ticks {
        let s = tick as f64 / 1_600.0;
        let p = s.powi(4) * (35.0 - 84.0 * s + 70.0 * s * s - 20.0 * s * s * s);
        let v = 140.0 * s.powi(3) * (1.0 - s).powi(3) / seconds;
        let q = std::array::from_fn(|j| start[j] + p * (goal[j] - start[j]));
        let qd = std::array::from_fn(|j| v * (goal[j] - start[j]));
        let command = rig.command(&q, &qd, &[0.0; 7]);
        rig.apply(&command);
    }
    rig
}

#[test]
fn silence_brakes_within_the_limits_and_holds() {
    let mut rig = interrupted();
    let moving = rig.state().arms[0];
    assert!(
        moving.setpoint_velocities.iter().any(|v| v.abs() > 0.5),
        "{:?}",
        moving.setpoint_velocities
    );
    assert_eq!(moving.limit_violations, 0);
    let mut before = moving;
    for tick in 1..=600 {
        silence(&mut rig);
        let now = rig.state().arms[0];
        let expected = if tick <= cell_model::stop::COMMAND_AGE_TICKS {
            StopAction::None
        } else {
            StopAction::Hold
        };
        assert_eq!(now.stop_action, expected.code(), "tick {tick}");
        for (joint, (acceleration, jerk)) in LIMITS.into_iter().enumerate() {
            let a = (now.setpoint_velocities[joint] - before.setpoint_velocities[joint]) / 1e-3;
            let j = (a - before.setpoint_accelerations[joint]) / 1e-3;
            assert!(
                a.abs() <= acceleration * (1.0 + 1e-6) && j.abs() <= jerk * (1.0 + 1e-6),
                "{tick} {joint}: {a} {j}"
            );
        }
        before = now;
    }
    assert!(before.setpoint_velocities.iter().all(|v| *v == 0.0));
    assert!(before.joint_velocities.iter().all(|v| v.abs() < 1e-3));
    assert_eq!(before.limit_violations, 0);
    for joint in 0..7 {
        assert!((before.joint_positions[joint] - before.setpoint_positions[joint]).abs() < 2e-3);
    }
}

#[test]
fn a_controller_that_starts_where_the_arm_is_goes_on() {
    let mut rig = interrupted();
    (0..600).for_each(|_| silence(&mut rig));
    let held = rig.state().arms[0].setpoint_positions;
    rig.joints = std::array::from_fn(|j| held[j]);
    rig.stay(5);
    let arm = rig.state().arms[0];
    assert_eq!(
        (arm.stop_action, arm.limit_violations),
        (StopAction::None.code(), 0)
    );
    assert_eq!(arm.command_tick + 1, rig.world.tick());
}

#[test]
fn a_controller_that_slept_through_the_brake_has_to_start_where_the_arm_is() {
    let mut rig = interrupted();
    let before = rig.state().arms[0];
    (0..23).for_each(|_| silence(&mut rig));
    let q = std::array::from_fn(|j| before.setpoint_positions[j]);
    let qd = std::array::from_fn(|j| before.setpoint_velocities[j]);
    let command = rig.command(&q, &qd, &[0.0; 7]);
    rig.apply(&command);
    let arm = rig.state().arms[0];
    assert_eq!(
        (arm.limit_violations, arm.stop_action),
        (0, StopAction::Hold.code())
    );
    assert_eq!(rig.world.refused_commands(), 1);
    // Continues while the arm still brakes, one more tick on the same ramp.
    let next =
        |j: usize, dt: f64| arm.setpoint_velocities[j] + arm.setpoint_accelerations[j] * dt * 0.98;
    let q = std::array::from_fn(|j| {
        arm.setpoint_positions[j] + 0.5e-3 * (arm.setpoint_velocities[j] + next(j, 1e-3))
    });
    let command = rig.command(&q, &std::array::from_fn(|j| next(j, 1e-3)), &[0.0; 7]);
    rig.apply(&command);
    let arm = rig.state().arms[0];
    assert_eq!(
        (arm.limit_violations, arm.stop_action),
        (0, StopAction::None.code())
    );
}

/// A command of before physics was restarted can arrive after it. Its position is that of a tick
/// ago, its velocity that of now.
#[test]
fn a_first_command_in_which_a_joint_stays_at_full_speed_is_refused() {
    let mut rig = interrupted();
    let arm = rig.state().arms[0];
    let velocities = std::array::from_fn(|j| arm.setpoint_velocities[j]);
    let positions = |ticks: f64| {
        std::array::from_fn(|j| {
            arm.setpoint_positions[j] + ticks * 1.0e-3 * arm.setpoint_velocities[j]
        })
    };
    let from_another_start = |rig: &mut Rig, ticks: f64| {
        let mut command = rig.command(&positions(ticks), &velocities, &[0.0; 7]);
        command.header.generation += 1;
        rig.apply(&command);
        rig.state().arms[0]
    };
    let stayed = from_another_start(&mut rig, 0.0);
    assert_eq!(rig.world.refused_commands(), 1);
    assert_eq!(stayed.stop_action, StopAction::Hold.code());
    let mut rig = interrupted();
    let continued = from_another_start(&mut rig, 1.0);
    assert_eq!(rig.world.refused_commands(), 0);
    assert_eq!(
        (continued.limit_violations, continued.stop_action),
        (0, StopAction::None.code())
    );
}

#[test]
fn a_command_from_elsewhere_is_refused_and_the_arm_stays() {
    let mut rig = Rig::new(2);
    rig.stay(10);
    let before = rig.state().arms[0];
    let mut far = HOME;
    far[0] += 0.5;
    let command = rig.command(&far, &[0.0; 7], &[0.0; 7]);
    rig.apply(&command);
    assert_eq!(rig.world.refused_commands(), 1);
    let after = rig.state().arms[0];
    assert_eq!(after.setpoint_positions, before.setpoint_positions);
    assert_eq!(after.command_seq, before.command_seq);
}

#[test]
fn hostile_numbers_never_reach_the_engine() {
    let mut rig = Rig::new(2);
    rig.stay(10);
    for value in [f64::NAN, f64::INFINITY, 1e30, -1e18] {
        let sound = rig.command(&HOME, &[0.0; 7], &[0.0; 7]);
        for field in 0..5 {
            let mut command = sound;
            command.header.seq += 1_000 + field;
            match field {
                0 => command.joint_positions[3] = value,
                1 => command.joint_velocities[3] = value,
                2 => command.joint_accelerations[3] = value,
                3 => command.joint_efforts[3] = value,
                _ => command.gripper.width = value,
            }
            rig.apply(&command);
        }
        let mut short = sound;
        short.joint_count = 6;
        rig.apply(&short);
    }
    rig.stay(100);
    let state = rig.state();
    ipc_types::Validate::validate(&state).unwrap();
    assert_eq!(state.quarantined, 0);
    assert_eq!(rig.world.refused_commands(), 24);
    for (joint, home) in HOME.iter().enumerate() {
        assert!((state.arms[0].joint_positions[joint] - home).abs() < 1e-3);
    }
}

#[test]
fn a_command_that_breaks_a_limit_is_counted_once() {
    let mut rig = Rig::new(2);
    rig.stay(10);
    let mut jump = [0.0; 7];
    jump[2] = 0.02;
    let command = rig.command(&HOME, &jump, &[0.0; 7]);
    rig.apply(&command);
    assert_eq!(rig.state().arms[0].limit_violations, 1);
}

#[test]
fn before_the_first_command_the_arm_holds_its_home() {
    let mut rig = Rig::new(2);
    (0..1_000).for_each(|_| silence(&mut rig));
    let arm = rig.state().arms[0];
    assert_eq!(arm.stop_action, StopAction::None.code());
    for (joint, home) in HOME.iter().enumerate() {
        assert!(
            (arm.joint_positions[joint] - home).abs() < 2e-4,
            "{joint}: {}",
            arm.joint_positions[joint]
        );
    }
}

#[test]
fn a_command_that_answers_the_scene_before_a_reset_is_not_taken() {
    let mut rig = Rig::new(1);
    let speed = 0.2;
    for tick in 1..=40 {
        // Joint 1 speeds up within its limits.
        let t = f64::from(tick) * 1.0e-3;
        let v = speed * (t / 0.04) * (t / 0.04);
        let mut q = HOME;
        q[0] += speed * t * t * t / (3.0 * 0.04 * 0.04);
        let command = rig.command(&q, &[v, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.0; 7]);
        rig.apply(&command);
        rig.joints = q;
    }
    assert_eq!(rig.state().arms[0].limit_violations, 0);
    let late = rig.command(
        &rig.joints.clone(),
        &[speed, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        &[0.0; 7],
    );
    rig.world.reset().unwrap();
    rig.apply(&late);
    let arm = rig.state().arms[0];
    assert_eq!(arm.limit_violations, 0);
    assert_eq!(arm.setpoint_velocities[0], 0.0);
    assert_eq!(arm.setpoint_positions[..7], HOME);
    // What answers the new scene is.
    rig.joints = HOME;
    rig.stay(3);
    assert_eq!(rig.state().arms[0].limit_violations, 0);
    assert!(rig.state().arms[0].command_seq > 0);
}
