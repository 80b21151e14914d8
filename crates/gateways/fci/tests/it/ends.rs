//! The end of a motion: the arm is at rest after the last command.

use fci::{Error, RobotCommand};

use crate::support::{Bench, assert_broken, numbers};

/// Numbers of the generators of a motion.
const JOINT_POSITION: u32 = 0;
const JOINT_VELOCITY: u32 = 1;
const CARTESIAN_POSE: u32 = 2;
const CARTESIAN_VELOCITY: u32 = 3;

/// Way and rate after so many cycles of a ramp to `rate` in half a second.
fn ramp(cycle: u64, rate: f64) -> (f64, f64) {
    let time = cycle as f64 * 1e-3;
    let way = if time < 0.5 {
        rate * time * time
    } else {
        rate * (time - 0.25)
    };
    (way, rate * (time / 0.5).min(1.0))
}

/// A motion at the rate of a ramp: joint 7 turns, or the tool moves down.
struct Ramp {
    generator: u32,
    rate: f64,
    positions: [f64; 7],
    pose: [f64; 16],
}

impl Ramp {
    fn start(bench: &mut Bench, generator: u32, rate: f64) -> Self {
        assert_eq!(bench.start(0, generator), 1);
        let pose = numbers(&bench.state(), 8, 16);
        Self {
            generator,
            rate,
            positions: bench.measured.positions,
            pose: pose.try_into().unwrap(),
        }
    }

    fn command(&self, bench: &Bench, cycle: u64) -> RobotCommand {
        let mut answer = bench.answer();
        let (way, rate) = ramp(cycle, self.rate);
        match self.generator {
            JOINT_POSITION => {
                answer.positions = self.positions;
                answer.positions[6] += way;
            }
            JOINT_VELOCITY => answer.velocities[6] = rate,
            CARTESIAN_POSE => {
                answer.pose = self.pose;
                answer.pose[14] -= way;
            }
            _ => answer.twist[2] = -rate,
        }
        answer
    }
}

#[test]
fn a_motion_that_ends_while_the_arm_moves_is_a_discontinuity() {
    let joint = (0.2, Error::VELOCITY_DISCONTINUITY, -200.0, 10.0);
    let tool = (0.06, Error::CARTESIAN_VELOCITY_DISCONTINUITY, 60.0, 9.0);
    for (generator, (rate, error, value, limit)) in [
        (JOINT_POSITION, joint),
        (JOINT_VELOCITY, joint),
        (CARTESIAN_POSE, tool),
        (CARTESIAN_VELOCITY, tool),
    ] {
        let mut bench = Bench::new();
        let motion = Ramp::start(&mut bench, generator, rate);
        for cycle in 0..1000 {
            bench.cycle(&motion.command(&bench, cycle));
            assert_eq!(bench.arm.take_reflex(), None, "cycle {cycle}");
        }
        let mut last = motion.command(&bench, 1000);
        last.is_finished = true;
        let before = bench.measured;
        bench.cycle(&last);
        // Positions are those of a client that may continue from the rounded ones of a state.
        let reflex = bench.arm.take_reflex().unwrap();
        let found = reflex.broken;
        assert_eq!((found.error, reflex.cycle), (error, 1001), "{found:?}");
        assert_eq!(found.limit, limit);
        assert!((found.value / value - 1.0).abs() < 1e-3, "{found:?}");
        // libfranka reports a reflex that follows the last command in other words.
        let replies = bench.replies();
        assert_eq!((replies[0].command, replies[0].status), (1, 8));
        let number = if generator < CARTESIAN_POSE { 14 } else { 19 };
        let state = bench.state();
        assert_eq!((state[1372], state[1331 + number]), (4, 1));
        // The last command was executed, and then the arm brakes.
        let moved = bench.measured.positions[6] - before.positions[6];
        assert!(generator > JOINT_VELOCITY || (moved - 0.2e-3).abs() < 1e-9);
        bench.rest();
    }
}

/// A velocity of joint 7 that is reached slowly and then ends.
fn ends_at(velocity: f64) -> Option<fci::Reflex> {
    let mut bench = Bench::new();
    assert_eq!(bench.start(0, JOINT_VELOCITY), 1);
    for cycle in 1..=100 {
        let mut answer = bench.answer();
        answer.velocities[6] = velocity * (f64::from(cycle) / 50.0).min(1.0);
        answer.is_finished = cycle == 100;
        bench.cycle(&answer);
    }
    bench.arm.take_reflex()
}

#[test]
fn the_stop_after_the_last_command_is_within_acceleration_and_jerk() {
    // A stop in 1 ms from v is an acceleration of v / 1 ms and a jerk of v / 1 ms².
    assert_eq!(ends_at(0.0), None);
    assert_eq!(ends_at(0.0049), None);
    let jerk = Error::ACCELERATION_DISCONTINUITY;
    assert_broken(ends_at(0.0051), jerk, 100, -5100.0, 5000.0);
    assert_broken(ends_at(-0.0099), jerk, 100, 9900.0, 5000.0);
    let acceleration = Error::VELOCITY_DISCONTINUITY;
    assert_broken(ends_at(0.0101), acceleration, 100, -10.1, 10.0);
}

#[test]
fn the_last_command_has_the_limits_of_the_others() {
    for (velocity, error, value, limit) in [
        (0.008, Error::ACCELERATION_DISCONTINUITY, 8000.0, 5000.0),
        (0.5, Error::VELOCITY_DISCONTINUITY, 500.0, 10.0),
    ] {
        let mut bench = Bench::new();
        assert_eq!(bench.start(0, JOINT_VELOCITY), 1);
        for _ in 0..50 {
            bench.cycle(&bench.answer());
        }
        let mut last = bench.answer();
        last.velocities[6] = velocity;
        last.is_finished = true;
        bench.cycle(&last);
        assert_broken(bench.arm.take_reflex(), error, 51, value, limit);
    }
}

#[test]
fn a_motion_may_end_with_its_first_command() {
    for generator in [
        JOINT_POSITION,
        JOINT_VELOCITY,
        CARTESIAN_POSE,
        CARTESIAN_VELOCITY,
    ] {
        let mut bench = Bench::new();
        bench.measured.positions[1] -= 5.0e-5;
        let motion = Ramp::start(&mut bench, generator, 0.0);
        let mut only = motion.command(&bench, 0);
        only.is_finished = true;
        bench.cycle(&only);
        assert_eq!(bench.arm.take_reflex(), None, "{generator}");
        assert_eq!(bench.replies()[0].status, 0);
    }
}
