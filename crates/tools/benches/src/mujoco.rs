//! The same scene in `MuJoCo`, in a separate Python process with that package.

use std::fmt::Write as _;

use cell_model::{ArmSpec, Cell, Shape};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rmp::JointKind;

use crate::python::PythonStepper;

const PROGRAM: &str = include_str!("mujoco.py");
/// Steps of the empty model, and those in one call.
const CALLS: usize = 10_000;
const BLOCK: usize = 100;
/// Friction of links that are not pads, as in ours.
const LINK_FRICTION: f64 = 0.5;
/// Links collide with objects and fixtures, not with each other, as in ours.
const LINK_GROUPS: &str = "contype=\"2\" conaffinity=\"1\"";
const OBJECT_GROUPS: &str = "contype=\"1\" conaffinity=\"3\"";

/// Note of a report if the package is missing.
pub(crate) const MISSING: &str =
    "MuJoCo is not installed (pip install mujoco): nothing to compare with";

/// Differences from the defaults of `MuJoCo`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Settings {
    /// Attributes of its `option` element, besides the length of the step.
    pub(crate) option: &'static str,
    /// Attributes of all its geoms.
    pub(crate) geoms: &'static str,
    /// The fingers of a hand move alike, as in ours.
    pub(crate) coupled: bool,
}

/// Sets up a cell; `None` without Python or `MuJoCo`.
pub(crate) fn start(cell: &Cell, settings: Settings) -> Option<PythonStepper> {
    PythonStepper::start(PROGRAM, &mjcf(cell, settings))
}

/// Time that the call from Python and the clock add to a step (ns): a step of an empty model in
/// one call, compared with many steps in one call.
pub(crate) fn time_of_call() -> Option<u64> {
    let mut empty = PythonStepper::start(PROGRAM, "<mujoco/>")?;
    let alone = median(empty.step(CALLS, &[]))?;
    let together = median(empty.blocks(CALLS / BLOCK, BLOCK))?;
    Some(alone.saturating_sub(together / BLOCK as u64))
}

fn median(mut times_ns: Vec<u64>) -> Option<u64> {
    times_ns.sort_unstable();
    times_ns.get(times_ns.len() / 2).copied()
}

/// The scene in `MuJoCo`'s format. A control of 0 holds a joint at its start position.
fn mjcf(cell: &Cell, settings: Settings) -> String {
    let Settings {
        option, geoms: own, ..
    } = settings;
    let mut out = format!(
        "<mujoco><compiler angle=\"radian\"/><option timestep=\"0.001\" {option}/>\n\
         <default><geom {own}/></default><worldbody>\n"
    );
    for fixture in &cell.fixtures {
        let surface = Surface::of_object(fixture.friction);
        geoms(&mut out, &fixture.shape, &fixture.pose, 1.0, surface);
    }
    for object in &cell.objects {
        let (name, at) = (&object.name, placed(&object.pose));
        let _infallible = writeln!(out, "<body name=\"{name}\" {at}><freejoint/>");
        let (mass, surface) = (object.mass, Surface::of_object(object.friction));
        geoms(
            &mut out,
            &object.shape,
            &Isometry3::identity(),
            mass,
            surface,
        );
        out.push_str("</body>\n");
    }
    let (mut drives, mut couplings) = (String::new(), String::new());
    for (index, arm) in cell.arms.iter().enumerate() {
        add_arm(&mut out, &mut drives, index, arm);
        if settings.coupled {
            couplings.push_str(&coupling(index, arm));
        }
    }
    let _infallible = writeln!(
        out,
        "</worldbody><equality>{couplings}</equality><actuator>{drives}</actuator></mujoco>"
    );
    out
}

fn coupling(index: usize, arm: &ArmSpec) -> String {
    let gripper = arm.robot.gripper.as_ref();
    gripper.map_or_else(String::new, |gripper| {
        let [left, right] = gripper.finger_joints.map(|joint| joint_name(index, joint));
        format!("<joint joint1=\"{left}\" joint2=\"{right}\"/>")
    })
}

fn joint_name(arm: usize, joint: usize) -> String {
    format!("arm{arm}_joint{joint}")
}

/// The links of an arm as bodies, its joints with drives.
fn add_arm(out: &mut String, drives: &mut String, index: usize, arm: &ArmSpec) {
    let home = arm.robot.with_arm_positions(&arm.home);
    let _infallible = writeln!(out, "<body {}>", placed(&arm.base));
    add_link(out, arm, 0);
    add_children(out, drives, (index, arm), &home, None);
    out.push_str("</body>\n");
}

fn add_children(
    out: &mut String,
    // Recursive, as bodies of MJCF are nested like the joints of an arm.
    drives: &mut String,
    (index, arm): (usize, &ArmSpec),
    home: &[f64],
    parent: Option<usize>,
) {
    let joints = arm.robot.chain.joints().iter().enumerate();
    for (number, joint) in joints.filter(|(_, joint)| joint.parent == parent) {
        let spec = arm.robot.joints[number];
        let kind = match joint.kind {
            JointKind::Prismatic => "slide",
            JointKind::Revolute => "hinge",
        };
        let [x, y, z] = joint.axis.into();
        let name = joint_name(index, number);
        let at = joint.origin * cell_model::robots::robot::joint_motion(joint, home[number]);
        let _infallible = writeln!(
            out,
            "<body {}><joint name=\"{name}\" type=\"{kind}\" axis=\"{x} {y} {z}\" \
             damping=\"{}\" armature=\"{}\" range=\"{} {}\"/>",
            placed(&at),
            spec.joint_damping,
            spec.armature,
            // Ranges are from the start position, where the joint of MJCF has its 0.
            spec.lower - home[number],
            spec.upper - home[number]
        );
        let _infallible = writeln!(
            drives,
            "<position joint=\"{name}\" kp=\"{}\" kv=\"{}\" forcerange=\"-{effort} {effort}\"/>",
            spec.stiffness,
            spec.damping,
            effort = spec.effort
        );
        add_link(out, arm, number + 1);
        add_children(out, drives, (index, arm), home, Some(number));
        out.push_str("</body>\n");
    }
}

/// Link 0 is the base.
fn add_link(out: &mut String, arm: &ArmSpec, index: usize) {
    let Some(link) = arm.robot.links.get(index) else {
        return;
    };
    if link.mass > 0.0 {
        let (c, i) = (link.center_of_mass, link.inertia);
        let _infallible = writeln!(
            out,
            "<inertial pos=\"{} {} {}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>",
            c.x,
            c.y,
            c.z,
            link.mass,
            i[(0, 0)],
            i[(1, 1)],
            i[(2, 2)],
            i[(0, 1)],
            i[(0, 2)],
            i[(1, 2)]
        );
    }
    let gripper = arm.robot.gripper.as_ref();
    let hand = gripper.filter(|hand| hand.finger_joints.iter().any(|joint| joint + 1 == index));
    let surface = Surface {
        friction: hand.map_or(LINK_FRICTION, |hand| hand.pad_friction),
        groups: LINK_GROUPS,
    };
    for shape in &link.shapes {
        geoms(out, &shape.shape, &shape.pose, 0.0, surface);
    }
}

/// Properties of a geom's contacts.
#[derive(Clone, Copy)]
struct Surface {
    friction: f64,
    /// Attributes of its collision groups.
    groups: &'static str,
}

impl Surface {
    fn of_object(friction: f64) -> Self {
        let groups = OBJECT_GROUPS;
        Self { friction, groups }
    }
}

fn geoms(out: &mut String, shape: &Shape, pose: &Isometry3<f64>, mass: f64, surface: Surface) {
    // A bin is its five walls in both engines: MuJoCo has no hollow shape.
    if let Some(panels) = shape.panels() {
        let volume: f64 = panels.iter().map(|panel| panel.size.product()).sum();
        for panel in panels {
            let size = panel.size;
            let own = Isometry3::from_parts(panel.centre.into(), UnitQuaternion::identity());
            let shape = Shape::Box {
                size_m: size.into(),
            };
            geoms(
                out,
                &shape,
                &(pose * own),
                mass * size.product() / volume,
                surface,
            );
        }
        return;
    }
    let (kind, size) = match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => {
            ("box", (0.5 * Vector3::from(size_m)).as_slice().to_vec())
        }
        Shape::Sphere { radius_m } => ("sphere", vec![radius_m]),
        Shape::Cylinder { radius_m, height_m } => ("cylinder", vec![radius_m, 0.5 * height_m]),
        Shape::Capsule { radius_m, height_m } => ("capsule", vec![radius_m, 0.5 * height_m]),
    };
    let size: Vec<String> = size.iter().map(f64::to_string).collect();
    let _infallible = writeln!(
        out,
        "<geom type=\"{kind}\" size=\"{}\" {} mass=\"{mass}\" friction=\"{} 0.005 0.0001\" {}/>",
        size.join(" "),
        placed(pose),
        surface.friction,
        surface.groups
    );
}

fn placed(pose: &Isometry3<f64>) -> String {
    let (p, q) = (pose.translation.vector, pose.rotation);
    format!(
        "pos=\"{} {} {}\" quat=\"{} {} {} {}\"",
        p.x, p.y, p.z, q.w, q.i, q.j, q.k
    )
}
