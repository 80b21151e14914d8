//! The arm, a wall before it, and distances by the kinematics of `cell_model`.

use std::collections::BTreeMap;

use cell_model::{Data, Robot};
use nalgebra::{Isometry3, Point3, Vector3};
use plan::{Body, BodySetup, Path, PlanError, Scene, Settings, plan};
use rmp::Obstacle;

pub(crate) const LEFT: [f64; 7] = [0.7, 0.2, 0.0, -2.0, 0.0, 2.2, 0.75];
pub(crate) const RIGHT: [f64; 7] = [-0.7, 0.2, 0.0, -2.0, 0.0, 2.2, 0.75];

/// A Panda that the planner knows without its self-collision.
pub(crate) struct Arm {
    pub(crate) robot: Robot,
    pub(crate) body: Body,
}

impl Arm {
    pub(crate) fn new() -> Self {
        let robot = Robot::load(&Data::checkout(), "panda").unwrap();
        let names = robot.chain.joints().iter().map(|joint| joint.name.clone());
        let defaults: BTreeMap<String, f64> = names
            .zip(robot.fixed_joint_positions.iter().copied())
            .collect();
        let body = Body::new(&BodySetup {
            chain: &robot.chain,
            joint_names: &robot.arm_joint_names(),
            default_positions: &defaults,
            spheres: &robot.spheres,
            self_spheres: &[],
            self_ignore: &[],
            tool: robot.tcp_frame_name(),
        });
        Self {
            body: body.unwrap(),
            robot,
        }
    }

    pub(crate) fn tool_at(&self, at: &[f64]) -> Isometry3<f64> {
        let mut all = self.robot.fixed_joint_positions.clone();
        for (&joint, position) in self.robot.arm_joints.iter().zip(at) {
            all[joint] = *position;
        }
        self.robot.frame_pose(self.robot.tcp_frame, &all).unwrap()
    }

    /// Least distance of a moving sphere from a solid (m), by the kinematics of `cell_model`.
    pub(crate) fn distance(&self, at: &[f64], solids: &[Obstacle]) -> f64 {
        let mut all = self.robot.fixed_joint_positions.clone();
        for (&joint, position) in self.robot.arm_joints.iter().zip(at) {
            all[joint] = *position;
        }
        let links = self.robot.link_poses(&all);
        let frames = self.robot.chain.frames();
        let mut least = f64::INFINITY;
        for sphere in &self.robot.spheres {
            let frame = &frames[self.robot.chain.frame_index(&sphere.frame).unwrap()];
            let Some(joint) = frame.joint else { continue };
            let center = links[joint + 1] * frame.pose * Point3::from(sphere.center);
            for solid in solids {
                least = least.min(solid.distance(&center) - sphere.radius);
            }
        }
        least
    }

    pub(crate) fn along(&self, waypoints: &[Vec<f64>], solids: &[Obstacle]) -> f64 {
        let mut least = f64::INFINITY;
        for pair in waypoints.windows(2) {
            for part in 0..=500 {
                let part = f64::from(part) / 500.0;
                let joints = pair[0].iter().zip(&pair[1]);
                let at: Vec<f64> = joints.map(|(a, b)| a + part * (b - a)).collect();
                least = least.min(self.distance(&at, solids));
            }
        }
        least
    }

    pub(crate) fn plan(&self, solids: &[Obstacle], settings: &Settings) -> Result<Path, PlanError> {
        let scene = Scene::new(solids).unwrap();
        plan(&self.body, &scene, &LEFT, &RIGHT, settings)
    }
}

pub(crate) fn cuboid(at: [f64; 3], sides: [f64; 3]) -> Obstacle {
    let pose = Isometry3::translation(at[0], at[1], at[2]);
    Obstacle::cuboid(pose, Vector3::from(sides))
}

/// Before the arm, across the straight way of the tool.
pub(crate) fn wall() -> Vec<Obstacle> {
    let post = Obstacle::cylinder(Isometry3::translation(0.3, 0.0, 0.9), 0.05, 0.3);
    vec![cuboid([0.6, 0.0, 0.2], [0.5, 0.04, 0.7]), post]
}
