//! The numbers of the cell file in the form the nodes use.

use crate::pyramid::numbers::PyramidTask;
use behavior::Str;
use cell_model::Cell;
use nalgebra::{Vector2, Vector3};

/// A cell file that does not make a pyramid, or a behaviour that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PyramidError {
    /// A name that does not fit a blackboard.
    #[error(
        "'{name}' is too long for a blackboard; give the {what} a name of at most {allowed} bytes"
    )]
    Name {
        /// Of what.
        what: &'static str,
        /// The name.
        name: String,
        /// Longest name.
        allowed: usize,
    },
    /// The cell has no such object.
    #[error("task.robot.{arm}.order: the cell has no object '{name}'")]
    Object {
        /// Whose order.
        arm: String,
        /// The name.
        name: String,
    },
    /// Two arms take the same cubes and could not tell each other.
    #[error(
        "arms '{first}' and '{second}' have cubes in common and different boards; give them one 'board'"
    )]
    Boards {
        /// One of them.
        first: Str,
        /// The other one.
        second: Str,
    },
    /// A behaviour too large for the task's record.
    #[error(
        "the behaviours need {found} bytes in the task's record, at most {allowed} are allowed; use fewer nodes"
    )]
    TooLarge {
        /// What they need.
        found: usize,
        /// What there is, half of the checkpoint.
        allowed: usize,
    },
    /// An arm nothing is said about.
    #[error("[task.robot.{arm}] is missing; write what the arm shall do")]
    Arm {
        /// Its name.
        arm: String,
    },
    /// The file of a behaviour.
    #[error(transparent)]
    File(#[from] cell_model::ModelError),
    /// What is written in it: all errors of the file.
    #[error("{0}")]
    Descriptor(String),
}

/// Longest name of an arm or a cube: `reserved:NAME` has to fit a value.
const MAX_NAME: usize = 24;

/// A cube of the pyramid.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeSetup {
    /// Name in the cell file.
    pub name: Str,
    /// Index in the cell file.
    pub object: usize,
}

/// What belongs to one arm.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmSetup {
    /// Its name in the cell file, by which the blackboards call it.
    pub name: Str,
    /// Its base on the table, world frame (m).
    pub base: Vector2<f64>,
    /// Centre of its stack on the table, world frame (m).
    pub goal: Vector2<f64>,
    /// Turn of its hand about the vertical axis (rad).
    pub yaw: f64,
    /// Cubes by index, in the order in which it tries them.
    pub order: Vec<usize>,
    /// File in `cells/` with its behaviour.
    pub behaviour: String,
    /// Name of the blackboard it shares.
    pub board: String,
}

/// The job as the nodes see it.
#[derive(Clone, Debug, PartialEq)]
pub struct PyramidSetup {
    /// Numbers of the cell file.
    pub numbers: PyramidTask,
    /// The cubes; sets of cubes are of indices into this.
    pub cubes: Vec<CubeSetup>,
    /// By arm of the cell.
    pub arms: Vec<ArmSetup>,
}

impl PyramidSetup {
    /// The job of `cell`, as its `[task]` table tells.
    ///
    /// # Errors
    /// [`PyramidError`] for names that are not there or too long.
    pub fn new(task: &PyramidTask, cell: &Cell) -> Result<Self, PyramidError> {
        let named = |name: &String| task.robot.values().any(|arm| arm.order.contains(name));
        let mut cubes = Vec::new();
        for (object, spec) in cell.objects.iter().enumerate() {
            if named(&spec.name) {
                let name = short("object", &spec.name)?;
                cubes.push(CubeSetup { name, object });
            }
        }
        let mut setup = Self {
            numbers: task.clone(),
            cubes,
            arms: Vec::new(),
        };
        for arm in &cell.arms {
            let added = setup.arm(&arm.name, arm.base.translation.vector)?;
            if let Some(other) = setup.arms.iter().find(|other| {
                other.board != added.board && other.order.iter().any(|c| added.order.contains(c))
            }) {
                return Err(PyramidError::Boards {
                    first: other.name,
                    second: added.name,
                });
            }
            setup.arms.push(added);
        }
        Ok(setup)
    }

    fn arm(&self, name: &str, base: Vector3<f64>) -> Result<ArmSetup, PyramidError> {
        let missing = || PyramidError::Arm {
            arm: name.to_owned(),
        };
        let spec = self.numbers.robot.get(name).ok_or_else(missing)?;
        let mut order = Vec::new();
        for cube in &spec.order {
            let found = self.cube_named(cube).ok_or_else(|| PyramidError::Object {
                arm: name.to_owned(),
                name: cube.clone(),
            })?;
            order.push(found);
        }
        Ok(ArmSetup {
            name: short("arm", name)?,
            base: base.xy(),
            goal: Vector2::from(spec.goal_m),
            yaw: spec.yaw_rad,
            order,
            behaviour: spec.behaviour.clone(),
            board: spec.board.clone(),
        })
    }

    /// Index of a cube by name.
    pub fn cube_named(&self, name: &str) -> Option<usize> {
        self.cubes.iter().position(|c| c.name.as_str() == name)
    }

    /// Index of a cube by its place in the cell file.
    pub fn cube_of_object(&self, object: usize) -> Option<usize> {
        self.cubes.iter().position(|c| c.object == object)
    }

    /// Index of an arm by name.
    pub fn arm_named(&self, name: &str) -> Option<usize> {
        self.arms.iter().position(|a| a.name.as_str() == name)
    }

    /// Name of a cube, empty for one that is not there.
    pub fn cube_name(&self, cube: usize) -> Str {
        self.cubes.get(cube).map_or(Str::EMPTY, |c| c.name)
    }

    /// Centre of the cube in layer `layer` of the stack of `arm` (m).
    pub fn goal(&self, arm: &ArmSetup, layer: u32) -> Vector3<f64> {
        let height = self.numbers.base_height_m + self.numbers.layer_height_m * f64::from(layer);
        Vector3::new(arm.goal.x, arm.goal.y, height)
    }
}

fn short(what: &'static str, name: &str) -> Result<Str, PyramidError> {
    let fits = Str::new(name).filter(|_| name.len() <= MAX_NAME);
    fits.ok_or_else(|| PyramidError::Name {
        what,
        name: name.to_owned(),
        allowed: MAX_NAME,
    })
}
