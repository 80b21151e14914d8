//! A cell as skills need it, resolved once from its files.

pub(crate) mod arm;
pub(crate) mod grasping;
pub(crate) mod object;

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use cell_model::{Cell, suggest};
use nalgebra::{Isometry3, Vector3};
use robocell_task::job::Placement;
use robocell_task::{Observation, SetupError};

use crate::ability::{self, Need};
use crate::settings::place::PlaceTable;
use grasping::Grasping;

pub use arm::{ARM, ArmSetup, Tool, suction_arm};
pub use object::ObjectSetup;

/// A named place: one slot, or a pattern of them in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceSetup {
    /// Its name in the cell file.
    pub name: String,
    /// By slot: the point of the surface below the object's centre (m), and the
    /// object's turn (rad). World frame.
    pub slots: Vec<Placement>,
}

/// A cell as skills see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// By arm of the cell.
    pub arms: Vec<ArmSetup>,
    /// By object of the cell.
    pub objects: Vec<ObjectSetup>,
    /// The places of `[task]`.
    pub places: Vec<PlaceSetup>,
    /// Names of the cell's sensors, in their order.
    pub sensors: Vec<String>,
    /// Names of the cell's obstacles; the index is the bit in a mask.
    pub obstacles: Vec<String>,
    /// Obstacles that exist in physics; the others only guide a motion.
    pub solid_obstacles: u64,
    /// Picks that files name.
    pub(crate) picks: Picks,
    /// The planner of grasps.
    pub(crate) grasping: Grasping,
}

/// Arm and object of each pick that a file names, collected while its nodes are created: later
/// only the nodes have them. Not compared.
#[derive(Clone, Debug, Default)]
pub(crate) struct Picks(Arc<Mutex<BTreeSet<(usize, usize)>>>);

impl PartialEq for Picks {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Picks {
    /// Records that `arm` picks `object`.
    pub(crate) fn note(&self, arm: usize, object: usize) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert((arm, object));
    }

    /// All recorded picks.
    pub(crate) fn all(&self) -> BTreeSet<(usize, usize)> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.clone()
    }
}

impl Setup {
    /// The setup of `cell`, with the places of its task.
    pub fn new<'p>(
        cell: &Cell,
        places: impl IntoIterator<Item = (&'p String, &'p PlaceTable)>,
    ) -> Self {
        let mut objects: Vec<ObjectSetup> = cell.objects.iter().map(ObjectSetup::of).collect();
        for (bit, (index, _)) in (0_u32..64).zip(cell.obstacle_objects()) {
            if let Some(object) = objects.get_mut(index) {
                object.obstacle_bit = Some(bit);
            }
        }
        let guides = cell.obstacles().enumerate().filter(|(_, o)| !o.solid);
        Self {
            arms: cell.arms.iter().map(ArmSetup::of).collect(),
            objects,
            places: places.into_iter().map(|(n, p)| place(n, p)).collect(),
            sensors: cell.sensors.iter().map(|s| s.name.clone()).collect(),
            obstacles: cell.obstacles().map(|o| o.name.clone()).collect(),
            solid_obstacles: guides.fold(u64::MAX, |mask, (bit, _)| mask & !(1 << bit.min(63))),
            picks: Picks::default(),
            grasping: Grasping::of(cell),
        }
    }

    /// The first of `others` that `object` would touch if it were set down at `goal` (world frame).
    pub fn blocker(
        &self,
        observation: &Observation<'_>,
        set_down: (usize, &Isometry3<f64>),
        others: impl Iterator<Item = usize>,
    ) -> Option<usize> {
        self.grasping.blocker(observation, set_down, others)
    }

    /// Adds a place that `[task]` does not have.
    pub fn add_place(&mut self, name: &str, table: &PlaceTable) {
        self.places.push(place(name, table));
    }

    /// The setup without a cell: every name counts as known when a file is checked alone.
    pub(crate) fn unknown() -> Self {
        Self {
            arms: Vec::new(),
            objects: Vec::new(),
            places: Vec::new(),
            sensors: Vec::new(),
            obstacles: Vec::new(),
            solid_obstacles: u64::MAX,
            picks: Picks::default(),
            grasping: Grasping::default(),
        }
    }

    /// Index of an object by name.
    pub fn object(&self, name: &str) -> Option<usize> {
        self.objects.iter().position(|object| object.name == name)
    }

    /// Index of a place by name.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.places.iter().position(|place| place.name == name)
    }

    /// Index of an arm by name.
    pub fn arm(&self, name: &str) -> Option<usize> {
        self.arms.iter().position(|arm| arm.name == name)
    }

    /// Index of a sensor by name.
    pub fn sensor(&self, name: &str) -> Option<usize> {
        self.sensors.iter().position(|sensor| sensor == name)
    }

    /// As [`Setup::object`], for a policy that needs it.
    ///
    /// # Errors
    /// Returns a [`SetupError`] with the nearest name.
    pub fn need_object(&self, cell: &Cell, name: &str) -> Result<usize, SetupError> {
        let known: Vec<&str> = self.objects.iter().map(|o| o.name.as_str()).collect();
        need(cell, "object", name, self.object(name), &known)
    }

    /// As [`Setup::place`], for a policy that needs it.
    ///
    /// # Errors
    /// Returns a [`SetupError`] with the nearest name.
    pub fn need_place(&self, cell: &Cell, name: &str) -> Result<usize, SetupError> {
        let known: Vec<&str> = self.places.iter().map(|p| p.name.as_str()).collect();
        need(cell, "place", name, self.place(name), &known)
    }

    /// Refuses a job whose `arm` cannot pick up `object`, for a policy that does nothing else
    /// (ADR 0026).
    ///
    /// # Errors
    /// Returns a [`SetupError`] with the lack of the arm.
    pub fn need_grip(&self, cell: &Cell, arm: usize, object: usize) -> Result<(), SetupError> {
        let object = self.objects.get(object);
        let lack = self.arms.get(arm).and_then(|arm| {
            let lack = ability::lacks(arm, Need::Grip(object))?;
            let object = object.map(|object| object.name.as_str());
            Some(ability::refusal(&arm.name, object, lack))
        });
        lack.map_or(Ok(()), |why| Err(SetupError::new(cell, why)))
    }

    /// Warnings about objects that a file picks and that are out of reach at the start. They may be
    /// moved, so the job is not refused.
    pub(crate) fn far_picks(&self, cell: &Cell) -> Vec<String> {
        let warning = |(arm, object): (usize, usize)| {
            let (of, spec) = (self.arms.get(arm)?, cell.arms.get(arm)?);
            let (found, known) = (cell.objects.get(object)?, self.objects.get(object)?);
            // A parked object is not in the cell yet; its position means nothing.
            if found.parked {
                return None;
            }
            let [x, y, z] = found.pose.translation.vector.into();
            let grip = Vector3::new(x, y, z + of.tool.grasp_height(known));
            let off = (grip - of.base).xy().norm();
            // The distance is checked first: it is a comparison, while the search takes 3 to 63 ms
            // (ADR 0026).
            let why = if of.reaches(grip) {
                let lack = ability::lacks(of, Need::Reach(spec, &[grip]))?;
                format!("it {lack}")
            } else {
                let reach = of.reach_m;
                format!("it reaches {reach:.2} m of {off:.2} m")
            };
            // Kept short: a line of the trace has 160 bytes.
            let (arm, object) = (&of.name, &known.name);
            Some(format!(
                "{arm} cannot pick {object} at [{x:.2}, {y:.2}, {z:.2}]: {why}; move it nearer"
            ))
        };
        self.picks.all().into_iter().filter_map(warning).collect()
    }

    /// Name of an object, for logs.
    pub fn object_name(&self, object: usize) -> &str {
        self.objects.get(object).map_or("?", |o| o.name.as_str())
    }
}

/// Bits of [`ipc_types::ArmGoal::obstacle_mask`] of the obstacles whose name `named` accepts.
pub fn obstacle_bits(cell: &Cell, named: impl Fn(&str) -> bool) -> u64 {
    let obstacles = cell.obstacles().take(64).enumerate();
    obstacles
        .filter(|(_, obstacle)| named(&obstacle.name))
        .fold(0, |mask, (bit, _)| mask | 1 << bit)
}

fn need(
    cell: &Cell,
    what: &str,
    name: &str,
    found: Option<usize>,
    known: &[&str],
) -> Result<usize, SetupError> {
    found.ok_or_else(|| {
        let advice = suggest::advice(name, known);
        SetupError::new(cell, format!("unknown {what} '{name}'; {advice}"))
    })
}

fn place(name: &str, table: &PlaceTable) -> PlaceSetup {
    PlaceSetup {
        name: name.to_owned(),
        slots: table.slots(),
    }
}
