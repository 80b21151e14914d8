//! Frames and shapes of an arm's links, for other tools.

use cell_model::robots::urdf::{self, UrdfRobot};
use cell_model::{LinkShape, Shape};
use ipc_types::{ArmState, Pose};
use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use rmp::{Chain, JointKind};
use serde_json::Value;

/// The links of an arm, parents first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Links(Vec<Link>);

#[derive(Clone, Debug)]
struct Link {
    /// As in `left/panda_link3`.
    name: String,
    parent: String,
    /// Its pose in the parent's frame, while its joint is at 0.
    origin: Isometry3<f64>,
    motion: Option<Motion>,
}

/// Motion of a link in the frame of its parent.
#[derive(Clone, Debug)]
struct Motion {
    kind: JointKind,
    axis: Unit<Vector3<f64>>,
    source: Source,
    /// Factor and offset of the position: of a joint that copies another one.
    law: (f64, f64),
}

/// Place of a joint's position in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// A joint that is controlled.
    Joint(usize),
    /// A finger, which moves by half of the hand's width.
    Finger,
    /// A joint without a drive.
    Rest,
}

/// A primitive that a link is made of.
pub(crate) struct Solid {
    /// Frame it is fixed to.
    pub(crate) frame: String,
    pub(crate) pose: Isometry3<f64>,
    pub(crate) shape: Shape,
}

impl Links {
    /// The links of an arm of the page's scene; `base` is its pose in frame `world`. Empty if
    /// the scene has no URDF.
    pub(crate) fn of(arm: &Value, world: &str, base: &Pose) -> Self {
        let Some(urdf) = robot(arm) else {
            return Self::default();
        };
        let frames = urdf.chain.frames();
        let link = |(index, frame): (usize, &rmp::Frame)| {
            let parent = urdf.parents.get(index).copied().flatten();
            let parent = parent.and_then(|parent| frames.get(parent));
            // The root is fixed to the world: the base of an arm does not move.
            let Some(parent) = parent else {
                return Link {
                    name: frame_name(arm, &frame.name),
                    parent: world.to_owned(),
                    origin: isometry(base) * frame.pose,
                    motion: None,
                };
            };
            // A frame of the same joint as its parent is fixed to it, e.g. a flange.
            let moves = frame.joint.filter(|joint| parent.joint != Some(*joint));
            let joint = moves.and_then(|joint| urdf.chain.joints().get(joint));
            let from = joint.map_or_else(Isometry3::identity, |joint| joint.origin);
            Link {
                name: frame_name(arm, &frame.name),
                parent: frame_name(arm, &parent.name),
                // The constant part once here, so that a state costs one product per link.
                origin: parent.pose.inverse() * from * frame.pose,
                motion: joint.map(|joint| motion(arm, &urdf.chain, joint)),
            }
        };
        Self(frames.iter().enumerate().map(link).collect())
    }

    /// Whether a link has this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|link| link.name == name)
    }

    /// Parent, name and pose in the parent's frame of the links that move, or of all.
    pub(crate) fn poses(
        &self,
        state: &ArmState,
        is_all: bool,
    ) -> impl Iterator<Item = (&str, &str, Pose)> {
        let shown = self.0.iter();
        let shown = shown.filter(move |link| is_all || link.motion.is_some());
        shown.map(move |link| {
            // Fixed links have no joint: their pose is the origin.
            let motion = link.motion.as_ref();
            let moved = motion.map_or_else(Isometry3::identity, |motion| motion.at(state));
            let pose = pose(&(link.origin * moved));
            (link.parent.as_str(), link.name.as_str(), pose)
        })
    }
}

impl Motion {
    fn at(&self, state: &ArmState) -> Isometry3<f64> {
        let position = match self.source {
            Source::Joint(joint) => state.joint_positions.get(joint).copied().unwrap_or(0.0),
            // Each finger moves by half of the distance between both.
            Source::Finger => 0.5 * state.gripper.width,
            Source::Rest => 0.0,
        };
        let position = self.law.0 * position + self.law.1;
        match self.kind {
            JointKind::Revolute => Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&self.axis, position),
            ),
            JointKind::Prismatic => Isometry3::from_parts(
                Translation3::from(self.axis.scale(position)),
                UnitQuaternion::identity(),
            ),
        }
    }
}

/// Motion of `joint`: its own, or that of the controlled joint it copies.
fn motion(arm: &Value, chain: &Chain, joint: &rmp::Joint) -> Motion {
    let followed = joint.mimic.and_then(|mimic| {
        let source = source(arm, &chain.joints().get(mimic.joint)?.name);
        // A joint that copies a finger has its own place in the state already.
        matches!(source, Source::Joint(_)).then_some((source, (mimic.multiplier, mimic.offset)))
    });
    let (source, law) = followed.unwrap_or_else(|| (source(arm, &joint.name), (1.0, 0.0)));
    Motion {
        kind: joint.kind,
        axis: Unit::new_normalize(joint.axis),
        source,
        law,
    }
}

/// Solids of an arm's links: the primitives that take part in contact, or the collision spheres
/// if there are none.
pub(crate) fn solids(arm: &Value) -> Vec<Solid> {
    let urdf = robot(arm);
    let links = urdf.iter().flat_map(|urdf| &urdf.links);
    let solids = links.flat_map(|link| {
        let frame = frame_name(arm, &link.name);
        link.shapes
            .iter()
            .map(move |LinkShape { shape, pose }| Solid {
                frame: frame.clone(),
                pose: *pose,
                shape: shape.clone(),
            })
    });
    let solids: Vec<Solid> = solids.collect();
    // Spheres are a rough picture; they are used only where the file has no shapes.
    if !solids.is_empty() {
        return solids;
    }
    let spheres = arm["spheres"].as_array().into_iter().flatten();
    let sphere = |sphere: &Value| {
        let centre = |axis: usize| sphere["center"][axis].as_f64().unwrap_or(0.0);
        Solid {
            frame: frame_name(arm, sphere["link"].as_str().unwrap_or_default()),
            pose: Isometry3::translation(centre(0), centre(1), centre(2)),
            shape: Shape::Sphere {
                radius_m: sphere["radius"].as_f64().unwrap_or(0.0),
            },
        }
    };
    spheres.map(sphere).collect()
}

/// Parses the robot; the cell was loaded from the same text, so this does not fail.
fn robot(arm: &Value) -> Option<UrdfRobot> {
    urdf::parse("scene", arm["urdf"].as_str()?).ok()
}

fn frame_name(arm: &Value, link: &str) -> String {
    format!("{}/{link}", arm["name"].as_str().unwrap_or_default())
}

/// The scene names the controlled joints in the order of the state, then the fingers.
fn source(arm: &Value, joint: &str) -> Source {
    let joints = arm["joints"].as_array().into_iter().flatten();
    let place = joints
        .map(|one| one["name"].as_str())
        .position(|one| one == Some(joint));
    // Without the count all named joints are taken for controlled ones.
    let controlled = arm["arm_joints"].as_u64().unwrap_or(u64::MAX);
    match place {
        Some(place) if (place as u64) < controlled => Source::Joint(place),
        Some(_) => Source::Finger,
        None => Source::Rest,
    }
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let ([x, y, z], [w, i, j, k]) = (pose.position, pose.orientation_wxyz);
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)),
    )
}

/// A pose in the format of messages.
pub(crate) fn pose(pose: &Isometry3<f64>) -> Pose {
    let (t, q) = (&pose.translation, &pose.rotation);
    Pose {
        position: [t.x, t.y, t.z],
        orientation_wxyz: [q.w, q.i, q.j, q.k],
    }
}

#[cfg(test)]
mod tests {
    use ipc_types::Wire as _;
    use serde_json::json;

    use super::*;

    const URDF: &str = r#"<robot name="bar">
  <link name="base_link"/>
  <link name="upper"><collision>
    <origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry>
  </collision></link>
  <link name="flange"/>
  <link name="finger"/>
  <joint name="turn" type="revolute">
    <parent link="base_link"/><child link="upper"/>
    <origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="10"/>
  </joint>
  <joint name="bolt" type="fixed">
    <parent link="upper"/><child link="flange"/><origin xyz="1 0 0"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="flange"/><child link="finger"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="10"/>
  </joint>
</robot>"#;

    fn arm() -> Value {
        json!({
            "name": "left", "urdf": URDF, "arm_joints": 1,
            "joints": [{ "name": "turn" }, { "name": "slide" }],
        })
    }

    fn base() -> Pose {
        Pose {
            position: [0.0, 2.0, 0.0],
            ..Pose::IDENTITY
        }
    }

    #[test]
    fn the_links_lead_from_the_world_to_the_finger() {
        let links = Links::of(&arm(), "world", &base());
        let mut state = ArmState::zeroed();
        state.joint_positions[0] = std::f64::consts::FRAC_PI_2;
        state.gripper.width = 0.06;
        let poses: Vec<_> = links.poses(&state, true).collect();
        let names: Vec<_> = poses
            .iter()
            .map(|(parent, name, _)| (*parent, *name))
            .collect();
        let wanted = [
            ("world", "left/base_link"),
            ("left/base_link", "left/upper"),
            ("left/upper", "left/flange"),
            ("left/flange", "left/finger"),
        ];
        assert_eq!(names, wanted);
        let all = poses.iter().map(|(.., pose)| isometry(pose));
        let finger = all.fold(Isometry3::identity(), |sum, pose| sum * pose);
        // A quarter turn: the bar points along y, and the finger slides along -x.
        let wanted = Vector3::new(-0.03, 3.0, 0.4);
        assert!(
            (finger.translation.vector - wanted).norm() < 1e-12,
            "{finger}"
        );
        let moving: Vec<_> = links
            .poses(&state, false)
            .map(|(_, name, _)| name)
            .collect();
        assert_eq!(moving, ["left/upper", "left/finger"]);
    }

    #[test]
    fn a_joint_that_copies_a_controlled_one_moves_with_it() {
        let mut arm = arm();
        let copy = "<mimic joint=\"turn\" multiplier=\"0.02\" offset=\"0.01\"/></joint>\n</robot>";
        arm["urdf"] = URDF.replace("</joint>\n</robot>", copy).into();
        arm["joints"] = json!([{ "name": "turn" }]);
        let links = Links::of(&arm, "world", &base());
        let mut state = ArmState::zeroed();
        state.joint_positions[0] = 0.5;
        let slid = links
            .poses(&state, true)
            .find(|(_, name, _)| *name == "left/finger");
        let (.., pose) = slid.unwrap();
        assert!((pose.position[1] - 0.02).abs() < 1e-12, "{pose:?}");
    }

    #[test]
    fn links_are_made_of_their_primitives_or_of_spheres() {
        let solids = super::solids(&arm());
        assert_eq!(solids.len(), 1);
        assert_eq!(solids[0].frame, "left/upper");
        assert_eq!(solids[0].pose.translation.x, 0.5);
        let mut bare = arm();
        bare["urdf"] = Value::Null;
        bare["spheres"] = json!([{ "link": "upper", "center": [0, 0, 1], "radius": 0.2 }]);
        let solids = super::solids(&bare);
        let is_sphere = matches!(solids[0].shape, Shape::Sphere { radius_m } if radius_m == 0.2);
        assert!(is_sphere && solids[0].frame == "left/upper");
        assert!(Links::of(&bare, "world", &base()).0.is_empty());
    }
}
