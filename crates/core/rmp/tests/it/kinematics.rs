//! Jacobians against differences, sizes up to 64 joints, branches and sliding
//! joints, and independence of the order in which joints are named.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unreadable_literal,
    clippy::needless_range_loop,
    clippy::unnecessary_to_owned,
    clippy::many_single_char_names,
    reason = "a test fails by panicking, says what it skips, and compares with published digits"
)]

use crate::common;

use std::collections::BTreeMap;

use common::{Random, panda};
use nalgebra::{DMatrix, DVector, Isometry3, UnitQuaternion, Vector3};
use rmp::{Chain, Frame, Joint, JointKind, Mimic, MotionState, RmpFlow, RmpFlowSetup};

/// A tree of `count` joints with any axes, every third one sliding, branching at
/// joint 1.
fn tree(count: usize, random: &mut Random) -> Chain {
    let mut joints = Vec::new();
    for i in 0..count {
        let mut number = || random.between(-1.0, 1.0);
        joints.push(Joint {
            name: format!("j{i}"),
            parent: if i == 3 { Some(1) } else { i.checked_sub(1) },
            origin: Isometry3::new(
                Vector3::new(number(), number(), number()) * 0.2,
                Vector3::new(number(), number(), number()),
            ),
            axis: Vector3::new(number(), number(), number()),
            kind: if i % 3 == 2 {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            },
            lower: -3.0,
            upper: 3.0,
            mimic: None,
        });
    }
    let tool = Frame {
        name: "tool".into(),
        joint: count.checked_sub(1),
        pose: Isometry3::translation(0.1, 0.2, 0.3),
    };
    Chain::new(joints, vec![tool]).unwrap()
}

/// The same tree, with joint 2, which slides, following joint 5, and joint 4 joint 1.
fn coupled(chain: &Chain) -> Chain {
    let mut joints = chain.joints().to_vec();
    for (index, joint, multiplier, offset) in [(2, 5, 0.5, 0.1), (4, 1, -0.7, 0.3)] {
        joints[index].mimic = Some(Mimic {
            joint,
            multiplier,
            offset,
        });
    }
    Chain::new(joints, chain.frames().to_vec()).unwrap()
}

/// Joints that move by themselves.
fn independent(chain: &Chain) -> Vec<String> {
    let joints = chain.joints().iter();
    let free = joints.filter(|joint| joint.mimic.is_none());
    free.map(|joint| joint.name.clone()).collect()
}

fn flow(chain: &Chain, names: &[String]) -> RmpFlow {
    let mut parameters = panda().parameters;
    parameters.joint_limit_buffers = vec![0.01; names.len()];
    parameters.body_collision_controllers.clear();
    RmpFlow::new(&RmpFlowSetup {
        chain,
        joint_names: names,
        default_positions: &BTreeMap::new(),
        spheres: &[],
        self_collision: rmp::SelfCollisionSetup::default(),
        parameters: &parameters,
        obstacle_capacity: 0,
    })
    .unwrap()
}

#[test]
fn jacobians_agree_with_differences() {
    let mut random = Random(5);
    let mut chains: Vec<Chain> = [1, 2, 6, 9].map(|n| tree(n, &mut random)).into();
    chains.push(coupled(&chains[3]));
    for chain in chains {
        let names = independent(&chain);
        let count = names.len();
        let mut flow = flow(&chain, &names);
        let id = flow.add_target_frame("tool").unwrap();
        let q: Vec<f64> = (0..count).map(|_| random.between(-1.0, 1.0)).collect();
        flow.evaluate(&q, &vec![0.0; count]).unwrap();
        let mut jacobian = DMatrix::zeros(6, count);
        flow.target_frame_jacobian(id, &mut jacobian).unwrap();
        for i in 0..count {
            let h = 1e-6;
            let mut moved = q.clone();
            moved[i] += h;
            let after = flow.target_frame_pose_at(id, &moved).unwrap().unwrap();
            moved[i] -= 2.0 * h;
            let before = flow.target_frame_pose_at(id, &moved).unwrap().unwrap();
            let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
            let turn: UnitQuaternion<f64> = after.rotation * before.rotation.inverse();
            let angular = turn.scaled_axis() / (2.0 * h);
            assert!((jacobian.fixed_view::<3, 1>(0, i) - linear).norm() < 1e-7);
            assert!((jacobian.fixed_view::<3, 1>(3, i) - angular).norm() < 1e-7);
        }
    }
}

/// Without target the drag and inertia leaf is J^T w J qdd + curvature: compare
/// its pullback with the Jacobian and a difference of it along the motion.
#[test]
fn the_pullback_is_that_of_the_jacobian_with_curvature() {
    let mut random = Random(8);
    let chain = tree(7, &mut random);
    pullback_is_that_of_the_jacobian(&chain, &mut random);
    pullback_is_that_of_the_jacobian(&coupled(&chain), &mut random);
}

fn pullback_is_that_of_the_jacobian(chain: &Chain, random: &mut Random) {
    let names = independent(chain);
    let count = names.len();
    let (mut bare, mut with) = (flow(chain, &names), flow(chain, &names));
    let id = with.add_target_frame("tool").unwrap();
    let q: Vec<f64> = (0..count).map(|_| random.between(-1.0, 1.0)).collect();
    let qd: Vec<f64> = (0..count).map(|_| random.between(-0.5, 0.5)).collect();
    let mut at = |step: f64| {
        let moved: Vec<f64> = q.iter().zip(&qd).map(|(x, v)| x + v * step).collect();
        with.evaluate(&moved, &qd).unwrap();
        let mut jacobian = DMatrix::zeros(6, count);
        with.target_frame_jacobian(id, &mut jacobian).unwrap();
        jacobian.rows(0, 3).into_owned()
    };
    let (j, rate) = (at(0.0), (at(1e-6) - at(-1e-6)) / 2e-6);
    let velocity = DVector::from_row_slice(&qd);
    let motion = &j * &velocity;
    let p = panda().parameters.damping;
    let drag = p.metric_scalar * motion.norm();
    let weight = drag + p.inertia;
    let force = &motion * (-drag * p.accel_d_gain * motion.norm()) - &rate * &velocity * weight;
    let expected_metric = j.transpose() * &j * weight;
    let expected_force = j.transpose() * force;
    let base = bare.evaluate(&q, &qd).unwrap().clone();
    let sum = with.evaluate(&q, &qd).unwrap();
    assert!((&sum.metric - &base.metric - expected_metric).amax() < 1e-6);
    assert!((&sum.force - &base.force - expected_force).amax() < 1e-3);
}

#[test]
fn joints_that_follow_others_are_where_their_formula_puts_them() {
    let mut random = Random(11);
    let chain = tree(7, &mut random);
    let coupled = coupled(&chain);
    let all: Vec<String> = chain.joints().iter().map(|j| j.name.clone()).collect();
    let q = [0.3, -0.4, 0.5, 0.2, -0.6];
    // Joints 0, 1, 3, 5 and 6 are independent.
    let expanded = [0.3, -0.4, 0.5 * 0.2 + 0.1, 0.5, 0.7 * 0.4 + 0.3, 0.2, -0.6];
    let pose = |chain: &Chain, names: &[String], q: &[f64]| {
        let mut flow = flow(chain, names);
        let id = flow.add_target_frame("tool").unwrap();
        flow.target_frame_pose_at(id, q).unwrap().unwrap()
    };
    let (a, b) = (
        pose(&coupled, &independent(&coupled), &q),
        pose(&chain, &all, &expanded),
    );
    assert!((a.translation.vector - b.translation.vector).norm() < 1e-12);
    assert!(a.rotation.angle_to(&b.rotation) < 1e-7);
}

#[test]
fn sixty_four_joints_and_any_order_of_names_work() {
    let mut random = Random(2);
    let chain = tree(64, &mut random);
    let names: Vec<String> = chain.joints().iter().map(|j| j.name.clone()).collect();
    let reversed: Vec<String> = names.iter().rev().cloned().collect();
    let ends: Vec<Vec<f64>> = [names, reversed]
        .iter()
        .map(|names| {
            let mut flow = flow(&chain, names);
            let id = flow.add_target_frame("tool").unwrap();
            flow.set_position_target(id, Some(Vector3::new(0.5, 0.5, 0.5)))
                .unwrap();
            let mut state = MotionState::at_rest(&[0.1; 64]);
            for _ in 0..50 {
                flow.step_exact(&mut state, 1e-3).unwrap();
            }
            state.positions
        })
        .collect();
    for (a, b) in ends[0].iter().zip(ends[1].iter().rev()) {
        assert!((a - b).abs() < 1e-9);
    }
}
