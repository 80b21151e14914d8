//! The numbers of a stacking task, resolved once.

use cell_model::Cell;
use robocell_skills::settings::Pattern;
use robocell_skills::{PlaceTable, Setup, Tool, geometry};
use robocell_task::job::Placement;
use robocell_task::{PolicyTime, SetupError};

use super::numbers::StackTask;

/// The arm that stacks.
pub const ARM: usize = 0;
/// The place of the skills in which the stack is; its slots are the layers.
pub const STACK: usize = 0;

/// One cube of the order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cube {
    /// Its index in the cell file.
    pub object: usize,
    /// Where it belongs in the stack.
    pub goal: Placement,
    /// Where it was at the start.
    pub spawn: Placement,
}

/// Lengths of time of the phases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Shortest phase.
    pub min_phase: PolicyTime,
    /// A target has to be reached this long.
    pub settle: PolicyTime,
    /// Longest pre-grasp or retract.
    pub timeout: PolicyTime,
    /// Longest approach, lift, transport or lower.
    pub short_timeout: PolicyTime,
    /// Longest release.
    pub release_timeout: PolicyTime,
}

/// A stacking task, ready to be decided on.
#[derive(Clone, Debug)]
pub struct StackSetup {
    /// The numbers of the cell file.
    pub spec: StackTask,
    /// Cubes from bottom to top.
    pub cubes: Vec<Cube>,
    /// The cell as skills see it, with the stack as its only place.
    pub skills: Setup,
    /// The times of `spec` in ticks.
    pub timing: Timing,
}

impl StackSetup {
    /// For `cell`.
    ///
    /// # Errors
    /// When the order names an object that the cell does not have.
    pub fn new(spec: &StackTask, cell: &Cell) -> Result<Self, SetupError> {
        let mut skills = Setup::new(cell, []);
        let objects = spec.order.iter();
        let objects = objects
            .map(|name| skills.need_object(cell, name))
            .collect::<Result<Vec<_>, _>>()?;
        let lowest = objects.first().and_then(|o| skills.objects.get(*o));
        let [x, y] = spec.stack_position_m;
        let table = PlaceTable {
            position_m: [
                x,
                y,
                spec.base_height_m - lowest.map_or(0.0, |cube| cube.half_height_m),
            ],
            yaw_rad: 0.0,
            pattern: Some(Pattern::Stack {
                layers: u32::try_from(objects.len()).unwrap_or(u32::MAX),
                layer_height_m: spec.layer_height_m,
            }),
        };
        skills.add_place("stack", &table);
        if let Some(arm) = skills.arms.get_mut(ARM) {
            arm.reach_m = spec.reach_m;
            arm.tool = Tool::Fingers {
                open_width_m: spec.open_width_m,
                open_tolerance_m: spec.gripper_tolerance_m,
                force_n: spec.grip_force_n,
            };
        }
        let cube = |(layer, object): (usize, &usize)| {
            Some(Cube {
                object: *object,
                goal: skills.goal(*object, STACK, layer)?,
                spawn: spawn(&cell.objects.get(*object)?.pose),
            })
        };
        Ok(Self {
            spec: spec.clone(),
            cubes: objects.iter().enumerate().filter_map(cube).collect(),
            timing: Timing::new(spec),
            skills,
        })
    }

    /// Place in the order of the object at `object` of the cell file.
    pub fn cube_of_object(&self, object: usize) -> Option<usize> {
        self.cubes.iter().position(|c| c.object == object)
    }
}

impl Timing {
    fn new(spec: &StackTask) -> Self {
        Self {
            min_phase: PolicyTime::from_seconds(spec.min_phase_s),
            settle: PolicyTime::from_seconds(spec.settle_s),
            timeout: PolicyTime::from_seconds(spec.timeout_s),
            short_timeout: PolicyTime::from_seconds(spec.short_timeout_s),
            release_timeout: PolicyTime::from_seconds(spec.release_timeout_s),
        }
    }
}

fn spawn(pose: &nalgebra::Isometry3<f64>) -> Placement {
    let q = pose.rotation.quaternion();
    let position = pose.translation.vector.into();
    Placement {
        position,
        yaw: geometry::yaw(&ipc_types::Pose {
            position,
            orientation_wxyz: [q.w, q.i, q.j, q.k],
        }),
    }
}
