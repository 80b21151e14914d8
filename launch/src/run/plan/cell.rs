//! The cell of a run, loaded and checked for what its processes will need.

use std::path::{Path, PathBuf};

use cell_model::cells::setting::Setting;
use cell_model::{Cell, Data, RobotFiles};
use supervisor::failure::Failure;

use super::paths::absolute;
use crate::args::{RobotArgs, RunArgs};
use crate::say;

/// The cell as the run has it.
pub(super) fn cell_of(
    args: &RunArgs,
    data_dir: Option<&Path>,
    robot: Option<&RobotFiles>,
) -> Result<Cell, Failure> {
    let mut cell = load(data_dir, &args.demo, args.scene.seed, robot, &args.set)?;
    args.job
        .bins
        .map_or(Ok(()), |bins| cell.limit_bins(bins))
        .map_err(Failure::configuration)?;
    Ok(cell)
}

/// In one process the arms are moved by the controllers of the task program.
pub(super) fn check_one_process(
    cell: &Cell,
    task: Option<&Path>,
    controllers: &[Option<PathBuf>],
) -> Result<(), Failure> {
    let others = cell.arms.iter().zip(controllers);
    for (arm, program) in others.filter(|(_, program)| program.is_some()) {
        if program.as_deref() != task {
            return Err(Failure::configuration(format!(
                "arm '{}' is moved by its own program; --one-process needs a task program that \
                 has the same controllers",
                arm.name
            )));
        }
    }
    Ok(())
}

/// What the controllers will need, found out before anything starts.
pub(super) fn check_control(cell: &Cell) -> Result<(), Failure> {
    for arm in &cell.arms {
        let joints = arm.robot.arm_joints.len();
        let named = |error: String| {
            let robot = &arm.robot.name;
            Failure::configuration(format!("robot '{robot}' cannot be controlled: {error}"))
        };
        let limits = arm.robot.limits().validate(joints);
        limits.map_err(|error| named(error.to_string()))?;
        let policies = arm.robot.motion_policies(cell.obstacles().count());
        policies.map_err(|error| named(error.to_string()))?;
    }
    Ok(())
}

/// The cell of `demo`, from a directory or the built-in data, with `set` in place of numbers of
/// its file.
pub(crate) fn load(
    data_dir: Option<&Path>,
    demo: &str,
    seed: u64,
    robot: Option<&RobotFiles>,
    set: &[Setting],
) -> Result<Cell, Failure> {
    let data = data_of(data_dir);
    Cell::load_with(&data, demo, seed, robot, set).map_err(|error| {
        let hint = match (data_dir, robot) {
            (None, None) => data_hint(Path::new("."), demo),
            _ => "",
        };
        Failure::configuration(format!("{error}{hint}"))
    })
}

/// The cells and robots of a folder, with the built-in robots, or those that are built in.
fn data_of(data_dir: Option<&Path>) -> Data {
    let built_in = cell_files::data();
    let data = data_dir.map(|dir| Data::dir(dir).with_robots_of(&built_in));
    data.unwrap_or(built_in)
}

/// A hint for a user in the folder of their own cell.
fn data_hint(here: &Path, demo: &str) -> &'static str {
    if here.join("cells").join(format!("{demo}.toml")).is_file() {
        "; there is a cell file of that name below this folder: add `--data .`"
    } else {
        ""
    }
}

/// Paths are made absolute: the processes work in another directory.
pub(crate) fn robot_files(
    args: &RobotArgs,
    data_dir: Option<&Path>,
) -> Result<Option<RobotFiles>, Failure> {
    let Some(asked) = &args.robot else {
        return Ok(None);
    };
    let known = data_of(data_dir).robot_names();
    if let Some(named) = RobotFiles::named(asked, &known) {
        return Ok(Some(named));
    }
    if asked
        .to_str()
        .is_some_and(|name| known.iter().any(|known| known == name))
    {
        say::warn(format_args!(
            "--robot {} is a file here, and not the robot of that name",
            asked.display()
        ));
    }
    if !asked.exists() && asked.components().count() == 1 && asked.extension().is_none() {
        let (name, known): (_, Vec<&str>) = (
            asked.display().to_string(),
            known.iter().map(String::as_str).collect(),
        );
        return Err(Failure::configuration(format!(
            "--robot {name}: no file and no robot of that name; {}",
            cell_model::suggest::advice(&name, &known)
        )));
    }
    let files = RobotFiles {
        name: None,
        urdf: absolute(asked)?,
        xrdf: args.xrdf.as_deref().map(absolute).transpose()?,
        rmpflow: args.rmpflow.as_deref().map(absolute).transpose()?,
        tip: args.tip.clone(),
    };
    files.resolved().map(Some).map_err(Failure::configuration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_of_ones_own_needs_the_folder() {
        let checkout = Data::checkout_dir();
        assert!(data_hint(&checkout, "reach").contains("--data ."));
        assert_eq!(data_hint(&checkout, "nowhere"), "");
        assert_eq!(data_hint(&checkout.join("docs"), "reach"), "");
    }
}
