//! An arm for the planner: joints in the order of evaluation, each with the spheres that it
//! carries.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use rmp::{Carrier, Chain, CollisionSphere, Joint, JointKind, Tree, TreeJoint};
use thiserror::Error;

use crate::scene::single;

/// Largest number of planned joints.
// The frames of all joints of a pass are kept in an array of this size, on the stack.
pub(crate) const MAX_JOINTS: usize = 16;

/// Data to build a [`Body`] from.
#[derive(Debug, Clone, Copy)]
pub struct BodySetup<'a> {
    /// The robot.
    pub chain: &'a Chain,
    /// The joints that are planned, in the order of every configuration.
    pub joint_names: &'a [String],
    /// Positions of all other joints (rad or m); the default is zero, moved into the limits of
    /// the joint.
    pub default_positions: &'a BTreeMap<String, f64>,
    /// Spheres that keep away from the scene.
    pub spheres: &'a [CollisionSphere],
    /// Spheres that keep away from each other.
    pub self_spheres: &'a [CollisionSphere],
    /// Pairs of frames that may touch.
    pub self_ignore: &'a [(String, String)],
    /// Frame that carries a held object, see [`Body::carrying`].
    pub tool: &'a str,
}

/// Why an arm cannot be planned for.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BodyError {
    /// A joint that the chain does not have, or that is named twice.
    #[error(transparent)]
    Joints(#[from] rmp::SetupError),
    /// Too few or too many joints, those that follow others included.
    #[error("{0} joints cannot be planned; 1 to {MAX_JOINTS} are allowed")]
    Count(usize),
    /// A frame that the chain does not have.
    #[error("the robot has no frame '{0}', which carries a collision sphere")]
    Frame(String),
    /// A tool that the chain does not have.
    #[error("the robot has no frame '{0}' for a tool")]
    Tool(String),
}

/// The arm.
#[derive(Debug, Clone)]
pub struct Body {
    pub(crate) joints: Vec<BodyJoint>,
    /// Spheres against the scene, by the joint that carries them.
    pub(crate) parts: Vec<Part>,
    /// Spheres against each other, by frame.
    pub(crate) self_parts: Vec<Part>,
    pub(crate) self_pairs: Vec<(usize, usize)>,
    /// Limits in the order of configurations.
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    /// The joint of the tool, and the pose of the tool there.
    tool: Carrier,
}

/// A joint that turns about, or slides along, the z axis of its frame.
#[derive(Debug, Clone)]
pub(crate) struct BodyJoint {
    pub(crate) parent: Option<usize>,
    pub(crate) slot: usize,
    pub(crate) ratio: f32,
    pub(crate) slides: bool,
    /// Columns of its rotation in the parent's frame.
    pub(crate) columns: [[f32; 3]; 3],
    pub(crate) offset: [f32; 3],
}

impl From<&TreeJoint> for BodyJoint {
    fn from(joint: &TreeJoint) -> Self {
        let column = |c: usize| [0, 1, 2].map(|r| single(joint.rotation[(r, c)]));
        Self {
            parent: joint.parent,
            slot: joint.slot,
            ratio: single(joint.ratio),
            slides: joint.kind == JointKind::Prismatic,
            columns: [column(0), column(1), column(2)],
            offset: [0, 1, 2].map(|i| single(joint.offset[i])),
        }
    }
}

/// Spheres that move with one joint.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// The joint; `None` is the base.
    pub(crate) joint: Option<usize>,
    /// Sphere around all of them.
    pub(crate) bound: Ball,
    pub(crate) balls: Vec<Ball>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball {
    pub(crate) center: [f32; 3],
    pub(crate) radius: f32,
}

impl Body {
    /// The arm of `setup`.
    ///
    /// # Errors
    /// [`BodyError`] if a named joint or frame is not in the chain, or if not 1 to 16 joints
    /// are planned.
    pub fn new(setup: &BodySetup<'_>) -> Result<Self, BodyError> {
        let (chain, names) = (setup.chain, setup.joint_names);
        if !(1..=MAX_JOINTS).contains(&names.len()) {
            return Err(BodyError::Count(names.len()));
        }
        let tree = Tree::new(chain, names, setup.default_positions)?;
        let joints: Vec<BodyJoint> = tree.joints().iter().map(BodyJoint::from).collect();
        // Joints that follow others take a frame each, so they count, too.
        if joints.len() > MAX_JOINTS {
            return Err(BodyError::Count(joints.len()));
        }
        let place = |sphere: &CollisionSphere| {
            let index = chain.frame_index(&sphere.frame);
            let index = index.ok_or_else(|| BodyError::Frame(sphere.frame.clone()))?;
            let (joint, pose) = tree.carrier_of(&chain.frames()[index]);
            let center = pose * Point3::from(sphere.center);
            Ok((joint, center.coords, sphere.radius))
        };
        let tool = chain.frame_index(setup.tool);
        let tool = tool.ok_or_else(|| BodyError::Tool(setup.tool.to_owned()))?;
        let tool = tree.carrier_of(&chain.frames()[tool]);
        let placed = |spheres: &[CollisionSphere]| -> Result<Vec<Placed>, BodyError> {
            spheres.iter().map(place).collect()
        };
        let world = placed(setup.spheres)?;
        let mut parts = Vec::new();
        for joint in std::iter::once(None).chain((0..joints.len()).map(Some)) {
            let of_joint = world.iter().filter(|ball| ball.0 == joint);
            parts.extend(Part::new(joint, of_joint));
        }
        // The base does not move, so its contacts do not depend on the path.
        parts.retain(|part| part.joint.is_some());
        let (self_parts, self_pairs) = self_parts(setup, &placed(setup.self_spheres)?);
        let limits = |of: fn(&Joint) -> f64| -> Vec<f64> {
            let named = names.iter().filter_map(|name| chain.joint_index(name));
            named.map(|index| of(&chain.joints()[index])).collect()
        };
        Ok(Self {
            lower: limits(|joint| joint.lower),
            upper: limits(|joint| joint.upper),
            joints,
            parts,
            self_parts,
            self_pairs,
            tool,
        })
    }

    /// The arm with spheres that its tool carries: centre in the tool frame and radius (m).
    /// They keep away from the scene, and from those parts of the arm from which a part on the
    /// joint of the tool keeps away.
    #[must_use]
    pub fn carrying(&self, spheres: &[(Vector3<f64>, f64)]) -> Self {
        let mut body = self.clone();
        let (joint, pose) = self.tool;
        let place = |(center, radius): &(Vector3<f64>, f64)| {
            (joint, (pose * Point3::from(*center)).coords, *radius)
        };
        let placed: Vec<Placed> = spheres.iter().map(place).collect();
        let Some(held) = Part::new(joint, placed.iter()) else {
            return body;
        };
        let holds = |part: usize| self.self_parts[part].joint == joint;
        let keeps_away = |part: usize| {
            let is_pair = |&(a, b): &(usize, usize)| a == part && holds(b) || b == part && holds(a);
            self.self_pairs.iter().any(is_pair)
        };
        let last = self.self_parts.len();
        let pairs = (0..last).filter(|part| keeps_away(*part));
        body.self_pairs.extend(pairs.map(|part| (part, last)));
        body.self_parts.push(held.clone());
        body.parts.push(held);
        body
    }

    /// Number of joints of a configuration.
    pub fn joint_count(&self) -> usize {
        self.lower.len()
    }
}

/// Joint, centre (m) and radius (m) of a sphere.
type Placed = (Option<usize>, Vector3<f64>, f64);

impl Part {
    fn new<'a>(joint: Option<usize>, balls: impl Iterator<Item = &'a Placed>) -> Option<Self> {
        let all: Vec<&Placed> = balls.collect();
        if all.is_empty() {
            return None;
        }
        let far = Vector3::repeat(f64::INFINITY);
        let (low, high) = all
            .iter()
            .fold((far, -far), |(low, high), (_, at, radius)| {
                let r = Vector3::repeat(*radius);
                (low.inf(&(at - r)), high.sup(&(at + r)))
            });
        let center = 0.5 * (low + high);
        // Around the middle of the box: not the smallest sphere, but one without a search.
        let reach = |ball: &&Placed| (ball.1 - center).norm() + ball.2;
        let radius = all.iter().map(reach).fold(0.0, f64::max);
        let ball = |center: &Vector3<f64>, radius: f64| Ball {
            center: [single(center.x), single(center.y), single(center.z)],
            radius: single(radius),
        };
        Some(Self {
            joint,
            bound: ball(&center, radius),
            balls: all
                .iter()
                .map(|(_, at, radius)| ball(at, *radius))
                .collect(),
        })
    }
}

/// The spheres of each frame, and the pairs of frames on different joints that may not touch.
fn self_parts(setup: &BodySetup<'_>, placed: &[Placed]) -> (Vec<Part>, Vec<(usize, usize)>) {
    let mut frames: Vec<&str> = Vec::new();
    for sphere in setup.self_spheres {
        if !frames.contains(&sphere.frame.as_str()) {
            frames.push(&sphere.frame);
        }
    }
    let of_frame = |frame: &&str| {
        let balls = setup.self_spheres.iter().zip(placed);
        let balls = balls.filter(|(sphere, _)| sphere.frame == **frame);
        let mut balls = balls.map(|(_, ball)| ball).peekable();
        let joint = balls.peek().and_then(|ball| ball.0);
        Part::new(joint, balls)
    };
    let parts: Vec<Part> = frames.iter().filter_map(of_frame).collect();
    let may_touch = |a: usize, b: usize| {
        let is_pair = |(one, other): &(String, String)| {
            let (a, b) = (frames[a], frames[b]);
            (one == a && other == b) || (one == b && other == a)
        };
        // On one joint the distance never changes: a pair that overlaps there would block
        // every path.
        parts[a].joint == parts[b].joint || setup.self_ignore.iter().any(is_pair)
    };
    let mut pairs = Vec::new();
    for a in 0..parts.len() {
        for b in a + 1..parts.len() {
            if !may_touch(a, b) {
                pairs.push((a, b));
            }
        }
    }
    (parts, pairs)
}
