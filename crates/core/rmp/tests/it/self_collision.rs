//! A robot whose targets are near its own body: its parts do not meet, and no limit is
//! exceeded on the way.

use std::collections::BTreeMap;

use cell_model::{Data, Robot};
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use rmp::{CollisionSphere, MotionState, RmpFlow, SelfCollisionSetup, TargetId};

use crate::common::{self, Files};

/// A target is followed for so many ticks of 1 ms.
const TICKS: usize = 1500;
/// Parts may come this near (m); the model of the body has rounded corners.
const LEAST_M: f64 = -0.002;

/// By robot: position (m), then orientation w x y z, in the base frame. The first twelve
/// were chosen by hand, the others are random within half a metre of the base's axis.
fn targets(robot: &str) -> Vec<[f64; 7]> {
    let text = include_str!("../hostile_targets.json");
    let mut all: BTreeMap<String, Vec<[f64; 7]>> = serde_json::from_str(text).unwrap();
    all.remove(robot).unwrap()
}

fn aim(flow: &mut RmpFlow, tool: TargetId, [x, y, z, qw, qx, qy, qz]: [f64; 7]) {
    let turn = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz));
    flow.set_position_target(tool, Some(Vector3::new(x, y, z)))
        .unwrap();
    flow.set_orientation_target(tool, Some(turn)).unwrap();
}

/// A robot whose distances are computed by the kinematics of `cell_model`.
struct Body {
    robot: Robot,
    files: Files,
}

impl Body {
    fn of(name: &str) -> Self {
        Self {
            robot: Robot::load(&Data::checkout(), name).unwrap(),
            files: if name == "panda" {
                common::panda()
            } else {
                common::ur10()
            },
        }
    }

    /// Least distance of two parts that must not meet (m).
    fn distance(&self, positions: &[f64]) -> f64 {
        let (robot, xrdf) = (&self.robot, &self.files.xrdf);
        let mut all = robot.fixed_joint_positions.clone();
        for (&index, position) in robot.arm_joints.iter().zip(positions) {
            all[index] = *position;
        }
        let place = |sphere: &CollisionSphere| {
            let frame = robot.chain.frame_index(&sphere.frame).unwrap();
            robot.frame_pose(frame, &all).unwrap() * Point3::from(sphere.center)
        };
        let centers: Vec<_> = xrdf.self_spheres.iter().map(place).collect();
        let may_touch = |a: &str, b: &str| {
            let mut pairs = xrdf.self_ignore.iter();
            a == b || pairs.any(|(c, d)| (c == a && d == b) || (c == b && d == a))
        };
        let mut least = f64::INFINITY;
        for (i, one) in xrdf.self_spheres.iter().enumerate() {
            for (j, other) in xrdf.self_spheres.iter().enumerate().skip(i + 1) {
                if !may_touch(&one.frame, &other.frame) {
                    let apart = (centers[i] - centers[j]).norm();
                    least = least.min(apart - one.radius - other.radius);
                }
            }
        }
        least
    }

    /// Its controller, which keeps away from the body or does not, and its tool.
    fn flow(&self, keeps_away: bool) -> (RmpFlow, TargetId) {
        let xrdf = &self.files.xrdf;
        let setup = SelfCollisionSetup {
            spheres: &xrdf.self_spheres,
            ignore: &xrdf.self_ignore,
        };
        let setup = if keeps_away {
            setup
        } else {
            SelfCollisionSetup::default()
        };
        let mut flow = self.files.try_flow(0, setup).unwrap();
        let tool = flow.add_target_frame(self.robot.tcp_frame_name()).unwrap();
        (flow, tool)
    }

    /// Follows the targets one after the other; the least distance on the way (m).
    fn follow(&self, targets: &[[f64; 7]], keeps_away: bool) -> f64 {
        let (mut flow, tool) = self.flow(keeps_away);
        let limits = self.robot.limits();
        let mut state = MotionState::at_rest(&self.robot.home());
        let mut least = f64::INFINITY;
        for target in targets {
            aim(&mut flow, tool, *target);
            for tick in 0..TICKS {
                let before = state.clone();
                let step = flow.step_cell(&mut state, &limits, 1.0e-3).unwrap();
                common::assert_within_limits(&before, &state, &limits);
                if tick % 10 == 0 {
                    let now = self.distance(&before.positions);
                    if keeps_away && now < 0.1 {
                        assert!((step.self_clearance - now).abs() < 1e-9, "tick {tick}");
                    }
                    least = least.min(now);
                }
            }
        }
        least
    }
}

#[test]
fn the_parts_of_a_robot_do_not_meet_at_hostile_targets() {
    for name in ["panda", "ur10"] {
        let hostile = targets(name);
        assert_eq!(hostile.len(), 72);
        let body = Body::of(name);
        let least = body.follow(&hostile[..12], true);
        assert!(least > LEAST_M, "{name}: {least}");
        // The targets are what they are called.
        let without = body.follow(&hostile[..12], false);
        assert!(without < LEAST_M, "{name}: {without}");
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn sixty_more_targets_are_no_worse() {
    for name in ["panda", "ur10"] {
        let least = Body::of(name).follow(&targets(name)[12..], true);
        assert!(least > LEAST_M, "{name}: {least}");
    }
}

#[test]
fn what_the_tool_holds_keeps_away_from_the_robot() {
    let body = Body::of("panda");
    let (mut flow, tool) = body.flow(true);
    let limits = body.robot.limits();
    // The tool moves towards the base with a rod of 0.4 m ahead of it.
    aim(&mut flow, tool, [0.25, 0.0, 0.25, 0.0, 1.0, 0.0, 0.0]);
    let rod: Vec<_> = (0..8)
        .map(|i| (Vector3::new(-0.05 * f64::from(i), 0.0, 0.0), 0.02))
        .collect();
    let base = body.files.xrdf.self_spheres.iter();
    let base: Vec<_> = base
        .filter(|s| s.frame == "panda_link1" || s.frame == "panda_link0")
        .collect();
    let mut least = Vec::new();
    for holds in [false, true] {
        if holds {
            flow.carry(tool, &rod).unwrap();
        }
        let mut state = MotionState::at_rest(&body.robot.home());
        let mut nearest = f64::INFINITY;
        for _ in 0..4000 {
            flow.step_cell(&mut state, &limits, 1.0e-3).unwrap();
            let held = flow.target_frame_pose(tool).unwrap();
            for sphere in &base {
                let frame = body.robot.chain.frame_index(&sphere.frame).unwrap();
                let mut all = body.robot.fixed_joint_positions.clone();
                for (&index, position) in body.robot.arm_joints.iter().zip(&state.positions) {
                    all[index] = *position;
                }
                let center =
                    body.robot.frame_pose(frame, &all).unwrap() * Point3::from(sphere.center);
                for (at, radius) in &rod {
                    let apart = (held * Point3::from(*at) - center).norm();
                    nearest = nearest.min(apart - radius - sphere.radius);
                }
            }
        }
        least.push(nearest);
    }
    assert!(
        least[0] < -0.02,
        "without it the rod would not reach: {least:?}"
    );
    assert!(least[1] > LEAST_M, "{least:?}");
}

#[test]
fn the_published_step_knows_no_self_collision() {
    let body = Body::of("panda");
    let mut ends = Vec::new();
    for keeps_away in [true, false] {
        let (mut flow, tool) = body.flow(keeps_away);
        aim(&mut flow, tool, targets("panda")[3]);
        let mut state = MotionState::at_rest(&body.robot.home());
        for _ in 0..500 {
            flow.step_exact(&mut state, 1.0e-3).unwrap();
        }
        let bits = state.positions.iter().map(|q| q.to_bits());
        ends.push(bits.collect::<Vec<_>>());
    }
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn a_frame_that_does_not_exist_is_refused() {
    let files = common::panda();
    let stray = CollisionSphere {
        frame: "elbow".to_owned(),
        center: Vector3::zeros(),
        radius: 0.1,
    };
    let setup = SelfCollisionSetup {
        spheres: &[stray],
        ignore: &[],
    };
    let refused = files.try_flow(0, setup);
    assert!(refused.unwrap_err().to_string().contains("'elbow'"));
}
