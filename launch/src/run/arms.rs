//! The arms of a cell in a few lines.

use cell_model::{ArmSpec, Cell, Robot, RobotFiles};

/// Joints, tool frame, spheres and tuning of each arm; `files` are those of a robot given
/// on the command line.
pub(super) fn lines(cell: &Cell, files: Option<&RobotFiles>) -> Vec<String> {
    cell.arms.iter().flat_map(|arm| of(arm, files)).collect()
}

fn of(arm: &ArmSpec, files: Option<&RobotFiles>) -> Vec<String> {
    let robot = &arm.robot;
    let joints = robot.arm_joint_names();
    let tool = if robot.gripper.is_some() {
        "gripper with two fingers"
    } else if robot.suction.is_some() {
        "suction gripper"
    } else {
        "no gripper"
    };
    let tuning = match files {
        None | Some(RobotFiles { name: Some(_), .. }) => {
            "rmpflow, of the robot's folder".to_owned()
        }
        Some(RobotFiles {
            rmpflow: Some(file),
            ..
        }) => format!("rmpflow, {}", file.display()),
        Some(_) => "rmpflow, general (`--rmpflow FILE` gives another)".to_owned(),
    };
    let spheres = match robot.spheres.len() {
        0 => "none: only the tool keeps away from obstacles (`--xrdf FILE` gives them)".to_owned(),
        count => count.to_string(),
    };
    let mut lines = vec![
        format!("  arm {}: {}, {tool}", arm.name, robot.name),
        format!(
            "    joints             {} ({})",
            joints.join(" "),
            joints.len()
        ),
    ];
    lines.extend(followers(robot));
    lines.extend([
        format!("    tool frame         {}", robot.tcp_frame_name()),
        format!("    collision spheres  {spheres}"),
        format!("    tuning             {tuning}"),
    ]);
    lines
}

/// The joints that follow a controlled one, with their law.
fn followers(robot: &Robot) -> Option<String> {
    let joints = robot.chain.joints();
    let laws: Vec<String> = robot
        .followers()
        .map(|(joint, _, mimic)| {
            let (name, of) = (&joints[joint].name, &joints[mimic.joint].name);
            format!("{name} = {} {of} + {}", mimic.multiplier, mimic.offset)
        })
        .collect();
    (!laws.is_empty()).then(|| format!("    joints that follow {}", laws.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_model::Data;

    #[test]
    fn the_arm_of_reach_is_described() {
        let cell = Cell::load(&Data::checkout(), "reach", 0, None).unwrap();
        let text = lines(&cell, None).join("\n");
        for words in ["panda_joint1", "(7)", "tool frame  ", "collision spheres  "] {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert!(!text.contains("none"), "{text}");
    }
}
