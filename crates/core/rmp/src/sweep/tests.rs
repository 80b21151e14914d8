use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::*;
use crate::ball::Ball;
use crate::groups::group;
use crate::simd::Path;
use crate::tree::{Attachment, Tree};
use crate::{
    Chain, CollisionParameters, Joint, JointKind, Obstacle, ObstacleId, ObstacleSet, Root,
};

const P: CollisionParameters = CollisionParameters {
    damping_gain: 50.0,
    damping_std_dev: 0.04,
    damping_robustness_eps: 1e-2,
    damping_velocity_gate_length_scale: 0.01,
    repulsion_gain: 800.0,
    repulsion_std_dev: 0.01,
    metric_modulation_radius: 0.5,
    metric_scalar: 1e4,
    metric_exploder_std_dev: 0.02,
    metric_exploder_eps: 1e-3,
};

/// Numbers within -0.5 to 0.5.
fn numbers() -> impl FnMut() -> f64 {
    let mut seed = 3_u64;
    move || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

/// An arm of joints along z (`Prismatic`) or about x, y and z in turn.
fn arm(joints: usize, kind: JointKind) -> Kinematics {
    let joint = |index: usize| Joint {
        name: index.to_string(),
        parent: index.checked_sub(1),
        origin: Isometry3::translation(0.0, 0.0, 0.2),
        axis: match kind {
            JointKind::Prismatic => Vector3::z(),
            JointKind::Revolute => Vector3::ith(index % 3, 1.0),
        },
        kind,
        lower: -3.0,
        upper: 3.0,
        mimic: None,
    };
    let chain = Chain::new((0..joints).map(joint).collect(), Vec::new()).unwrap();
    let names: Vec<String> = (0..joints).map(|index| index.to_string()).collect();
    Kinematics::new(Tree::new(&chain, &names, &BTreeMap::new()).unwrap())
}

fn ball(joint: usize, offset: Vector3<f64>, radius: f64) -> Ball {
    Ball {
        attachment: Attachment {
            joint: Some(joint),
            rotation: Matrix3::identity(),
            offset,
        },
        radius,
    }
}

/// The sum at the joints, and the nearest approach.
fn sweep(
    path: Path,
    kinematics: &Kinematics,
    balls: &[Ball],
    set: &ObstacleSet,
) -> (Root, Nearest) {
    let joints = kinematics.links.len();
    let (mut root, mut pullback) = (Root::new(joints), Pullback::new(joints));
    let mut groups = Vec::new();
    group(balls, &mut groups);
    let nearest = path.run(&mut Sweep {
        constants: &Constants::new(&P),
        kinematics,
        groups: &groups,
        obstacles: set.packed(),
        near: &mut Vec::new(),
        pullback: &mut pullback,
    });
    pullback.collect(kinematics, &mut root);
    (root, nearest)
}

fn bits((root, nearest): &(Root, Nearest)) -> Vec<u64> {
    let numbers = root.metric.iter().chain(root.force.iter());
    numbers
        .chain([&nearest.distance])
        .map(|x| x.to_bits())
        .chain([nearest.sphere as u64])
        .collect()
}

#[test]
fn every_choice_of_lanes_gives_the_same_bits() {
    let mut next = numbers();
    let mut kinematics = arm(5, JointKind::Revolute);
    let balls: Vec<Ball> = (0..23)
        .map(|i| {
            let offset = Vector3::new(next(), next(), next()) * 0.2;
            ball(i % 5, offset, 0.03 + 0.05 * next().abs())
        })
        .collect();
    let corners = [
        [0.2, 0.0, 0.0],
        [0.0, 0.2, 0.0],
        [0.0, 0.0, 0.3],
        [-0.1; 3],
        [0.2; 3],
    ];
    let corners = corners.map(Vector3::from);
    for count in [1, 4, 7, 20] {
        let mut set = ObstacleSet::with_capacity(count + 3);
        for index in 0..count {
            // Some are farther than any leaf reaches.
            let at = Vector3::new(next(), next(), next()) * 4.0;
            let turn = UnitQuaternion::from_euler_angles(next(), next(), next());
            let size = Vector3::new(next().max(0.0), next().abs(), next().max(0.0));
            let pose = Isometry3::from_parts(at.into(), turn);
            set.add(match index % 4 {
                0 | 1 => Obstacle::rounded_box(pose, size * 0.3, 0.02),
                2 => Obstacle::frustum(pose, 0.2 * size.y + 0.01, 0.3 * size.x, 0.2),
                _ => Obstacle::hull(pose, &corners).unwrap(),
            })
            .unwrap();
        }
        let walls = [0.0, 0.2, 0.4].map(|x| Obstacle::sphere(Vector3::new(x, 0.0, 0.0), 0.1));
        set.add_compound(Isometry3::translation(0.2, 0.1, 0.4), &walls)
            .unwrap();
        for _ in 0..300 {
            let [q, qd] = [(); 2].map(|()| [(); 5].map(|()| 4.0 * next()));
            kinematics.update(&q, &qd);
            let of = |path: Path| bits(&sweep(path, &kinematics, &balls, &set));
            let scalar = of(Path::Scalar);
            assert!(scalar.iter().all(|b| f64::from_bits(*b).is_finite()));
            assert_eq!(scalar, of(Path::Portable));
            assert_eq!(scalar, of(Path::best()));
        }
    }
}

#[test]
fn an_obstacle_far_away_weighs_nothing_and_is_still_the_nearest() {
    let kinematics = arm(1, JointKind::Prismatic);
    let mut set = ObstacleSet::with_capacity(2);
    for x in [3.0, 2.0] {
        set.add(Obstacle::sphere(Vector3::new(x, 0.0, 0.0), 0.5))
            .unwrap();
    }
    let balls = [0.0, 0.3].map(|x| ball(0, Vector3::new(x, 0.0, 0.0), 0.1));
    let (root, nearest) = sweep(Path::best(), &kinematics, &balls, &set);
    assert_eq!(root.metric[(0, 0)], 0.0);
    assert_eq!(nearest.sphere, 1);
    assert!((nearest.distance - 1.1).abs() < 1e-12, "{nearest:?}");
}

#[test]
fn a_compound_weighs_as_its_nearest_part_alone() {
    let kinematics = arm(1, JointKind::Prismatic);
    let balls = [ball(0, Vector3::zeros(), 0.1)];
    let parts = [0.1, 0.2, -0.1, 0.3].map(|z| Obstacle::sphere(Vector3::new(0.0, 0.0, z), 0.1));
    let pose = Isometry3::translation(0.0, 0.0, 0.45);
    let mut whole = ObstacleSet::with_capacity(4);
    let id = whole.add_compound(pose, &parts).unwrap();
    let mut alone = ObstacleSet::with_capacity(1);
    alone
        .add(Obstacle::sphere(Vector3::new(0.0, 0.0, 0.35), 0.1))
        .unwrap();
    let of = |set: &ObstacleSet| bits(&sweep(Path::best(), &kinematics, &balls, set));
    assert_eq!(of(&whole), of(&alone));
    // It moves and goes as one.
    whole
        .set_pose(id, Isometry3::translation(0.0, 0.0, 0.7))
        .unwrap();
    alone
        .set_pose(ObstacleId(0), Isometry3::translation(0.0, 0.0, 0.6))
        .unwrap();
    assert_eq!(of(&whole), of(&alone));
    assert_eq!((whole.len(), whole.enabled().count()), (1, 4));
    whole.set_enabled(id, false).unwrap();
    assert_eq!(whole.enabled().count(), 0);
    assert!(
        whole.add_compound(pose, &parts[..1]).is_err(),
        "no room is left"
    );
}

#[test]
fn the_kernel_is_the_published_formula() {
    let mut kinematics = arm(1, JointKind::Prismatic);
    let mut set = ObstacleSet::with_capacity(1);
    set.add(Obstacle::sphere(Vector3::zeros(), 0.1)).unwrap();
    kinematics.update(&[0.05], &[-0.03]);
    let balls = [ball(0, Vector3::zeros(), 0.05)];
    let (root, nearest) = sweep(Path::best(), &kinematics, &balls, &set);
    let (x, xd): (f64, f64) = (0.1, -0.03);
    let s = 1.0 - 1.0 / (1.0 + libm::exp(-xd / 0.01));
    let g = (1.0 - x / 0.5) * (1.0 - x / 0.5);
    let a = 800.0 * libm::exp(-x / 0.01) - 50.0 * s * xd / (x / 0.04 + 0.01);
    let weight = s * g * 1e4 / (x / 0.02 + 0.001);
    assert!((nearest.distance - x).abs() < 1e-15);
    assert!((root.metric[(0, 0)] / weight - 1.0).abs() < 1e-13);
    assert!((root.force[0] / (weight * a) - 1.0).abs() < 1e-13);
}
