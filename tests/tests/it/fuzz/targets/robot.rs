//! Clients of the Franka control interface: streams and datagrams.

use std::sync::OnceLock;

use cell_model::{Data, Robot};
use fci::{
    Arm, COMMAND_BYTES, Fingers, Gripper, Measured, RobotCommand, STATE_BYTES, decode,
    decode_gripper,
};

use super::Target;

fn robot() -> &'static Robot {
    static ROBOT: OnceLock<Robot> = OnceLock::new();
    ROBOT.get_or_init(|| Robot::load(&Data::checkout(), "fr3").expect("the robot"))
}

/// What arrives over TCP: the requests to an arm, and to a hand, each followed by some cycles.
pub(crate) const FCI_STREAM: Target = Target {
    name: "fci_stream",
    run: |bytes| {
        let (mut arm, mut measured) = arm();
        let mut rest = bytes;
        while let Ok(Some(framed)) = decode(rest) {
            arm.request(&framed);
            cycle(&mut arm, &mut measured);
            while arm.take_reply().is_some() {}
            rest = &rest[framed.size..];
        }
        let mut hand = Gripper::new(robot().gripper.as_ref().expect("a hand"));
        let mut rest = bytes;
        while let Ok(Some(framed)) = decode_gripper(rest) {
            hand.request(&framed, &Fingers::default());
            for _ in 0..20 {
                let (width, force) = hand.advance(&Fingers::default());
                assert!((0.0..=0.08).contains(&width) && (0.0..=70.0).contains(&force));
            }
            while hand.take_reply().is_some() {}
            rest = &rest[framed.size..];
        }
    },
    corpus: || {
        let request = |command: u32, size: usize| {
            let total = u32::try_from(12 + size).expect("a small size");
            let header: Vec<u8> = [command, 7, total]
                .iter()
                .flat_map(|number| number.to_le_bytes())
                .collect();
            [header, vec![0; size]].concat()
        };
        let sizes = [4, 113, 0, 416, 56, 48, 7, 128, 128, 104, 0, 0];
        let each = (0..)
            .zip(sizes)
            .map(|(command, size)| request(command, size));
        let mut hand = vec![3, 0, 9, 0, 0, 0, 26, 0, 0, 0];
        hand.extend(
            [0.04_f64, 0.1]
                .iter()
                .flat_map(|number| number.to_le_bytes()),
        );
        vec![each.flatten().collect(), hand]
    },
};

/// What arrives over UDP in a motion of a kind: the first byte, then commands.
pub(crate) const FCI_DATAGRAM: Target = Target {
    name: "fci_datagram",
    run: |bytes| {
        let Some((kind, commands)) = bytes.split_first() else {
            return;
        };
        let (mut arm, mut measured) = arm();
        let mut motion = vec![0; 113];
        motion[0] = kind / 5 % 3;
        motion[4] = kind % 5;
        let header = [1_u32, 7, 125].map(u32::to_le_bytes).concat();
        if let Ok(Some(framed)) = decode(&[header, motion].concat()) {
            arm.request(&framed);
        }
        for datagram in commands.chunks(COMMAND_BYTES) {
            if let Some(command) = RobotCommand::decode(datagram) {
                // As an answer to the last state, whatever its number.
                arm.datagram(
                    &RobotCommand {
                        message_id: arm.message_id(),
                        ..command
                    },
                    false,
                );
            }
            cycle(&mut arm, &mut measured);
        }
        for _ in 0..30 {
            cycle(&mut arm, &mut measured);
        }
    },
    corpus: || {
        (0..15)
            .map(|kind| [vec![kind], vec![0; 3 * COMMAND_BYTES]].concat())
            .collect()
    },
};

fn arm() -> (Arm, Measured) {
    let home: [f64; 7] = robot().home().try_into().expect("seven joints");
    let gravity = nalgebra::Vector3::new(0.0, 0.0, -9.81);
    let arm = Arm::new(robot(), &home, gravity).expect("seven joints");
    let setpoint = home.map(|position| cell_model::ramp::RampState {
        position,
        ..Default::default()
    });
    let measured = Measured {
        positions: home,
        velocities: [0.0; 7],
        torques: [0.0; 7],
        setpoint,
        is_held: false,
    };
    (arm, measured)
}

/// A cycle of a robot that follows at once. No input may move it outside of its limits.
fn cycle(arm: &mut Arm, measured: &mut Measured) {
    let setpoint = arm.advance(measured);
    let limits = robot().arm_specs();
    for ((joint, effort), limit) in setpoint.joints.iter().zip(setpoint.efforts).zip(limits) {
        let room = 0.1;
        assert!((limit.lower - room..=limit.upper + room).contains(&joint.position));
        assert!(
            joint.velocity.abs() <= 1.01 * limit.velocity + room,
            "{joint:?}"
        );
        assert!(effort.is_finite());
    }
    measured.setpoint = setpoint.joints;
    measured.positions = setpoint.joints.map(|joint| joint.position);
    measured.velocities = setpoint.joints.map(|joint| joint.velocity);
    let mut state = [0; STATE_BYTES];
    arm.write_state(measured, &mut state);
}
