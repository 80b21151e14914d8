//! The numbers of a stacking task, resolved once.

use crate::stack::numbers::StackTask;
use nalgebra::{Vector2, Vector3};

use robocell_task::job::Placement;
use robocell_task::time::PolicyTime;

/// Cubes one task can stack.
pub const MAX_CUBES: usize = crate::check::MAX_STACK;

/// One cube of the order.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeSpec {
    /// Its name in the cell file.
    pub name: String,
    /// Its index in the cell file.
    pub object: usize,
    /// Where it belongs in the stack.
    pub goal: Placement,
    /// Where it stood at the start.
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
    pub cubes: Vec<CubeSpec>,
    /// Base of the arm in the plane, world frame (m).
    pub base: Vector2<f64>,
    /// The same numbers in ticks.
    pub timing: Timing,
}

/// Why a stacking task cannot be set up.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum SetupError {
    /// A name in the order is no object.
    #[error("[task] order: there is no object '{name}' in the cell file; {advice}")]
    UnknownObject {
        /// The name.
        name: String,
        /// What to do.
        advice: String,
    },
    /// Too many, or none.
    #[error("[task] order has {found} objects, allowed are 1 to {MAX_CUBES}; shorten the list")]
    Count {
        /// Objects in the order.
        found: usize,
    },
    /// The tree of the policy cannot be built.
    #[error("the behaviour tree cannot be built: {problem}; this is a mistake in the program")]
    Tree {
        /// What the engine said.
        problem: String,
    },
    /// A name stands twice.
    #[error("[task] order names '{name}' twice; an object has one place in a stack")]
    Twice {
        /// The name.
        name: String,
    },
}

impl StackSetup {
    /// `objects` are the names and spawn places of the cell's objects by index,
    /// `base` is the arm's base in the world frame (m).
    ///
    /// # Errors
    /// When the order names an unknown object, one twice, none or too many.
    pub fn new(
        spec: &StackTask,
        objects: &[(&str, Placement)],
        base: Vector2<f64>,
    ) -> Result<Self, SetupError> {
        let found = spec.order.len();
        if found == 0 || found > MAX_CUBES {
            return Err(SetupError::Count { found });
        }
        let mut cubes: Vec<CubeSpec> = Vec::with_capacity(found);
        for (level, name) in spec.order.iter().enumerate() {
            if cubes.iter().any(|c| c.name == *name) {
                return Err(SetupError::Twice { name: name.clone() });
            }
            cubes.push(cube(spec, objects, level, name)?);
        }
        Ok(Self {
            spec: spec.clone(),
            cubes,
            base,
            timing: Timing::new(spec),
        })
    }

    /// The cube at `index` of the order.
    pub fn cube(&self, index: usize) -> Option<&CubeSpec> {
        self.cubes.get(index)
    }

    /// Name of the cube at `index` of the order.
    pub fn name(&self, index: usize) -> &str {
        self.cube(index).map_or("?", |c| c.name.as_str())
    }

    /// Placement in the order of the object at `object` of the cell file.
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

fn cube(
    spec: &StackTask,
    objects: &[(&str, Placement)],
    level: usize,
    name: &str,
) -> Result<CubeSpec, SetupError> {
    let Some(object) = objects.iter().position(|(n, _)| *n == name) else {
        let known: Vec<&str> = objects.iter().map(|(n, _)| *n).collect();
        let advice = cell_model::suggest::advice(name, &known);
        return Err(SetupError::UnknownObject {
            name: name.to_owned(),
            advice,
        });
    };
    let [x, y] = spec.stack_position_m;
    let z = spec.base_height_m + level as f64 * spec.layer_height_m;
    let spawn = objects.get(object).map_or(
        Placement {
            position: [x, y, z],
            yaw: 0.0,
        },
        |(_, p)| *p,
    );
    Ok(CubeSpec {
        name: name.to_owned(),
        object,
        goal: Placement {
            position: Vector3::new(x, y, z).into(),
            yaw: 0.0,
        },
        spawn,
    })
}
