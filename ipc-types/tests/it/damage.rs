//! Values that are not finite or not plausible, in any field of any message.
#![allow(
    clippy::cast_possible_truncation,
    reason = "capacities of messages are small"
)]

use ipc_types::contact::MAX_CONTACTS;
use ipc_types::tap::PIECE_OBJECTS;
use ipc_types::{
    ArmCommand, ArmStatus, Contacts, Decision, Health, Keyframe, MAX_ARMS, MAX_JOINTS, MAX_OBJECTS,
    OperatorReply, OperatorRequest, Pose, TraceLine, Validate, Wire, WorldPiece, WorldState,
};

/// A message with every part in use.
trait Full: Wire + Validate {
    fn full() -> Self;
}

impl Full for ArmCommand {
    fn full() -> Self {
        Self {
            joint_count: MAX_JOINTS as u32,
            ..Self::zeroed()
        }
    }
}

impl Full for ArmStatus {
    fn full() -> Self {
        Self {
            setpoint: Pose::IDENTITY,
            target: Pose::IDENTITY,
            ..Self::zeroed()
        }
    }
}

impl Full for Decision {
    fn full() -> Self {
        let mut this = Self::zeroed();
        this.arm_count = MAX_ARMS as u32;
        for goal in &mut this.goals {
            goal.target = Pose::IDENTITY;
        }
        this
    }
}

impl Full for Contacts {
    fn full() -> Self {
        Self {
            count: MAX_CONTACTS as u32,
            ..Self::zeroed()
        }
    }
}

impl Full for TraceLine {
    fn full() -> Self {
        Self::zeroed()
    }
}

impl Full for Keyframe {
    fn full() -> Self {
        Self::zeroed()
    }
}

impl Full for Health {
    fn full() -> Self {
        Self::zeroed()
    }
}

impl Full for OperatorRequest {
    fn full() -> Self {
        Self::zeroed_at_identity()
    }
}

impl Full for OperatorReply {
    fn full() -> Self {
        Self::zeroed()
    }
}

impl Full for WorldState {
    fn full() -> Self {
        let mut this = Self::zeroed();
        (this.arm_count, this.object_count) = (MAX_ARMS as u32, MAX_OBJECTS as u32);
        for arm in &mut this.arms {
            (arm.joint_count, arm.tcp) = (MAX_JOINTS as u32, Pose::IDENTITY);
        }
        for object in &mut this.objects {
            object.pose = Pose::IDENTITY;
        }
        (this.panel.target_seq, this.panel.target) = (1, Pose::IDENTITY);
        this
    }
}

impl Full for WorldPiece {
    fn full() -> Self {
        let mut this = Self::zeroed();
        this.arm_count = MAX_ARMS as u32;
        for arm in &mut this.arms {
            (arm.joint_count, arm.tcp) = (MAX_JOINTS as u32, Pose::IDENTITY);
        }
        this.count = PIECE_OBJECTS as u32;
        for object in &mut this.objects {
            object.state.pose = Pose::IDENTITY;
        }
        (this.panel.target_seq, this.panel.target) = (1, Pose::IDENTITY);
        this
    }
}

/// Every number of the message, replaced by each invalid value; returns their number.
fn refuses_all<T: Full>(name: &str) -> usize {
    let good = T::full();
    assert_eq!(good.validate(), Ok(()), "{name}");
    let mut count = 0;
    T::each_float(name, 0, &mut |field, offset| {
        count += 1;
        for bad in [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1.0e300,
            -1.0e300,
        ] {
            let mut bytes = good.as_bytes().to_vec();
            bytes[offset..offset + 8].copy_from_slice(&bad.to_ne_bytes());
            let refused = T::from_bytes(&bytes).unwrap().validate();
            let refused = refused.expect_err(&format!("{field} = {bad} was taken"));
            // The norm of a quaternion reveals a wrong component.
            let said = refused.value;
            assert!(
                !said.is_finite() || said.abs() > 1.0e2,
                "{field} = {bad}: {refused}"
            );
        }
    });
    count
}

#[test]
fn no_field_of_any_message_takes_what_is_no_plausible_number() {
    assert_eq!(refuses_all::<ArmCommand>("command"), 4 * MAX_JOINTS + 2);
    assert!(refuses_all::<ArmStatus>("status") > 10);
    assert!(refuses_all::<Decision>("decision") > 2 * 10);
    assert!(refuses_all::<Health>("health") >= 8);
    assert!(refuses_all::<OperatorRequest>("request") >= 8);
    assert_eq!(refuses_all::<OperatorReply>("reply"), 0);
    assert!(refuses_all::<WorldState>("state") > 13 * MAX_OBJECTS);
    assert!(refuses_all::<WorldPiece>("piece") > 100);
    assert_eq!(refuses_all::<Contacts>("contacts"), 6 * MAX_CONTACTS);
}

/// Random bytes: refused or plausible, never a panic.
#[test]
fn random_bytes_are_judged() {
    fn judge<T: Full>(random: &mut impl FnMut() -> u64) -> usize {
        let mut refused = 0;
        for _ in 0..200 {
            let words = (0..size_of::<T>().div_ceil(8)).flat_map(|_| random().to_ne_bytes());
            let bytes: Vec<u8> = words.take(size_of::<T>()).collect();
            refused += usize::from(T::from_bytes(&bytes).unwrap().validate().is_err());
        }
        refused
    }
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    assert_eq!(judge::<ArmCommand>(&mut random), 200);
    assert_eq!(judge::<ArmStatus>(&mut random), 200);
    assert_eq!(judge::<Decision>(&mut random), 200);
    assert_eq!(judge::<WorldState>(&mut random), 200);
    assert_eq!(judge::<WorldPiece>(&mut random), 200);
    assert_eq!(judge::<Health>(&mut random), 200);
    assert_eq!(judge::<OperatorRequest>(&mut random), 200);
    assert_eq!(judge::<Contacts>(&mut random), 200);
    assert_eq!(judge::<TraceLine>(&mut random), 200);
    assert_eq!(judge::<Keyframe>(&mut random), 200);
}
