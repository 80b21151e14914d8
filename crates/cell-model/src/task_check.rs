//! Ranges of the numbers in the `[task]` table of a cell file.

use crate::cell_check::{Checker, MAX_COORDINATE_M};
use crate::cell_file::CellFile;
use crate::error::ModelError;
use crate::suggest;
use crate::task_spec::{MAX_STACK, PyramidArm, PyramidTask, ReachTask, StackTask, TaskSpec};

fn object_names(cell: &CellFile) -> Vec<&str> {
    let objects = cell.objects.iter();
    objects.map(|object| object.name.as_str()).collect()
}

impl Checker<'_> {
    /// Refuses a task whose names or numbers cannot be meant.
    pub(crate) fn task(&self, cell: &CellFile) -> Result<(), ModelError> {
        match &cell.task {
            TaskSpec::Stack(task) => self.stack(task, cell),
            TaskSpec::Pyramid(task) => self.pyramid(task, cell),
            TaskSpec::Reach(task) => self.reach(task),
            TaskSpec::Palletize(task) => self.palletize(task, cell),
            TaskSpec::FillBin(task) => self.fill_bin(task, cell),
            TaskSpec::BinStack(task) => self.bin_stack(task, cell),
        }
    }

    /// Objects that exist, each of them once.
    fn order(&self, key: &str, order: &[String], names: &[&str]) -> Result<(), ModelError> {
        for (index, name) in order.iter().enumerate() {
            let refuse = |allowed: String| {
                self.refuse(&format!("{key}.{index}"), format!("'{name}'"), allowed)
            };
            if !names.contains(&name.as_str()) {
                let advice = suggest::advice(name, names);
                return Err(refuse(format!("no such object; {advice}")));
            }
            if order.iter().take(index).any(|other| other == name) {
                return Err(refuse("an object stands in a stack once".to_owned()));
            }
        }
        if order.is_empty() || order.len() > MAX_STACK {
            let allowed = format!("1 to {MAX_STACK} are allowed");
            return Err(self.refuse(key, format!("{} names", order.len()), allowed));
        }
        Ok(())
    }

    fn stack(&self, task: &StackTask, cell: &CellFile) -> Result<(), ModelError> {
        let names = object_names(cell);
        self.order("task.order", &task.order, &names)?;
        self.numbers(
            "task.stack_position_m",
            &task.stack_position_m,
            -MAX_COORDINATE_M,
            MAX_COORDINATE_M,
        )?;
        self.numbers("task.grasp_offset_m", &task.grasp_offset_m, -0.5, 0.5)?;
        self.number(
            "task.base_height_m",
            task.base_height_m,
            -MAX_COORDINATE_M,
            MAX_COORDINATE_M,
        )?;
        self.stack_numbers(task)
    }

    fn stack_numbers(&self, task: &StackTask) -> Result<(), ModelError> {
        let ranges = [
            ("layer_height_m", task.layer_height_m, 1.0e-3, 1.0),
            ("clearance_m", task.clearance_m, 0.0, 1.0),
            ("goal_tolerance_m", task.goal_tolerance_m, 1.0e-4, 1.0),
            ("travel_tolerance_m", task.travel_tolerance_m, 1.0e-4, 1.0),
            ("precise_tolerance_m", task.precise_tolerance_m, 1.0e-4, 1.0),
            (
                "orientation_tolerance_rad",
                task.orientation_tolerance_rad,
                1.0e-4,
                3.2,
            ),
            ("gripper_tolerance_m", task.gripper_tolerance_m, 1.0e-5, 0.5),
            ("move_tolerance_m", task.move_tolerance_m, 1.0e-4, 1.0),
            ("drop_distance_m", task.drop_distance_m, 1.0e-3, 1.0),
            ("open_width_m", task.open_width_m, 1.0e-3, 1.0),
            (
                "closed_width_m",
                task.closed_width_m,
                0.0,
                task.open_width_m,
            ),
            ("grip_force_n", task.grip_force_n, 0.1, 1.0e4),
            ("min_phase_s", task.min_phase_s, 0.0, 60.0),
            ("settle_s", task.settle_s, 0.0, 60.0),
            ("timeout_s", task.timeout_s, 0.1, 600.0),
            ("short_timeout_s", task.short_timeout_s, 0.1, 600.0),
            ("release_timeout_s", task.release_timeout_s, 0.1, 600.0),
            ("max_attempts", f64::from(task.max_attempts), 1.0, 1000.0),
            ("reach_m", task.reach_m, 1.0e-2, MAX_COORDINATE_M),
        ];
        ranges.iter().try_for_each(|(key, value, low, high)| {
            self.number(&format!("task.{key}"), *value, *low, *high)
        })
    }

    fn reach(&self, task: &ReachTask) -> Result<(), ModelError> {
        if let Some(position) = &task.position_m {
            self.position("task.position_m", position)?;
        }
        let Some(orientation) = &task.orientation_wxyz else {
            return Ok(());
        };
        let norm = orientation.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (norm - 1.0).abs() <= 1.0e-6 {
            return Ok(());
        }
        Err(self.refuse(
            "task.orientation_wxyz",
            format!("of length {norm}"),
            "a unit quaternion w x y z is needed",
        ))
    }

    fn pyramid(&self, task: &PyramidTask, cell: &CellFile) -> Result<(), ModelError> {
        self.pyramid_numbers(task)?;
        let arms: Vec<&str> = cell.arms.iter().map(|arm| arm.name.as_str()).collect();
        for (name, arm) in &task.robot {
            if !arms.contains(&name.as_str()) {
                let advice = suggest::advice(name, &arms);
                let key = format!("task.robot.{name}");
                return Err(self.refuse(&key, "here", format!("no such arm; {advice}")));
            }
            self.pyramid_arm(&format!("task.robot.{name}"), arm, cell)?;
        }
        if let Some(missing) = arms.iter().find(|name| !task.robot.contains_key(**name)) {
            let allowed = format!("write what [task.robot.{missing}] shall do");
            return Err(self.refuse("task", format!("silent about arm '{missing}'"), allowed));
        }
        let wanted = u64::from(task.required_count) * arms.len() as u64;
        if wanted > cell.objects.len() as u64 {
            let allowed = format!(
                "{} arms need {wanted} objects, the cell has {}",
                arms.len(),
                cell.objects.len()
            );
            return Err(self.refuse("task.required_count", task.required_count, allowed));
        }
        Ok(())
    }

    fn pyramid_arm(&self, key: &str, arm: &PyramidArm, cell: &CellFile) -> Result<(), ModelError> {
        let far = MAX_COORDINATE_M;
        self.numbers(&format!("{key}.goal_m"), &arm.goal_m, -far, far)?;
        self.number(&format!("{key}.yaw_rad"), arm.yaw_rad, -7.0, 7.0)?;
        self.order(&format!("{key}.order"), &arm.order, &object_names(cell))?;
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
        let file = &arm.behaviour;
        let json = std::path::Path::new(file)
            .extension()
            .is_some_and(|e| e == "json");
        if !json || file.len() > 64 || !file.chars().all(plain) {
            return Err(self.refuse(
                &format!("{key}.behaviour"),
                format!("'{file}'"),
                "the name of a .json file in cells/ is needed",
            ));
        }
        let word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if arm.board.is_empty() || arm.board.len() > 32 || !arm.board.chars().all(word) {
            return Err(self.refuse(
                &format!("{key}.board"),
                format!("'{}'", arm.board),
                "1 to 32 of a-z, 0-9 and _ are allowed",
            ));
        }
        Ok(())
    }

    fn pyramid_numbers(&self, task: &PyramidTask) -> Result<(), ModelError> {
        let far = MAX_COORDINATE_M;
        let count = f64::from(task.required_count);
        let ranges = [
            ("base_height_m", task.base_height_m, -far, far),
            ("layer_height_m", task.layer_height_m, 1.0e-3, 1.0),
            ("required_count", count, 1.0, MAX_STACK as f64),
            ("approach_m", task.approach_m, 0.0, 1.0),
            ("grasp_m", task.grasp_m, -0.5, 0.5),
            ("lift_z_m", task.lift_z_m, -far, far),
            ("place_approach_m", task.place_approach_m, 0.0, 1.0),
            ("place_m", task.place_m, -0.5, 0.5),
            ("retract_m", task.retract_m, 0.0, 1.0),
            ("goal_tolerance_m", task.goal_tolerance_m, 1.0e-4, 1.0),
            ("open_width_m", task.open_width_m, 1.0e-3, 1.0),
            (
                "closed_width_m",
                task.closed_width_m,
                0.0,
                task.open_width_m,
            ),
            ("gripper_tolerance_m", task.gripper_tolerance_m, 1.0e-5, 0.5),
            ("grip_force_n", task.grip_force_n, 0.1, 1.0e4),
            ("reach_m", task.reach_m, 1.0e-2, far),
        ];
        ranges.iter().try_for_each(|(key, value, low, high)| {
            self.number(&format!("task.{key}"), *value, *low, *high)
        })
    }
}
