//! Building a controller from checked data.

use nalgebra::Vector3;

use crate::ball::{Ball, MAX_CARRIED};
use crate::groups::{Group, group};
use crate::kinematics::Kinematics;
use crate::leaves::Floor;
use crate::leaves::collision::Constants;
use crate::leaves::joint_limit::Range;
use crate::pullback::Pullback;
use crate::resolve::cell::CellResolve;
use crate::resolve::cholesky::Cholesky;
use crate::self_collision::{Part, SelfCollision};
use crate::simd::Path;
use crate::tree::{Attachment, Tree, default_of};
use crate::{
    Chain, CollisionSphere, Obstacle, ObstacleSet, RmpFlow, RmpFlowParameters, RmpFlowSetup, Root,
    SelfCollisionSetup, SetupError,
};

pub(crate) fn build(setup: &RmpFlowSetup) -> Result<RmpFlow, SetupError> {
    let parameters = setup.parameters.clone();
    parameters.validate()?;
    let tree = Tree::new(setup.chain, setup.joint_names, setup.default_positions)?;
    let joints = setup.joint_names.len();
    let moving = tree.joints().len();
    let balls = balls(setup.chain, setup.spheres, &tree)?;
    let body = body_capsules(&parameters)?;
    // The buffer of near obstacles serves the capsules of the body as well.
    let most_obstacles = setup.obstacle_capacity.max(body.len());
    let mut flow = RmpFlow {
        chain: setup.chain.clone(),
        constants: Constants::new(&parameters.collision),
        ranges: ranges(setup)?,
        posture: posture(setup),
        targets: Vec::new(),
        groups: grouped(&balls),
        balls,
        self_collision: self_collision(setup, &tree)?,
        carried: Vec::with_capacity(MAX_CARRIED),
        carried_groups: Vec::with_capacity(MAX_CARRIED),
        carrier: None,
        body_groups: grouped(&body_balls(setup.chain, &tree, &parameters)?),
        body,
        near: Vec::with_capacity(most_obstacles),
        obstacles: ObstacleSet::with_capacity(setup.obstacle_capacity),
        path: Path::best(),
        kinematics: Kinematics::new(tree),
        pullback: Pullback::new(moving),
        root: Root::new(joints),
        clearance: None,
        factor: Cholesky::new(joints),
        scratch: vec![0.0; joints],
        acceleration: vec![0.0; joints],
        cell: CellResolve::new(joints, parameters.joint_velocity_cap.max_velocity),
        parameters,
    };
    // One evaluation, so that poses and clearance are valid before the first step.
    let (q, qd) = (flow.posture.clone(), vec![0.0; joints]);
    flow.sum_leaves(&q, &qd, Floor::Contact);
    Ok(flow)
}

fn grouped(balls: &[Ball]) -> Vec<Group> {
    let mut groups = Vec::new();
    group(balls, &mut groups);
    groups
}

/// Attaches the named frame; `wanted_by` is the reason in the error.
pub(crate) fn attach(
    chain: &Chain,
    tree: &Tree,
    name: &str,
    wanted_by: &str,
) -> Result<Attachment, SetupError> {
    attach_at(chain, tree, name, Vector3::zeros(), wanted_by)
}

fn attach_at(
    chain: &Chain,
    tree: &Tree,
    name: &str,
    local: Vector3<f64>,
    wanted_by: &str,
) -> Result<Attachment, SetupError> {
    chain
        .frames()
        .iter()
        .find(|frame| frame.name == name)
        .map(|frame| tree.attach(frame, local))
        .ok_or_else(|| SetupError::UnknownFrame {
            name: name.to_owned(),
            wanted_by: wanted_by.to_owned(),
        })
}

/// Position limits of the controlled joints less their buffers.
fn ranges(setup: &RmpFlowSetup) -> Result<Vec<Range>, SetupError> {
    let buffers = &setup.parameters.joint_limit_buffers;
    if buffers.len() != setup.joint_names.len() {
        return Err(SetupError::Length {
            what: "joint_limit_buffers",
            found: buffers.len(),
            expected: setup.joint_names.len(),
        });
    }
    let joint = |name: &String| setup.chain.joints().iter().find(|j| j.name == *name);
    let mut ranges = Vec::with_capacity(buffers.len());
    for (name, &buffer) in setup.joint_names.iter().zip(buffers) {
        let joint = joint(name).ok_or_else(|| SetupError::UnknownJoint { name: name.clone() })?;
        let range = Range {
            lower: joint.lower + buffer,
            upper: joint.upper - buffer,
        };
        // An empty range has no width to divide the distances by.
        if range.lower >= range.upper {
            return Err(SetupError::Buffer {
                joint: name.clone(),
                lower: joint.lower,
                upper: joint.upper,
                buffer,
            });
        }
        ranges.push(range);
    }
    Ok(ranges)
}

fn posture(setup: &RmpFlowSetup) -> Vec<f64> {
    let joints = setup.chain.joints();
    let default = |name: &String| {
        let joint = joints.iter().find(|j| j.name == *name);
        joint.map_or(0.0, |j| default_of(j, setup.default_positions))
    };
    setup.joint_names.iter().map(default).collect()
}

/// The moving spheres; one that is fixed in the base has no leaf.
fn balls(chain: &Chain, spheres: &[CollisionSphere], tree: &Tree) -> Result<Vec<Ball>, SetupError> {
    let mut balls = Vec::with_capacity(spheres.len());
    for sphere in spheres {
        let numbers = sphere.center.iter().chain(std::iter::once(&sphere.radius));
        for &value in numbers {
            if !value.is_finite() || sphere.radius < 0.0 {
                return Err(SetupError::NotFinite {
                    what: format!("a collision sphere of frame '{}'", sphere.frame),
                    value,
                });
            }
        }
        let wanted_by = "a collision sphere";
        let attachment = attach_at(chain, tree, &sphere.frame, sphere.center, wanted_by)?;
        balls.push(Ball {
            attachment,
            radius: sphere.radius,
        });
    }
    Ok(balls)
}

/// The parts of the robot, which are the spheres of each frame, and the pairs of parts on
/// different joints that may not touch.
fn self_collision(setup: &RmpFlowSetup, tree: &Tree) -> Result<SelfCollision, SetupError> {
    let SelfCollisionSetup { spheres, ignore } = setup.self_collision;
    let mut frames: Vec<&str> = Vec::new();
    for sphere in spheres {
        if !frames.contains(&sphere.frame.as_str()) {
            frames.push(&sphere.frame);
        }
    }
    let mut parts = Vec::with_capacity(frames.len());
    for frame in &frames {
        let of_frame = spheres.iter().filter(|sphere| sphere.frame == *frame);
        let of_frame: Vec<CollisionSphere> = of_frame.cloned().collect();
        parts.push(Part::new(balls(setup.chain, &of_frame, tree)?));
    }
    let may_touch = |a: &str, b: &str| {
        let both =
            |(one, other): &(String, String)| (one == a && other == b) || (one == b && other == a);
        ignore.iter().any(both)
    };
    // Pairs are found once: a cycle only walks the list.
    let mut pairs = Vec::new();
    for a in 0..parts.len() {
        for b in a + 1..parts.len() {
            // On one joint the distance never changes, and no motion could increase it.
            if parts[a].joint != parts[b].joint && !may_touch(frames[a], frames[b]) {
                pairs.push((a, b));
            }
        }
    }
    Ok(SelfCollision::new(parts, pairs, setup.joint_names.len()))
}

fn body_balls(
    chain: &Chain,
    tree: &Tree,
    parameters: &RmpFlowParameters,
) -> Result<Vec<Ball>, SetupError> {
    let mut balls = Vec::with_capacity(parameters.body_collision_controllers.len());
    for controller in &parameters.body_collision_controllers {
        let attachment = attach(chain, tree, &controller.name, "body_collision_controllers")?;
        if attachment.joint.is_some() {
            balls.push(Ball {
                attachment,
                radius: controller.radius,
            });
        }
    }
    Ok(balls)
}

fn body_capsules(parameters: &RmpFlowParameters) -> Result<ObstacleSet, SetupError> {
    let mut set = ObstacleSet::with_capacity(parameters.body_capsules.len());
    for capsule in &parameters.body_capsules {
        set.add(Obstacle::capsule(capsule.pt1, capsule.pt2, capsule.radius))?;
    }
    Ok(set)
}
