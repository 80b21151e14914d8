//! Motions of a client, and what ends them.

use fci::{Error, Reflex, Request};

use crate::support::{Bench, assert_broken, command, numbers};

/// Runs a motion in joint velocities: joint 7 follows `speed` of the cycle.
fn velocities(bench: &mut Bench, cycles: u64, speed: impl Fn(u64) -> f64) -> Option<Reflex> {
    assert_eq!(bench.start(0, 1), 1);
    for cycle in 0..cycles {
        let mut answer = bench.answer();
        answer.velocities[6] = speed(cycle);
        answer.is_finished = cycle + 1 == cycles;
        bench.cycle(&answer);
        if let Some(reflex) = bench.arm.take_reflex() {
            return Some(reflex);
        }
    }
    None
}

fn bell(cycle: u64, cycles: u64) -> f64 {
    let part = cycle as f64 / cycles as f64;
    0.2 * (std::f64::consts::PI * part).sin().powi(2)
}

#[test]
fn a_motion_ends_with_two_replies_and_where_it_was_commanded() {
    let mut bench = Bench::new();
    let from = bench.measured.positions[6];
    assert_eq!(velocities(&mut bench, 1000, |cycle| bell(cycle, 999)), None);
    let replies = bench.replies();
    assert_eq!(
        (replies.len(), replies[0].command, replies[0].status),
        (1, 1, 0)
    );
    bench.rest();
    assert!((bench.measured.positions[6] - from - 0.1).abs() < 1e-3);
    assert_eq!(bench.state()[1372], 1);
}

#[test]
fn cycles_before_the_first_answer_are_not_lost() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(0, 1), 1);
    for _ in 0..100 {
        bench.cycle(None);
    }
    assert!(bench.arm.take_reflex().is_none() && !bench.arm.is_running());
    let answer = bench.answer();
    bench.cycle(&answer);
    assert!(bench.arm.is_running());
}

#[test]
fn the_success_rate_is_that_of_the_last_hundred_cycles() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(0, 1), 1);
    for cycle in 0..200 {
        let answer = (cycle % 4 != 3).then(|| bench.answer());
        bench.cycle(answer.as_ref());
    }
    assert_eq!(numbers(&bench.state(), 1373, 1), [0.75]);
}

#[test]
fn steps_are_reflexes_with_value_and_limit() {
    let mut bench = Bench::new();
    let reflex = velocities(&mut bench, 100, |cycle| if cycle < 50 { 0.0 } else { 0.5 });
    assert_broken(reflex, Error::VELOCITY_DISCONTINUITY, 51, 500.0, 10.0);
    let replies = bench.replies();
    assert_eq!((replies[0].command, replies[0].status), (1, 8));
    let state = bench.state();
    assert_eq!((state[1372], state[1290 + 14], state[1331 + 14]), (4, 1, 1));

    // Acceleration at once, within its limit: the jerk is not.
    let mut bench = Bench::new();
    let reflex = velocities(&mut bench, 100, |cycle| {
        0.009 * cycle.saturating_sub(50) as f64
    });
    assert_broken(
        reflex,
        Error::ACCELERATION_DISCONTINUITY,
        52,
        9000.0,
        5000.0,
    );

    let mut bench = Bench::new();
    assert_eq!(bench.start(0, 0), 1);
    for cycle in 0..60 {
        let mut answer = bench.answer();
        answer.positions[6] += if cycle == 50 { 0.01 } else { 0.0 };
        bench.cycle(&answer);
    }
    assert_broken(
        bench.arm.take_reflex(),
        Error::VELOCITY_LIMIT,
        51,
        10.0,
        5.26,
    );
}

#[test]
fn a_motion_that_starts_elsewhere_is_refused_by_name() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(0, 0), 1);
    let mut answer = bench.answer();
    answer.positions[2] += 0.1;
    bench.cycle(&answer);
    assert_broken(bench.arm.take_reflex(), Error::START_POSE, 1, 0.1, 0.0);
}

#[test]
fn a_motion_may_start_where_the_arm_is_measured() {
    // libfranka's own examples do. The larger step breaks the limits at once, the smaller one when
    // the second command stays there.
    for off in [5.0e-5, 3.0e-6] {
        let mut bench = Bench::new();
        bench.measured.positions[1] -= off;
        let from = bench.measured.positions;
        assert_eq!(bench.start(0, 0), 1);
        for _ in 0..20 {
            let mut answer = bench.answer();
            answer.positions = from;
            bench.cycle(&answer);
            assert_eq!(bench.arm.take_reflex(), None);
        }
        assert!((bench.measured.positions[1] - from[1]).abs() < 1e-12);
    }
}

#[test]
fn a_velocity_limit_is_less_near_the_end_of_a_joint() {
    // Joint 7 accelerates at 9 rad/s², which its jerk limit allows from cycle 100 on.
    let mut bench = Bench::new();
    let reflex = velocities(&mut bench, 2000, |cycle| {
        let seconds = cycle as f64 * 1e-3;
        let ramp = seconds.min(0.1);
        45.0 * ramp * ramp + 9.0 * (seconds - ramp)
    });
    let reflex = reflex.unwrap();
    assert_eq!(reflex.broken.error, Error::VELOCITY_LIMIT, "{reflex:?}");
    assert!(reflex.broken.limit < 5.2, "{reflex:?}");
}

#[test]
fn a_silent_client_is_extrapolated_and_then_stopped() {
    let mut bench = Bench::new();
    assert_eq!(velocities_without_end(&mut bench, 200), None);
    let (before, speed) = (bench.measured.positions[6], bench.measured.velocities[6]);
    bench.cycle(None);
    // With constant acceleration.
    assert!(bench.measured.positions[6] - before > 0.9e-3 * speed);
    for _ in 1..19 {
        bench.cycle(None);
    }
    assert!(bench.arm.take_reflex().is_none());
    bench.cycle(None);
    let reflex = bench.arm.take_reflex().unwrap();
    assert_eq!(reflex.broken.error, Error::COMMUNICATION);
    assert_eq!(reflex.cycle, 220);
    assert!(
        reflex
            .late
            .iter()
            .flatten()
            .all(|late| late.after_cycles.is_none())
    );
    // It brakes within its limits.
    let mut last = bench.measured;
    for _ in 0..500 {
        bench.cycle(None);
        let change = bench.measured.velocities[6] - last.velocities[6];
        assert!(change.abs() <= 10.0e-3 * (1.0 + 1e-9));
        last = bench.measured;
    }
    assert!(bench.arm.is_at_rest());
}

fn velocities_without_end(bench: &mut Bench, cycles: u64) -> Option<Reflex> {
    assert_eq!(bench.start(0, 1), 1);
    for cycle in 0..cycles {
        let mut answer = bench.answer();
        answer.velocities[6] = bell(cycle, 2 * cycles);
        bench.cycle(&answer);
    }
    bench.arm.take_reflex()
}

#[test]
fn late_answers_are_told_with_their_delay() {
    let mut bench = Bench::new();
    assert_eq!(velocities_without_end(&mut bench, 200), None);
    for _ in 0..20 {
        let late = bench.arm.message_id();
        bench.cycle(None);
        bench.cycle_late(late);
    }
    let reflex = bench.arm.take_reflex().unwrap();
    let late: Vec<_> = reflex.late.iter().flatten().collect();
    assert_eq!(late.len(), 20);
    assert_eq!(late[0].after_cycles, Some(1));
}

#[test]
fn a_recovery_waits_until_the_arm_is_at_rest() {
    let mut bench = Bench::new();
    assert_eq!(velocities_without_end(&mut bench, 200), None);
    for _ in 0..20 {
        bench.cycle(None);
    }
    assert!(bench.arm.take_reflex().is_some());
    bench.replies();
    assert_eq!(bench.start(0, 1), 5);
    assert!(
        bench
            .request(10, Request::AutomaticErrorRecovery)
            .is_empty()
    );
    bench.rest();
    let replies = bench.replies();
    assert_eq!((replies[0].command, replies[0].status), (10, 0));
    assert_eq!(bench.state()[1372], 1);
    assert_eq!(bench.start(0, 1), 1);
}

#[test]
fn parts_of_the_arm_do_not_touch() {
    // Folded, the hand comes near the base. Joint 2 ends 1.1 rad on, joint 6 1.0 rad back.
    let mut bench = Bench::new();
    assert_eq!(bench.start(0, 1), 1);
    let mut reflex = None;
    for cycle in 0..6000_u64 {
        let mut answer = bench.answer();
        let speed = 0.2 * (cycle as f64 * 2e-3).min(1.0);
        answer.velocities[1] = 1.14 * speed;
        answer.velocities[3] = -0.18 * speed;
        answer.velocities[5] = -0.92 * speed;
        bench.cycle(&answer);
        reflex = bench.arm.take_reflex();
        if reflex.is_some() {
            break;
        }
    }
    let reflex = reflex.unwrap();
    assert_eq!(reflex.broken.error, Error::SELF_COLLISION, "{reflex:?}");
    assert!(reflex.broken.value <= 0.0 && reflex.broken.value > -1e-3);
}

#[test]
fn torques_are_those_of_the_client_and_gravity() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(2, 4), 1);
    let mut answer = bench.answer();
    answer.torques[6] = 0.5;
    bench.cycle(&answer);
    let setpoint = bench.setpoint.unwrap();
    assert!(setpoint.by_torque);
    // Joint 7 of an arm that points down carries little; joint 2 carries the arm.
    assert!((setpoint.efforts[6] - 0.5).abs() < 0.5 && setpoint.efforts[1].abs() > 5.0);
    answer = bench.answer();
    answer.torques[6] = 2.0;
    bench.cycle(&answer);
    assert_broken(
        bench.arm.take_reflex(),
        Error::TORQUE_DISCONTINUITY,
        2,
        1500.0,
        1000.0,
    );
    assert!(!bench.setpoint.unwrap().by_torque);
}

#[test]
fn a_pose_is_followed_by_the_joints() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(1, 2), 1);
    let start: Vec<f64> = numbers(&bench.state(), 8, 16);
    for cycle in 0..=1000_u64 {
        let part = cycle as f64 / 1000.0;
        let smooth = part - (std::f64::consts::TAU * part).sin() / std::f64::consts::TAU;
        let mut answer = bench.answer();
        answer.pose = std::array::from_fn(|index| start[index]);
        answer.pose[12] += 0.05 * smooth;
        answer.is_finished = cycle == 1000;
        bench.cycle(&answer);
        assert_eq!(bench.arm.take_reflex(), None, "cycle {cycle}");
    }
    bench.rest();
    let end = numbers(&bench.state(), 8, 16);
    assert!((end[12] - start[12] - 0.05).abs() < 1e-5);
    assert!((end[13] - start[13]).abs() < 1e-5 && (end[14] - start[14]).abs() < 1e-5);
}

#[test]
fn a_twist_is_followed_by_the_joints() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(0, 3), 1);
    let start = numbers(&bench.state(), 8, 16);
    for cycle in 0..=1000_u64 {
        let mut answer = bench.answer();
        answer.twist[2] = bell(cycle, 1000);
        answer.is_finished = cycle == 1000;
        bench.cycle(&answer);
        assert_eq!(bench.arm.take_reflex(), None, "cycle {cycle}");
    }
    bench.rest();
    let end = numbers(&bench.state(), 8, 16);
    assert!((end[14] - start[14] - 0.1).abs() < 1e-3);
    assert!((end[12] - start[12]).abs() < 1e-3);
}

#[test]
fn what_is_not_served_is_refused() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(3, 0), 7);
    assert_eq!(bench.start(0, 4), 7);
    assert_eq!(bench.start(0, 5), 7);
    assert_eq!(bench.start(0, 0), 1);
    assert_eq!(bench.start(0, 0), 5);
    let stopped = bench.request(2, Request::StopMove);
    assert_eq!((stopped[0].command, stopped[0].status), (1, 2));
    assert_eq!((stopped[1].command, stopped[1].status), (2, 0));
}

#[test]
fn a_held_arm_ends_a_motion_without_an_error() {
    let mut bench = Bench::new();
    assert_eq!(velocities_without_end(&mut bench, 100), None);
    bench.measured.is_held = true;
    let answer = command(bench.arm.message_id());
    bench.cycle(&answer);
    let replies = bench.replies();
    assert_eq!((replies[0].command, replies[0].status), (1, 11));
    assert!(bench.arm.take_reflex().is_none());
    bench.measured.is_held = false;
    bench.rest();
    assert_eq!(bench.start(0, 1), 1);
}

#[test]
fn in_lockstep_each_command_is_used_once_and_in_order() {
    let mut bench = Bench::new();
    assert_eq!(bench.start(0, 1), 1);
    let first = bench.arm.message_id() + 1;
    // States are repeated while the client prepares; it answers the first of them.
    bench.arm.repeat(2);
    let from = bench.measured.positions[6];
    let mut sum = 0.0;
    for cycle in 0..100 {
        let mut answer = command(first + cycle);
        answer.velocities[6] = bell(cycle, 200);
        sum += answer.velocities[6] * 1e-3;
        bench.arm.datagram(&answer, true);
        assert!(bench.arm.is_answered());
        bench.cycle(None);
    }
    assert!(bench.arm.take_reflex().is_none());
    assert!((bench.measured.positions[6] - from - sum).abs() < 1e-12);
    bench.arm.datagram(&command(first), true);
    assert!(!bench.arm.is_answered());
}
