//! The settings of a stacking task, resolved once.

use cell_model::Cell;
use ipc_types::Pose;
use robocell_skills::settings::Pattern;
use robocell_skills::{PlaceTable, Setup, Tool, geometry};
use robocell_task::SetupError;
use robocell_task::job::Placement;

use super::numbers::StackTask;

/// The arm that stacks.
pub const ARM: usize = 0;
/// Index of the skills' place for the stack; its slots are the layers.
pub const STACK: usize = 0;

/// A stacking task in the form that decisions use.
#[derive(Clone, Debug)]
pub struct StackSetup {
    /// The numbers of the cell file.
    pub spec: StackTask,
    /// The cubes from bottom to top, by their index in the cell file.
    pub cubes: Vec<usize>,
    /// By cube: its pose at the start.
    pub spawns: Vec<Placement>,
    /// The cell as skills see it, with the stack as its only place.
    pub skills: Setup,
}

impl StackSetup {
    /// The setup for `cell`.
    ///
    /// # Errors
    /// Returns an error if the order names an object that the cell does not have.
    pub fn new(spec: &StackTask, cell: &Cell) -> Result<Self, SetupError> {
        let mut skills = Setup::new(cell, []);
        let cubes = spec.order.iter();
        let cubes = cubes.map(|name| skills.need_object(cell, name));
        let cubes: Vec<usize> = cubes.collect::<Result<_, _>>()?;
        let lowest = cubes.first().and_then(|o| skills.objects.get(*o));
        // Slots of a place are given from the surface; the task gives the centre of the lowest
        // cube.
        let surface_m = spec.base_height_m - lowest.map_or(0.0, |cube| cube.half_height_m);
        let [x, y] = spec.stack_position_m;
        let table = PlaceTable {
            position_m: [x, y, surface_m],
            yaw_rad: 0.0,
            pattern: Some(Pattern::Stack {
                layers: u32::try_from(cubes.len()).unwrap_or(u32::MAX),
                layer_height_m: spec.layer_height_m,
            }),
        };
        skills.add_place("stack", &table);
        if let Some(arm) = skills.arms.get_mut(ARM) {
            // Reach and gripper are those of the task, so that one cell file holds all numbers
            // of the job.
            arm.reach_m = spec.reach_m;
            arm.tool = Tool::Fingers {
                open_width_m: spec.open_width_m,
                open_tolerance_m: spec.gripper_tolerance_m,
                force_n: spec.grip_force_n,
            };
        }
        let spawns = cubes.iter().filter_map(|cube| cell.objects.get(*cube));
        Ok(Self {
            spec: spec.clone(),
            spawns: spawns.map(|cube| placement(&cube.pose)).collect(),
            cubes,
            skills,
        })
    }
}

fn placement(pose: &nalgebra::Isometry3<f64>) -> Placement {
    let q = pose.rotation.quaternion();
    let position = pose.translation.vector.into();
    let orientation_wxyz = [q.w, q.i, q.j, q.k];
    Placement {
        position,
        yaw: geometry::yaw(&Pose {
            position,
            orientation_wxyz,
        }),
    }
}
