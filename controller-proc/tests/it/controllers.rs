//! The controllers beside RMPflow, and switching between all of them.

use controller_proc::controllers::{JOINT_PD, LINE, RMPFLOW};
use controller_proc::cycle::Cycle;
use nalgebra::Vector3;

use crate::support::{Bench, down};

const JOINTS: [f64; 6] = [-1.2, -1.8, -1.4, -1.2, 1.4, 0.3];

fn select(bench: &mut Bench, selector: u32) {
    bench.decision.goals[0].selector = selector;
}

fn tool(bench: &Bench) -> Vector3<f64> {
    Vector3::from(bench.state.arms[0].tcp.position)
}

#[test]
fn joint_pd_brings_every_joint_to_the_posture_within_the_limits() {
    let mut bench = Bench::new();
    select(&mut bench, JOINT_PD);
    bench.joints(JOINTS);
    bench.run(4000);
    let arm = &bench.state.arms[0];
    for (is, wanted) in arm.joint_positions.iter().zip(JOINTS) {
        assert!((is - wanted).abs() < 1.0e-3, "{is} {wanted}");
    }
    assert_eq!(bench.status.controller.as_str(), "joint_pd");
    assert_eq!(bench.violations, 0);
}

#[test]
fn a_line_is_straight_even_and_ends_at_the_target() {
    let mut bench = Bench::new();
    bench.joints(JOINTS);
    bench.run(6000);
    let from = tool(&bench);
    let to = from + Vector3::new(0.15, -0.1, 0.1);
    select(&mut bench, LINE);
    bench.goal(to.into(), down(0.2));
    let way = (to - from).normalize();
    let mut off_line = 0.0_f64;
    for _ in 0..3000 {
        bench.run(1);
        let along = tool(&bench) - from;
        off_line = off_line.max((along - way * along.dot(&way)).norm());
    }
    assert!(off_line < 2.0e-3, "{off_line}");
    assert!((tool(&bench) - to).norm() < 2.0e-3, "{}", tool(&bench) - to);
    assert!(bench.status.orientation_error < 0.01);
    assert_eq!(bench.violations, 0);
}

#[test]
fn a_switch_in_mid_motion_is_without_a_jump() {
    let mut bench = Bench::new();
    for (ticks, selector) in [
        (300, RMPFLOW),
        (300, JOINT_PD),
        (200, LINE),
        (300, RMPFLOW),
        (150, LINE),
        (150, JOINT_PD),
    ] {
        select(&mut bench, selector);
        bench.joints(JOINTS);
        if selector != JOINT_PD {
            bench.goal([0.6, -0.3, 0.4], down(0.0));
        }
        bench.run(ticks);
        assert_eq!(bench.violations, 0, "in controller {selector}");
    }
}

#[test]
fn an_unknown_controller_holds_the_arm() {
    let mut bench = Bench::new();
    bench.goal([0.6, -0.3, 0.4], down(0.0));
    bench.run(300);
    select(&mut bench, 99);
    bench.run(1000);
    let held = bench.state.arms[0].joint_positions;
    bench.run(1000);
    let moved = bench.state.arms[0].joint_positions.iter().zip(held);
    assert!(moved.map(|(a, b)| (a - b).abs()).all(|off| off < 1.0e-3));
    assert_eq!(bench.violations, 0);
}

#[test]
fn a_restored_cycle_continues_a_line_bit_for_bit() {
    let mut bench = Bench::new();
    select(&mut bench, LINE);
    bench.goal([0.6, -0.3, 0.4], down(0.0));
    bench.run(200);
    let mut bytes = vec![0; ipc_types::tap::KEYFRAME_BYTES];
    let length = bench.cycle.save(30, &mut bytes).unwrap();
    let mut restored = Cycle::new(&bench.cell, 0).unwrap();
    restored.restore(&bytes[..length]).unwrap();
    let state = bench.state.clone();
    bench.run(300);
    let first = bench.command.joint_positions;
    bench.state = state;
    bench.cycle = restored;
    bench.run(300);
    assert_eq!(bench.command.joint_positions, first);
}
