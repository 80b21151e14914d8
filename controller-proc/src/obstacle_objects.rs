//! Objects of the cell as obstacles: at their poses in the newest state, and only while they
//! are present and in force.

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
    /// Its shape, in its own frame: floor and walls of a bin, which are one obstacle.
    parts: Vec<Obstacle>,
    id: Option<ObstacleId>,
}

impl ObstacleObjects {
    /// The obstacle objects of `cell`, in the frame of a base.
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

    /// Number of obstacles.
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// Number of places in a set of obstacles.
    pub fn part_count(&self) -> usize {
        self.objects.iter().map(|entry| entry.parts.len()).sum()
    }

    /// Whether the cell has no obstacle object.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    /// Adds them to `set`, switched off.
    ///
    /// # Errors
    /// The name of the object that cannot be an obstacle, and the reason.
    pub fn add_to(&mut self, set: &mut ObstacleSet) -> Result<(), (String, ObstacleError)> {
        for entry in &mut self.objects {
            let refused = |error| (entry.name.clone(), error);
            let id = set
                .add_parts(Isometry3::identity(), &entry.parts)
                .map_err(refused)?;
            // Their poses are not known yet: at the origin they would block the base.
            set.set_enabled(id, false).map_err(refused)?;
            entry.id = Some(id);
        }
        Ok(())
    }

    /// Moves them to the poses of `objects`, all objects of the cell. An object is in force if
    /// its bit of `mask` is set, it is in the simulation, and it is not `held`. Allocates
    /// nothing.
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
            // A held object moves with the tool: as an obstacle it would push its own arm
            // away.
            let there = object.filter(|object| {
                let wanted = mask >> bit.min(63) & 1 == 1;
                wanted && object.flags & OBJECT_ENABLED != 0 && held != Some(entry.index)
            });
            // A pose beyond all limits is refused by the set; the object is then switched off.
            let placed = there.is_some_and(|object| {
                let pose = self.to_base * isometry(&object.pose);
                set.set_pose(id, pose).is_ok()
            });
            let _known = set.set_enabled(id, placed).is_ok();
        }
    }
}
