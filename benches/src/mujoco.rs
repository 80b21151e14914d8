//! The same scene in `MuJoCo`, in a Python beside this process, where that has
//! the package.

use std::fmt::Write as _;

use cell_model::{ArmSpec, Cell, Link, Shape};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rmp::JointKind;

use crate::python::PythonStepper;

const PROGRAM: &str = include_str!("mujoco.py");

/// Sets a cell up; `None` where there is no Python with `MuJoCo`.
pub(crate) fn start(cell: &Cell) -> Option<PythonStepper> {
    PythonStepper::start(PROGRAM, &mjcf(cell))
}

/// The scene in `MuJoCo`'s own format, with its own settings but for the length
/// of the step.
fn mjcf(cell: &Cell) -> String {
    let mut out = String::from("<mujoco><option timestep=\"0.001\"/><worldbody>\n");
    for fixture in &cell.fixtures {
        geoms(
            &mut out,
            &fixture.shape,
            &fixture.pose,
            1.0,
            fixture.friction,
        );
    }
    for object in &cell.objects {
        let _infallible = writeln!(out, "<body {}><freejoint/>", placed(&object.pose));
        let (mass, friction) = (object.mass, object.friction);
        geoms(
            &mut out,
            &object.shape,
            &Isometry3::identity(),
            mass,
            friction,
        );
        out.push_str("</body>\n");
    }
    let mut drives = String::new();
    for (index, arm) in cell.arms.iter().enumerate() {
        add_arm(&mut out, &mut drives, index, arm);
    }
    let _infallible = writeln!(out, "</worldbody><actuator>{drives}</actuator></mujoco>");
    out
}

/// The links of an arm as bodies without gravity, its joints driven to where they are:
/// what the controller of a cell does with the arm at rest.
fn add_arm(out: &mut String, drives: &mut String, index: usize, arm: &ArmSpec) {
    let home = arm.robot.with_arm_positions(&arm.home);
    let _infallible = writeln!(out, "<body {}>", placed(&arm.base));
    add_link(out, arm.robot.links.first());
    add_children(out, drives, (index, arm), &home, None);
    out.push_str("</body>\n");
}

fn add_children(
    out: &mut String,
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
        let name = format!("arm{index}_joint{number}");
        let _infallible = writeln!(
            out,
            "<body gravcomp=\"1\" {}><joint name=\"{name}\" type=\"{kind}\" axis=\"{x} {y} {z}\" \
             damping=\"{}\" armature=\"{}\"/>",
            placed(&(joint.origin * cell_model::robots::robot::joint_motion(joint, home[number]))),
            spec.joint_damping,
            spec.armature
        );
        let _infallible = writeln!(
            drives,
            "<position joint=\"{name}\" kp=\"{}\" kv=\"{}\"/>",
            spec.stiffness, spec.damping
        );
        add_link(out, arm.robot.links.get(number + 1));
        add_children(out, drives, (index, arm), home, Some(number));
        out.push_str("</body>\n");
    }
}

fn add_link(out: &mut String, link: Option<&Link>) {
    let Some(link) = link else { return };
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
    for shape in &link.shapes {
        geoms(out, &shape.shape, &shape.pose, 0.0, 0.8);
    }
}

fn geoms(out: &mut String, shape: &Shape, pose: &Isometry3<f64>, mass: f64, friction: f64) {
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
                friction,
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
        "<geom type=\"{kind}\" size=\"{}\" {} mass=\"{mass}\" friction=\"{friction} 0.005 0.0001\"/>",
        size.join(" "),
        placed(pose)
    );
}

fn placed(pose: &Isometry3<f64>) -> String {
    let (p, q) = (pose.translation.vector, pose.rotation);
    format!(
        "pos=\"{} {} {}\" quat=\"{} {} {} {}\"",
        p.x, p.y, p.z, q.w, q.i, q.j, q.k
    )
}
