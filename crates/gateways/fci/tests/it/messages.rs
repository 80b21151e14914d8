//! Layouts, as real-robot clients have them.

use fci::{GripperRequest, HEADER_BYTES, Malformed, Request, decode, decode_gripper};
use nalgebra::{Isometry3, Vector3};

use crate::support::{Bench, numbers, robot};

fn request(command: u32, body: &[u8]) -> Vec<u8> {
    let size = u32::try_from(HEADER_BYTES + body.len()).unwrap();
    let mut bytes: Vec<u8> = [command, 7, size]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    bytes.extend(body);
    bytes
}

#[test]
fn requests_have_the_sizes_of_libfranka() {
    let bodies = [
        (0, 4),
        (1, 113),
        (2, 0),
        (3, 416),
        (4, 56),
        (5, 48),
        (6, 7),
        (7, 128),
        (8, 128),
        (9, 104),
        (10, 0),
        (11, 0),
    ];
    for (command, size) in bodies {
        let bytes = request(command, &vec![0; size]);
        let framed = decode(&bytes).unwrap().unwrap();
        assert_eq!((framed.command, framed.id), (command, 7));
        assert_eq!(framed.size, bytes.len());
        // Incomplete until its last byte, which is not an error.
        for end in 0..bytes.len() {
            assert_eq!(decode(&bytes[..end]), Ok(None), "command {command}, {end}");
        }
        let longer = request(command, &vec![0; size + 1]);
        assert_eq!(decode(&longer), Err(Malformed::Body(command)));
    }
    assert_eq!(decode(&request(12, &[])), Err(Malformed::Command(12)));
    let mut short = request(2, &[]);
    short[8] = 11;
    assert_eq!(decode(&short), Err(Malformed::Size(11)));
}

#[test]
fn a_connect_names_version_and_port() {
    let framed = decode(&request(0, &[10, 0, 0x39, 0x30])).unwrap().unwrap();
    let wanted = Request::Connect {
        version: 10,
        udp_port: 12345,
    };
    assert_eq!(framed.request, wanted);
}

#[test]
fn requests_of_the_hand_have_a_shorter_header() {
    let mut bytes = vec![3, 0, 9, 0, 0, 0, 26, 0, 0, 0];
    bytes.extend(0.04_f64.to_le_bytes());
    bytes.extend(0.1_f64.to_le_bytes());
    let framed = decode_gripper(&bytes).unwrap().unwrap();
    assert_eq!((framed.command, framed.id, framed.size), (3, 9, 26));
    let wanted = GripperRequest::Move {
        width: 0.04,
        speed: 0.1,
    };
    assert_eq!(framed.request, wanted);
    bytes[0] = 9;
    assert!(decode_gripper(&bytes).is_err());
}

#[test]
fn a_state_has_its_values_where_libfranka_reads_them() {
    let mut bench = Bench::new();
    bench.cycle(None);
    bench.cycle(None);
    let state = bench.state();
    assert_eq!(u64::from_le_bytes(state[..8].try_into().unwrap()), 2);
    let home = robot().home();
    for at in [596, 624] {
        let sent = numbers(&state, at, 7);
        assert!(sent.iter().zip(&home).all(|(a, b)| (a - b).abs() < 1e-6));
    }
    // Idle, without controller.
    assert_eq!((state[1288], state[1289], state[1372]), (0, 3, 1));
    // Gravity at the flange, and a hand.
    assert_eq!(numbers(&state, 940, 3)[2], f64::from(-9.81_f32));
    assert_eq!(numbers(&state, 392, 1), [f64::from(0.73_f32)]);
    assert_eq!(bench.start(0, 1), 1);
    let state = bench.state();
    assert_eq!((state[1288], state[1289], state[1372]), (2, 0, 2));
}

#[test]
fn the_pose_of_a_state_is_that_of_the_tool() {
    let (bench, robot) = (Bench::new(), robot());
    let sent = numbers(&bench.state(), 8, 16);
    let all = robot.with_arm_positions(&robot.home());
    let tool: Isometry3<f64> = robot.frame_pose(robot.tcp_frame, &all).unwrap();
    let found = Vector3::new(sent[12], sent[13], sent[14]);
    assert!((found - tool.translation.vector).norm() < 1e-6);
    let matrix = tool.rotation.to_rotation_matrix();
    for (index, number) in sent[..12].iter().enumerate().filter(|(i, _)| i % 4 < 3) {
        assert!((number - matrix[(index % 4, index / 4)]).abs() < 1e-6);
    }
}

#[test]
fn the_model_has_joints_and_limits_that_libfranka_asks_for() {
    let text = fci::urdf(&robot());
    for joint in 1..=7 {
        assert!(text.contains(&format!("joint{joint}\" type=\"revolute\"")));
    }
    let first =
        "<position_based_velocity_limits velocity_offset=\"0.3\" deceleration_limit=\"6\"/>";
    assert!(text.contains(first), "{text}");
    assert!(text.contains("lower=\"-3.0481\" upper=\"-0.1458\" velocity=\"2.62\" effort=\"87\""));
    assert_eq!(text.matches("<mass").count(), 8);
    // Without the hand, whose mass is in the state.
    assert!(text.contains("<mass value=\"0.627"), "{text}");
    assert!(text.contains("<child link=\"link8\"/>"), "{text}");
}
