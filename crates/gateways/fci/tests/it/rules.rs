//! The rules of the maker for commands and motions: each with its error, value and limit.

use fci::{ELBOW_FLIP, Elbow, Error, Reflex, Request, RobotCommand};

use crate::support::{Bench, assert_broken, numbers};

/// Far from limits and from singular positions; the hand points down.
const READY: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];

/// A motion until it breaks a rule: `command` changes the answer of a cycle, from 1.
fn broken(
    bench: &mut Bench,
    (controller, generator): (u32, u32),
    mut command: impl FnMut(u64, &mut RobotCommand),
) -> Option<Reflex> {
    assert_eq!(bench.start(controller, generator), 1);
    let pose: [f64; 16] = numbers(&bench.state(), 8, 16).try_into().unwrap();
    for cycle in 1..=3000 {
        let mut answer = bench.answer();
        answer.pose = pose;
        command(cycle, &mut answer);
        bench.cycle(&answer);
        let reflex = bench.arm.take_reflex();
        if reflex.is_some() {
            return reflex;
        }
    }
    None
}

fn error_of(reflex: Option<&Reflex>) -> Option<Error> {
    reflex.map(|reflex| reflex.broken.error)
}

/// `rate` per second, reached within the jerk limits at `acceleration`.
fn ramp(cycle: u64, acceleration: f64, rate: f64) -> f64 {
    // Ten cycles to the full acceleration.
    let full =
        cycle.saturating_sub(10) as f64 + 0.05 * (cycle.min(10) * (cycle.min(10) + 1)) as f64;
    (1e-3 * acceleration * full).min(rate)
}

#[test]
fn positions_of_joints_have_limits() {
    // So slow that the limit of the velocity near an end, which is 0 there, allows it.
    let creep = |cycle: u64| 0.0009 * (cycle as f64 / 10.0).min(1.0);
    let mut near = READY;
    near[6] = 3.0196 - 2.0e-4;
    let reflex = broken(&mut Bench::at(near), (0, 1), |cycle, answer| {
        answer.velocities[6] = creep(cycle);
    });
    let found = reflex.as_ref().unwrap().broken;
    assert_eq!((found.error, found.joint), (Error::POSITION_LIMIT, Some(6)));
    assert_eq!(found.limit, 3.0196);
    assert!(found.value > 3.0196 && found.value < 3.0196 + 1e-6);

    let reflex = broken(&mut Bench::at(near), (0, 3), |cycle, answer| {
        // The axis of joint 7 points down.
        answer.twist[5] = -creep(cycle);
    });
    let found = reflex.as_ref().unwrap().broken;
    assert_eq!(
        (found.error, found.joint),
        (Error::CARTESIAN_JOINT_POSITION, Some(6)),
        "{found:?}"
    );
}

#[test]
fn velocities_of_the_end_effector_have_limits() {
    // Joint 7 turns the tool.
    let reflex = broken(&mut Bench::at(READY), (0, 3), |cycle, answer| {
        answer.twist[5] = ramp(cycle, 8.0, 2.6);
    });
    let found = reflex.unwrap().broken;
    assert_eq!(found.error, Error::CARTESIAN_VELOCITY_LIMIT, "{found:?}");
    assert_eq!((found.limit, found.unit), (2.5, "rad/s"));
    assert!(found.value < 2.52);

    for (velocity, error, value, limit) in [
        (0.02, Error::CARTESIAN_VELOCITY_DISCONTINUITY, 20.0, 9.0),
        (
            0.006,
            Error::CARTESIAN_ACCELERATION_DISCONTINUITY,
            6000.0,
            4500.0,
        ),
    ] {
        let reflex = broken(&mut Bench::at(READY), (0, 3), |cycle, answer| {
            answer.twist[0] = if cycle > 50 { velocity } else { 0.0 };
        });
        assert_broken(reflex, error, 51, value, limit);
    }
}

#[test]
fn joints_of_a_cartesian_motion_have_limits() {
    // Near the end of joint 7 its velocity limit is sqrt(34 way) - 0.35.
    let mut near = READY;
    near[6] = 3.0196 - 0.02;
    let reflex = broken(&mut Bench::at(near), (0, 3), |cycle, answer| {
        answer.twist[5] = -ramp(cycle, 8.0, 2.0);
    });
    let found = reflex.as_ref().unwrap().broken;
    assert_eq!(found.error, Error::CARTESIAN_JOINT_VELOCITY, "{found:?}");
    assert_eq!(found.joint, Some(6));
    assert!(found.limit < 0.47 && found.value > found.limit);

    // Stretched, a small motion of the tool is a large one of joint 4.
    let stretched = [0.0, 0.3, 0.0, -0.25, 0.0, 1.6, 0.785];
    let mut bench = Bench::at(stretched);
    let small = 1.0e-5;
    assert_eq!(bench.start(0, 3), 1);
    let mut answer = bench.answer();
    answer.twist[2] = -small;
    bench.cycle(&answer);
    let velocities = bench.measured.velocities.map(f64::abs);
    let gain = velocities.into_iter().fold(0.0, f64::max) / small;
    assert!(gain > 3.0, "{gain}");
    // Velocities of the fastest joint after 1 ms, both within the limits of the tool (4.5 mm/s in 1 ms).
    for (rate, error) in [
        (0.007, Error::CARTESIAN_JOINT_ACCELERATION_DISCONTINUITY),
        (0.02, Error::CARTESIAN_JOINT_VELOCITY_DISCONTINUITY),
    ] {
        let reflex = broken(&mut Bench::at(stretched), (0, 3), |_, answer| {
            answer.twist[2] = -rate / gain;
        });
        let reflex = reflex.unwrap();
        assert_eq!(
            (reflex.broken.error, reflex.cycle),
            (error, 1),
            "{reflex:?}"
        );
    }
}

#[test]
fn a_pose_is_a_rigid_transformation_that_starts_at_the_tool() {
    let reflex = broken(&mut Bench::at(READY), (0, 2), |cycle, answer| {
        answer.pose[0] *= if cycle > 50 { 1.01 } else { 1.0 };
    });
    assert_eq!(error_of(reflex.as_ref()), Some(Error::INVALID_FRAME));
    assert_eq!(reflex.unwrap().cycle, 51);
    let reflex = broken(&mut Bench::at(READY), (0, 2), |_, answer| {
        answer.pose[12] += 0.01;
    });
    assert_eq!(error_of(reflex.as_ref()), Some(Error::CARTESIAN_START_POSE));
    assert_eq!(reflex.unwrap().cycle, 1);
}

/// A motion at rest whose commands have this elbow.
fn with_elbow(elbow: impl Fn(u64) -> Elbow) -> Option<Reflex> {
    broken(&mut Bench::at(READY), (0, 2), |cycle, answer| {
        answer.elbow = Some(elbow(cycle));
    })
}

#[test]
fn an_elbow_starts_at_the_arm_and_keeps_its_side_and_limits() {
    let own = Elbow::of(&READY);
    assert_eq!((own.position, own.sign), (0.0, -1.0));
    assert_eq!(with_elbow(|_| own), None);
    let start = with_elbow(|_| Elbow {
        position: 0.1,
        ..own
    });
    assert_broken(start, Error::START_ELBOW, 1, 0.1, 0.0);
    let other_side = with_elbow(|cycle| Elbow {
        sign: if cycle > 50 { 1.0 } else { -1.0 },
        ..own
    });
    assert_broken(other_side, Error::ELBOW_SIGN, 51, 1.0, -1.0);
    let limit = with_elbow(|cycle| Elbow {
        position: if cycle > 50 { 2.91 } else { 0.0 },
        ..own
    });
    assert_broken(limit, Error::ELBOW_LIMIT, 51, 2.91, 2.9065);
    // A jump is that of joints.
    let jump = with_elbow(|cycle| Elbow {
        position: if cycle > 50 { 0.1 } else { 0.0 },
        ..own
    });
    let jump = jump.unwrap();
    let error = Error::CARTESIAN_JOINT_VELOCITY;
    assert_eq!((jump.broken.error, jump.cycle), (error, 51), "{jump:?}");
}

#[test]
fn an_elbow_may_start_where_the_arm_is_measured() {
    let mut bench = Bench::at(READY);
    bench.measured.positions[2] += 5.0e-5;
    let measured = bench.measured.positions;
    let reflex = broken(&mut bench, (0, 2), |_, answer| {
        answer.elbow = Some(Elbow::of(&measured));
    });
    assert_eq!(reflex, None);
    assert!((bench.measured.positions[2] - measured[2]).abs() < 1e-6);
}

#[test]
fn a_state_has_the_side_of_the_elbow() {
    for (joint4, sign) in [
        (-2.0, -1.0),
        (ELBOW_FLIP - 0.01, -1.0),
        (ELBOW_FLIP + 0.01, 1.0),
        (-0.2, 1.0),
    ] {
        let mut positions = READY;
        positions[3] = joint4;
        let bench = Bench::at(positions);
        let state = bench.state();
        // Measured, commanded last, commanded by the client.
        for at in [496, 504, 952] {
            assert_eq!(numbers(&state, at, 2)[1], sign, "joint 4 at {joint4}");
        }
    }
}

#[test]
fn torques_have_a_range_and_a_rate_from_the_first_one() {
    let reflex = broken(&mut Bench::at(READY), (2, 4), |_, answer| {
        answer.torques[4] = -1.5;
    });
    assert_broken(reflex, Error::TORQUE_DISCONTINUITY, 1, -1500.0, 1000.0);
    let reflex = broken(&mut Bench::at(READY), (2, 4), |cycle, answer| {
        answer.torques[4] = 0.9 * cycle as f64;
    });
    assert_broken(reflex, Error::TORQUE_RANGE, 14, 12.6, 12.0);
}

/// The error of a torque motion whose joints are measured so.
fn measured(positions: [f64; 7], velocities: [f64; 7]) -> Option<Reflex> {
    let mut bench = Bench::at(READY);
    assert_eq!(bench.start(2, 4), 1);
    (bench.measured.positions, bench.measured.velocities) = (positions, velocities);
    bench.cycle(&bench.answer());
    bench.arm.take_reflex()
}

#[test]
fn with_torques_the_arm_itself_stays_within_limits() {
    let rest = [0.0; 7];
    assert_eq!(measured(READY, rest), None);
    let mut out = READY;
    out[3] = -0.1;
    assert_broken(measured(out, rest), Error::JOINT_POSITION, 1, -0.1, -0.1458);
    let mut fast = rest;
    fast[6] = 5.3;
    assert_broken(measured(READY, fast), Error::JOINT_VELOCITY, 1, 5.3, 5.26);
    // Joint 1 moves a long tool by its distance from the axis.
    let mut bench = Bench::at(READY);
    let mut long = [0.0; 16];
    (long[0], long[5], long[10], long[15]) = (1.0, 1.0, 1.0, 1.0);
    long[12] = 1.0;
    assert_eq!(bench.request(8, Request::SetNeToEe(long))[0].status, 0);
    let tool = numbers(&bench.state(), 8, 16);
    let distance = tool[12].hypot(tool[13]);
    assert!(distance > 1.2, "{distance}");
    for (velocity, is_broken) in [(2.9 / distance, false), (3.1 / distance, true)] {
        assert_eq!(bench.start(2, 4), 1);
        bench.measured.velocities = [velocity, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        bench.cycle(&bench.answer());
        let reflex = bench.arm.take_reflex();
        assert_eq!(reflex.is_some(), is_broken, "{reflex:?}");
        if is_broken {
            let found = reflex.unwrap().broken;
            assert_eq!(found.error, Error::CARTESIAN_VELOCITY);
            assert!((found.value - 3.1).abs() < 1e-5 && found.limit == 3.0);
        } else {
            bench.request(2, Request::StopMove);
            bench.rest();
        }
    }
}

#[test]
fn names_are_those_of_libfranka() {
    let names = [
        Error::ELBOW_LIMIT,
        Error::ELBOW_SIGN,
        Error::START_ELBOW,
        Error::CARTESIAN_VELOCITY,
    ];
    assert_eq!(
        names.map(Error::name),
        [
            "cartesian_motion_generator_elbow_limit_violation",
            "cartesian_motion_generator_elbow_sign_inconsistent",
            "cartesian_motion_generator_start_elbow_invalid",
            "cartesian_velocity_violation",
        ]
    );
}
