//! The URDF that a client asks for: joints, limits and masses of the arm.
//!
//! Written from the robot as it is loaded, not its file: clients have no use for shapes, and
//! some of their readers refuse capsules.

use std::fmt::Write as _;

use cell_model::{Link, Robot};
use nalgebra::{Isometry3, Matrix3};

use crate::hand::{self, FLANGE_M};

/// The text. Moving joints keep their names, and have the limits of `robot`.
pub fn urdf(robot: &Robot) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?>\n<robot name=\"robot\">\n");
    let joints = robot.chain.joints();
    let last = hand::last_link(robot);
    let of = |index: usize| {
        let is_last = robot
            .arm_joints
            .last()
            .is_some_and(|last| last + 1 == index);
        let without_hand = last.as_ref().filter(|_| is_last);
        without_hand.or_else(|| robot.links.get(index))
    };
    link(&mut out, of(0), 0);
    for (place, &index) in robot.arm_joints.iter().enumerate() {
        let (Some(joint), Some(spec)) = (joints.get(index), robot.joints.get(index)) else {
            continue;
        };
        let parent = joint.parent.map_or(0, |parent| parent + 1);
        link(&mut out, of(index + 1), index + 1);
        let mut to = |text: std::fmt::Arguments<'_>| out.write_fmt(text).is_ok();
        to(format_args!(
            "  <joint name=\"{}\" type=\"revolute\">\n    {}\n    <parent link=\"link{parent}\"/>\n    \
             <child link=\"link{}\"/>\n    <axis xyz=\"{} {} {}\"/>\n",
            joint.name,
            origin(&joint.origin),
            index + 1,
            joint.axis.x,
            joint.axis.y,
            joint.axis.z,
        ));
        to(format_args!(
            "    <limit lower=\"{}\" upper=\"{}\" velocity=\"{}\" effort=\"{}\"/>\n",
            spec.lower, spec.upper, spec.velocity, spec.effort,
        ));
        // libfranka throws at a joint without this element. The numbers for a robot that has none
        // limit the velocity only very near a position limit.
        let near = robot.velocity_envelope.get(place);
        let (offset, deceleration) = near.map_or((0.0, 1.0e3), |n| (n.offset, n.deceleration));
        to(format_args!(
            "    <position_based_velocity_limits velocity_offset=\"{offset}\" \
             deceleration_limit=\"{deceleration}\"/>\n  </joint>\n",
        ));
    }
    flange(&mut out, robot);
    out.push_str("</robot>\n");
    out
}

/// The frame by whose name libfranka finds the last joint; it reads past an array without it.
fn flange(out: &mut String, robot: &Robot) {
    let last = robot.arm_joints.last().map_or(0, |last| last + 1);
    let _written = write!(
        out,
        "  <link name=\"link8\"/>\n  <joint name=\"joint8\" type=\"fixed\">\n    \
         <origin xyz=\"0 0 {FLANGE_M}\"/>\n    <parent link=\"link{last}\"/>\n    \
         <child link=\"link8\"/>\n  </joint>\n",
    )
    .is_ok();
}

fn link(out: &mut String, link: Option<&Link>, index: usize) {
    let Some(link) = link else {
        return;
    };
    let _written = write!(
        out,
        "  <link name=\"link{index}\">\n    <inertial>\n      <origin xyz=\"{} {} {}\"/>\n      \
         <mass value=\"{}\"/>\n      {}\n    </inertial>\n  </link>\n",
        link.center_of_mass.x,
        link.center_of_mass.y,
        link.center_of_mass.z,
        link.mass,
        inertia(&link.inertia),
    )
    .is_ok();
}

fn inertia(matrix: &Matrix3<f64>) -> String {
    let at = |row, column| matrix[(row, column)];
    format!(
        "<inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>",
        at(0, 0),
        at(0, 1),
        at(0, 2),
        at(1, 1),
        at(1, 2),
        at(2, 2)
    )
}

fn origin(pose: &Isometry3<f64>) -> String {
    let (at, (roll, pitch, yaw)) = (pose.translation.vector, pose.rotation.euler_angles());
    format!(
        "<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>",
        at.x, at.y, at.z
    )
}
