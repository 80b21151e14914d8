//! Any URDF as joints, links and frames. Fixed joints are merged into their parent link.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use rmp::{Chain, Frame, Joint, JointKind};
use urdf_rs::{Geometry, JointType};

use crate::error::{Location, ModelError};
use crate::robots::mimic;
use crate::robots::urdf_check;
use crate::robots::urdf_clean;
use crate::robots::urdf_limits::UrdfLimits;
use crate::robots::urdf_scan;
use crate::shape::{Link, LinkShape, Shape};

/// Turns of a continuous joint to each side: a real arm has cables.
pub const CONTINUOUS_TURNS: f64 = 2.0;

/// A URDF, checked and merged.
#[derive(Clone, Debug)]
pub struct UrdfRobot {
    /// Name in the file.
    pub name: String,
    /// Joints and frames.
    pub chain: Chain,
    /// By frame of the chain (the links of the file): the frame of the parent link, which
    /// precedes it; `None` for the base.
    pub parents: Vec<Option<usize>>,
    /// Limits by joint of the chain.
    pub limits: Vec<UrdfLimits>,
    /// The base, then the child link of every joint of the chain.
    pub links: Vec<Link>,
    /// Corrected faults of the file, with file and line.
    pub warnings: Vec<String>,
    /// Number of collision meshes that were left out: only primitives take part in contact.
    pub skipped_meshes: usize,
}

impl UrdfRobot {
    /// Joints that move a frame, starting at the base; a follower is replaced by the joint that
    /// it follows.
    pub(crate) fn joints_to(&self, frame: usize) -> Vec<usize> {
        let mut path = Vec::new();
        let mut next = self.chain.frames().get(frame).and_then(|frame| frame.joint);
        while let Some(joint) = next {
            path.push(joint);
            next = self.chain.joints()[joint].parent;
        }
        path.reverse();
        independent(&self.chain, &path)
    }

    /// Links without children, with the number of joints before them: most joints first.
    pub(crate) fn tips(&self) -> Vec<(usize, usize)> {
        let is_parent = |frame: usize| self.parents.contains(&Some(frame));
        let mut tips: Vec<(usize, usize)> = (0..self.parents.len())
            .filter(|frame| !is_parent(*frame))
            .map(|frame| (frame, self.joints_to(frame).len()))
            .collect();
        // A stable sort: equal ones stay in the order of the file.
        tips.sort_by_key(|(_, joints)| std::cmp::Reverse(*joints));
        tips
    }
}

/// `joints`, with followers replaced by the joints that they follow.
pub(crate) fn independent(chain: &Chain, joints: &[usize]) -> Vec<usize> {
    let mut free = Vec::new();
    for &joint in joints {
        let mimic = chain.joints().get(joint).and_then(|joint| joint.mimic);
        let joint = mimic.map_or(joint, |mimic| mimic.joint);
        if !free.contains(&joint) {
            free.push(joint);
        }
    }
    free
}

/// Reads a URDF; `file` is its name in messages.
///
/// # Errors
/// Returns [`ModelError`], with the name of the link or joint, if the file is not one tree of
/// finite, plausible numbers.
pub fn parse(file: &str, text: &str) -> Result<UrdfRobot, ModelError> {
    // In this order: size and nesting before any parser, whose recursion would overflow the
    // stack; then repairs, and the checks of the repaired text last.
    urdf_scan::scan(file, text)?;
    let cleaned = urdf_clean::clean(file, text)?;
    let robot = urdf_rs::read_from_string(&cleaned.text).map_err(|error| ModelError::Syntax {
        // Without a line: that of the cleaned text is not one of the file.
        place: Location::file(file),
        message: format!("no URDF: {error}"),
    })?;
    urdf_check::check(file, &cleaned.lines, &robot)?;
    let followed = mimic::resolve(file, &cleaned.lines, &robot)?;
    let mut builder = Builder::run(&robot);
    let mut warnings = cleaned.warnings;
    warnings.extend(mimic::couple(
        (file, &cleaned.lines),
        &followed,
        &mut builder.joints,
        &mut builder.limits,
        &builder.kinds,
    ));
    let chain = Chain::new(builder.joints, builder.frames).map_err(|source| ModelError::Chain {
        place: Location::file(file),
        source,
    })?;
    Ok(UrdfRobot {
        name: robot.name.clone(),
        chain,
        parents: builder.parents,
        limits: builder.limits,
        links: builder.links,
        warnings,
        skipped_meshes: builder.skipped_meshes,
    })
}

#[derive(Default)]
struct Builder {
    joints: Vec<Joint>,
    frames: Vec<Frame>,
    parents: Vec<Option<usize>>,
    limits: Vec<UrdfLimits>,
    /// Types in the file, by joint.
    kinds: Vec<JointType>,
    links: Vec<Link>,
    skipped_meshes: usize,
}

impl Builder {
    /// Visits the tree from its root, breadth first, in the order of the file.
    fn run(robot: &urdf_rs::Robot) -> Self {
        let mut builder = Self::default();
        let links: BTreeMap<&str, &urdf_rs::Link> = robot
            .links
            .iter()
            .map(|link| (link.name.as_str(), link))
            .collect();
        let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child.link == name);
        let Some(root) = robot.links.iter().find(|link| !is_child(&link.name)) else {
            return builder;
        };
        let base = builder.link(root);
        builder.links.push(base);
        let place = builder.frame(&root.name, None, (None, Isometry3::identity()));
        let base = (root.name.as_str(), place, None, Isometry3::identity());
        let mut open = VecDeque::from([base]);
        while let Some((parent, place, joint, pose)) = open.pop_front() {
            let edges = robot.joints.iter();
            for edge in edges.filter(|edge| edge.parent.link == parent) {
                let Some(child) = links.get(edge.child.link.as_str()) else {
                    continue;
                };
                let at = pose * to_isometry(&edge.origin);
                // A fixed child moves with its parent: as a separate link it would cost a body
                // in physics.
                let (joint, pose) = if edge.joint_type == JointType::Fixed {
                    builder.merge(child, joint, at);
                    (joint, at)
                } else {
                    (
                        Some(builder.joint(edge, child, joint, at)),
                        Isometry3::identity(),
                    )
                };
                let place = builder.frame(&child.name, Some(place), (joint, pose));
                open.push_back((&child.name, place, joint, pose));
            }
        }
        builder
    }

    /// Adds the frame of a link, with the joint that moves it; returns its index.
    fn frame(
        &mut self,
        name: &str,
        parent: Option<usize>,
        (joint, pose): (Option<usize>, Isometry3<f64>),
    ) -> usize {
        self.frames.push(Frame {
            name: name.to_owned(),
            joint,
            pose,
        });
        self.parents.push(parent);
        self.frames.len() - 1
    }

    fn merge(&mut self, child: &urdf_rs::Link, joint: Option<usize>, pose: Isometry3<f64>) {
        let body = self.link(child);
        if let Some(link) = self.links.get_mut(joint.map_or(0, |joint| joint + 1)) {
            link.absorb(&body, &pose);
        }
    }

    fn joint(
        &mut self,
        edge: &urdf_rs::Joint,
        child: &urdf_rs::Link,
        parent: Option<usize>,
        origin: Isometry3<f64>,
    ) -> usize {
        let continuous = edge.joint_type == JointType::Continuous;
        let turns = CONTINUOUS_TURNS * std::f64::consts::TAU;
        let (lower, upper) = if continuous {
            (-turns, turns)
        } else {
            (edge.limit.lower, edge.limit.upper)
        };
        let prismatic = edge.joint_type == JointType::Prismatic;
        self.joints.push(Joint {
            name: edge.name.clone(),
            parent,
            origin,
            axis: Vector3::from(edge.axis.xyz.0),
            kind: if prismatic {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            },
            lower,
            upper,
            mimic: None,
        });
        self.kinds.push(edge.joint_type.clone());
        let given = |value: f64| (value.is_finite() && value > 0.0).then_some(value);
        self.limits.push(UrdfLimits {
            velocity: given(edge.limit.velocity).unwrap_or(0.0),
            effort: given(edge.limit.effort).unwrap_or(0.0),
            acceleration: given(edge.limit.acceleration),
            jerk: given(edge.limit.jerk),
        });
        let link = self.link(child);
        self.links.push(link);
        self.joints.len() - 1
    }

    fn link(&mut self, link: &urdf_rs::Link) -> Link {
        let inertial = &link.inertial;
        let pose = to_isometry(&inertial.origin);
        let rotation = pose.rotation.to_rotation_matrix();
        let i = &inertial.inertia;
        let inertia = Matrix3::new(
            i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz,
        );
        let mut shapes = Vec::new();
        for collision in &link.collision {
            match to_shape(&collision.geometry) {
                Some(shape) => shapes.push(LinkShape {
                    shape,
                    pose: to_isometry(&collision.origin),
                }),
                None => self.skipped_meshes += 1,
            }
        }
        Link {
            name: link.name.clone(),
            mass: inertial.mass.value,
            center_of_mass: pose.translation.vector,
            inertia: rotation.matrix() * inertia * rotation.matrix().transpose(),
            shapes,
        }
    }
}

/// A URDF pose: translation, then roll, pitch, yaw about fixed axes.
fn to_isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [x, y, z] = pose.xyz.0;
    let [roll, pitch, yaw] = pose.rpy.0;
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

fn to_shape(geometry: &Geometry) -> Option<Shape> {
    let shape = match *geometry {
        Geometry::Box { size } => Shape::Box { size_m: size.0 },
        Geometry::Sphere { radius } => Shape::Sphere { radius_m: radius },
        Geometry::Cylinder { radius, length } => Shape::Cylinder {
            radius_m: radius,
            height_m: length,
        },
        Geometry::Capsule { radius, length } => Shape::Capsule {
            radius_m: radius,
            height_m: length,
        },
        Geometry::Mesh { .. } => return None,
    };
    shape
        .lengths()
        .iter()
        .all(|(_, length)| *length > 0.0)
        .then_some(shape)
}
