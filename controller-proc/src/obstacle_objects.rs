//! Objects of the cell as obstacles: where they are in the newest state, and only
//! while they are there and count.

use cell_model::Cell;
use ipc_types::ObjectState;
use ipc_types::world::OBJECT_ENABLED;
use nalgebra::Isometry3;
use rmp::{Obstacle, ObstacleError, ObstacleId, ObstacleSet};

use crate::convert::isometry;

/// The objects of a cell that motion keeps away from.
#[derive(Debug)]
pub struct ObstacleObjects {
    /// World in the frame of the arm's base.
    to_base: Isometry3<f64>,
    objects: Vec<Entry>,
}

#[derive(Debug)]
struct Entry {
    /// Index in the cell.
    index: usize,
    name: String,
    /// Its shape, in its own frame: of a bin floor and walls, which count as one.
    parts: Vec<Obstacle>,
    id: Option<ObstacleId>,
}

impl ObstacleObjects {
    /// Those of `cell`, seen from a base.
    pub fn new(cell: &Cell, base: &Isometry3<f64>) -> Self {
        let entry = |(index, object): (usize, &cell_model::ObjectSpec)| Entry {
            index,
            name: object.name.clone(),
            parts: object.shape.obstacles(Isometry3::identity()),
            id: None,
        };
        Self {
            to_base: base.inverse(),
            objects: cell.obstacle_objects().map(entry).collect(),
        }
    }

    /// How many obstacles it makes.
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// How many places in a set of obstacles they take.
    pub fn part_count(&self) -> usize {
        self.objects.iter().map(|entry| entry.parts.len()).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    /// Adds them to `set`, switched off.
    ///
    /// # Errors
    /// The name of the object that cannot be an obstacle, and why.
    pub fn add_to(&mut self, set: &mut ObstacleSet) -> Result<(), (String, ObstacleError)> {
        for entry in &mut self.objects {
            let refused = |error| (entry.name.clone(), error);
            let id = set
                .add_parts(Isometry3::identity(), &entry.parts)
                .map_err(refused)?;
            set.set_enabled(id, false).map_err(refused)?;
            entry.id = Some(id);
        }
        Ok(())
    }

    /// Moves them to where `objects`, all objects of the cell, are. One counts
    /// where its bit of `mask` is set, it is in the simulation, and it is not
    /// `held`. Allocates nothing.
    pub fn place(
        &self,
        objects: &[ObjectState],
        mask: u64,
        held: Option<usize>,
        set: &mut ObstacleSet,
    ) {
        for (bit, entry) in self.objects.iter().enumerate() {
            let Some(id) = entry.id else { continue };
            let object = objects.get(entry.index);
            let there = object.filter(|object| {
                let wanted = mask >> bit.min(63) & 1 == 1;
                wanted && object.flags & OBJECT_ENABLED != 0 && held != Some(entry.index)
            });
            // A pose beyond all measure is no place to keep away from.
            let placed = there.is_some_and(|object| {
                let pose = self.to_base * isometry(&object.pose);
                set.set_pose(id, pose).is_ok()
            });
            let _known = set.set_enabled(id, placed).is_ok();
        }
    }
}
