//! The settings of the cell file in the form that the nodes use.

use std::sync::Arc;

use cell_model::Cell;
use ipc_types::Pose;
use nalgebra::Vector2;
use robocell_skills::setup::{PlaceSetup, Setup, Tool};
use robocell_task::SetupError;
use robocell_task::job::Placement;

use super::numbers::{PyramidArm, PyramidTask};

/// Share of the way from its base to its stack at which an arm rests.
const WAIT_SHARE: f64 = 0.75;
/// Distance to the side of that, away from the other arms (m).
const WAIT_ASIDE_M: f64 = 0.12;
/// Height above that to which cubes are lifted (m): an arm at rest is above a carried cube.
const WAIT_ABOVE_M: f64 = 0.1;

/// The job as the nodes see it. A cube is the index of an object of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    /// Numbers of the cell file.
    pub task: PyramidTask,
    /// The cell. The place with the index of an arm is the arm's stack.
    pub setup: Arc<Setup>,
    /// The objects that any arm may take; a set of cubes holds indices in this list.
    pub cubes: Vec<usize>,
    /// By arm: cubes in the order in which it tries them.
    pub orders: Vec<Vec<usize>>,
}

impl Pyramid {
    /// The job of `cell`, from its `[task]` table.
    ///
    /// # Errors
    /// Returns a [`SetupError`] for an object that does not exist, for an arm without an entry,
    /// and for arms that take the same cubes without a common blackboard.
    pub fn new(task: &PyramidTask, cell: &Cell) -> Result<Self, SetupError> {
        let mut setup = Setup::new(cell, []);
        let mut parts: Vec<(&str, &PyramidArm)> = Vec::new();
        let mut orders: Vec<Vec<usize>> = Vec::new();
        for arm in &cell.arms {
            let name = &arm.name;
            let missing = || format!("[task.robot.{name}] is missing; write what the arm shall do");
            let part = task.robot.get(name);
            let part = part.ok_or_else(|| SetupError::new(cell, missing()))?;
            let order = part.order.iter().map(|cube| setup.need_object(cell, cube));
            let order = order.collect::<Result<Vec<_>, _>>()?;
            let mut others = parts.iter().zip(&orders);
            // Without a common blackboard two arms cannot reserve a cube from each other and
            // would both grip it.
            let clash = others.find(|((_, other), cubes)| {
                other.board != part.board && order.iter().any(|cube| cubes.contains(cube))
            });
            if let Some(((first, _), _)) = clash {
                let problem = format!(
                    "arms '{first}' and '{name}' have cubes in common and different boards; give \
                     them one 'board'"
                );
                return Err(SetupError::new(cell, problem));
            }
            parts.push((name, part));
            orders.push(order);
        }
        let is_cube = |object: &usize| orders.iter().any(|order| order.contains(object));
        let cubes: Vec<usize> = (0..setup.objects.len()).filter(is_cube).collect();
        let parts: Vec<&PyramidArm> = parts.into_iter().map(|(_, part)| part).collect();
        setup.places = parts
            .iter()
            .map(|part| stack(task, part, cubes.len()))
            .collect();
        for (index, arm) in setup.arms.iter_mut().enumerate() {
            // Reach and tool of the task replace the defaults of the setup.
            arm.reach_m = task.reach_m;
            arm.tool = Tool::Fingers {
                open_width_m: task.open_width_m,
                open_tolerance_m: task.gripper_tolerance_m,
                force_n: task.grip_force_n,
            };
            let base = arm.base.xy();
            arm.wait = parts.get(index).map_or(arm.wait, |part| {
                let [x, y] = wait(base, part, &parts).into();
                Pose {
                    position: [x, y, task.lift_z_m + WAIT_ABOVE_M],
                    orientation_wxyz: arm.tool.down(part.yaw_rad),
                }
            });
        }
        Ok(Self {
            task: task.clone(),
            setup: Arc::new(setup),
            cubes,
            orders,
        })
    }

    /// The cubes, each with its index in sets of cubes.
    pub(super) fn items(&self) -> impl Iterator<Item = (u32, usize)> {
        (0..).zip(self.cubes.iter().copied())
    }

    /// A cube's index in sets of cubes.
    pub(super) fn item(&self, cube: usize) -> u32 {
        let found = self.items().find(|(_, known)| *known == cube);
        found.map_or(u32::MAX, |(item, _)| item)
    }
}

/// The place of an arm's stack.
fn stack(task: &PyramidTask, part: &PyramidArm, cubes: usize) -> PlaceSetup {
    let [x, y] = part.goal_m;
    let bottom = task.base_height_m - 0.5 * task.layer_height_m;
    let slot = |layer: usize| Placement {
        position: [x, y, bottom + task.layer_height_m * layer as f64],
        yaw: part.yaw_rad,
    };
    PlaceSetup {
        name: format!("stack at {x} {y}"),
        slots: (0..cubes).map(slot).collect(),
    }
}

/// The rest position of an arm, out of the way of the others: back from its stack, on the side
/// away from theirs (m).
fn wait(base: Vector2<f64>, part: &PyramidArm, all: &[&PyramidArm]) -> Vector2<f64> {
    let goal = Vector2::from(part.goal_m);
    let away: Vector2<f64> = all
        .iter()
        .map(|other| goal - Vector2::from(other.goal_m))
        .sum();
    // Arms with the same goal have no side away from each other; they rest between base and
    // stack.
    let away = away.try_normalize(1.0e-6).unwrap_or_default();
    base + (goal - base) * WAIT_SHARE + away * WAIT_ASIDE_M
}
