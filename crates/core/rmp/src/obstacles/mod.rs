//! The obstacles of a robot. The kernel reads the boxes around them, four at a time, to find
//! the near ones.

use nalgebra::Isometry3;

use crate::shape::{Obstacle, check_pose};

pub(crate) mod error;
pub(crate) mod packed;

use error::ObstacleError;
use packed::Packed;

/// Names one obstacle of an [`ObstacleSet`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObstacleId(pub usize);

/// A set of obstacles with a fixed capacity. Poses and the enable mask may change every tick
/// without allocating; disabled obstacles cost nothing.
#[derive(Debug, Clone)]
pub struct ObstacleSet {
    /// All parts of all obstacles, those of one obstacle in sequence.
    parts: Vec<Part>,
    /// By id: its first part, and whether it is enabled.
    entries: Vec<(usize, bool)>,
    capacity: usize,
    packed: Packed,
}

#[derive(Debug, Clone)]
struct Part {
    obstacle: Obstacle,
    /// Pose in the frame of the compound; `None` for the only part.
    local: Option<Isometry3<f64>>,
    /// Its place among the enabled parts.
    place: usize,
}

impl ObstacleSet {
    /// An empty set for at most `capacity` obstacles.
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            parts: Vec::with_capacity(capacity),
            entries: Vec::with_capacity(capacity),
            capacity,
            packed: Packed::with_capacity(capacity),
        }
    }

    /// Adds an enabled obstacle.
    ///
    /// # Errors
    /// [`ObstacleError`] for an invalid obstacle or a full set.
    pub fn add(&mut self, obstacle: Obstacle) -> Result<ObstacleId, ObstacleError> {
        obstacle.validate()?;
        self.check_room(1)?;
        let part = Part {
            obstacle,
            local: None,
            place: 0,
        };
        Ok(self.push([part]))
    }

    /// Adds an enabled obstacle at `pose` of these parts, one or several.
    ///
    /// # Errors
    /// As [`ObstacleSet::add`] and [`ObstacleSet::add_compound`].
    pub fn add_parts(
        &mut self,
        pose: Isometry3<f64>,
        parts: &[Obstacle],
    ) -> Result<ObstacleId, ObstacleError> {
        match parts {
            [part] => self.add(Obstacle {
                pose: pose * part.pose,
                ..part.clone()
            }),
            parts => self.add_compound(pose, parts),
        }
    }

    /// Adds an enabled obstacle at `pose` that is made of parts, whose poses are in the frame
    /// of the obstacle: a can of four walls and a floor, for instance. It counts as one
    /// obstacle: for each point of the robot only the nearest part has an effect. Each part
    /// takes one place of the capacity.
    ///
    /// # Errors
    /// [`ObstacleError`] for an invalid part, none, or a full set.
    pub fn add_compound(
        &mut self,
        pose: Isometry3<f64>,
        parts: &[Obstacle],
    ) -> Result<ObstacleId, ObstacleError> {
        check_pose(&pose)?;
        if parts.is_empty() {
            return Err(ObstacleError::Empty);
        }
        // All parts are checked before the first is added: a refused obstacle changes nothing.
        parts.iter().try_for_each(Obstacle::validate)?;
        self.check_room(parts.len())?;
        let placed = parts.iter().map(|part| Part {
            obstacle: Obstacle {
                pose: pose * part.pose,
                ..part.clone()
            },
            local: Some(part.pose),
            place: 0,
        });
        Ok(self.push(placed))
    }

    fn check_room(&self, parts: usize) -> Result<(), ObstacleError> {
        if self.parts.len() + parts <= self.capacity {
            return Ok(());
        }
        Err(ObstacleError::Full {
            capacity: self.capacity,
        })
    }

    fn push(&mut self, parts: impl IntoIterator<Item = Part>) -> ObstacleId {
        let id = self.entries.len();
        self.entries.push((self.parts.len(), true));
        for mut part in parts {
            part.place = self.packed.push(&part.obstacle, id);
            self.parts.push(part);
        }
        ObstacleId(id)
    }

    /// Number of obstacles, enabled or not.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether the set has no obstacle.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Removes every obstacle; ids start from zero again.
    pub fn clear(&mut self) {
        self.parts.clear();
        self.entries.clear();
        self.packed.clear();
    }

    /// The obstacle of that id; of a compound its first part.
    pub fn get(&self, id: ObstacleId) -> Option<&Obstacle> {
        let (first, _) = self.entries.get(id.0)?;
        self.parts.get(*first).map(|part| &part.obstacle)
    }

    /// Pose of the obstacle of that id, as it was added or moved.
    pub fn pose(&self, id: ObstacleId) -> Option<Isometry3<f64>> {
        let part = self.parts.get(self.entries.get(id.0)?.0)?;
        let pose = part.obstacle.pose;
        Some(part.local.map_or(pose, |local| pose * local.inverse()))
    }

    /// The obstacle of that id, or all parts of a compound; empty for an unknown id.
    pub fn parts(&self, id: ObstacleId) -> impl Iterator<Item = &Obstacle> {
        let range = (id.0 < self.entries.len()).then(|| self.range(id.0));
        self.parts[range.unwrap_or(0..0)]
            .iter()
            .map(|part| &part.obstacle)
    }

    /// The enabled obstacles and parts of compounds.
    pub fn enabled(&self) -> impl Iterator<Item = &Obstacle> {
        let ids = (0..self.entries.len()).filter(|&id| self.entries[id].1);
        ids.flat_map(|id| self.parts[self.range(id)].iter().map(|part| &part.obstacle))
    }

    /// Whether the obstacle of that id is enabled; `false` for an unknown id.
    pub fn is_enabled(&self, id: ObstacleId) -> bool {
        self.entries.get(id.0).is_some_and(|(_, enabled)| *enabled)
    }

    /// Moves an obstacle. Does not allocate.
    ///
    /// # Errors
    /// [`ObstacleError::Pose`] or [`ObstacleError::NoSuchId`]; nothing is changed.
    pub fn set_pose(&mut self, id: ObstacleId, pose: Isometry3<f64>) -> Result<(), ObstacleError> {
        check_pose(&pose)?;
        self.check_id(id)?;
        let (range, enabled) = (self.range(id.0), self.entries[id.0].1);
        for part in &mut self.parts[range] {
            part.obstacle.pose = part.local.map_or(pose, |local| pose * local);
            // Only the lane of this part: the places of the others stay.
            if enabled {
                self.packed.move_to(part.place, &part.obstacle);
            }
        }
        Ok(())
    }

    /// Enables or disables an obstacle. Does not allocate.
    ///
    /// # Errors
    /// [`ObstacleError::NoSuchId`].
    pub fn set_enabled(&mut self, id: ObstacleId, enabled: bool) -> Result<(), ObstacleError> {
        self.check_id(id)?;
        let flag = &mut self.entries[id.0].1;
        // Packing all again costs a pass over the set, so only at a change.
        if *flag != enabled {
            *flag = enabled;
            self.pack();
        }
        Ok(())
    }

    fn check_id(&self, id: ObstacleId) -> Result<(), ObstacleError> {
        let count = self.entries.len();
        if id.0 < count {
            return Ok(());
        }
        Err(ObstacleError::NoSuchId { id: id.0, count })
    }

    /// Its parts.
    fn range(&self, id: usize) -> std::ops::Range<usize> {
        let next = self.entries.get(id + 1);
        self.entries[id].0..next.map_or(self.parts.len(), |(first, _)| *first)
    }

    pub(crate) fn packed(&self) -> &Packed {
        &self.packed
    }

    fn pack(&mut self) {
        // In the order of ids: sums have one order, however obstacles were switched.
        self.packed.clear();
        for id in 0..self.entries.len() {
            if self.entries[id].1 {
                let range = self.range(id);
                for part in &mut self.parts[range] {
                    part.place = self.packed.push(&part.obstacle, id);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn nonsense_is_refused() {
        let mut set = ObstacleSet::with_capacity(1);
        assert!(set.add(Obstacle::sphere(Vector3::zeros(), -1.0)).is_err());
        assert!(set.add(Obstacle::sphere(Vector3::zeros(), 0.0)).is_err());
        let nan = Vector3::new(f64::NAN, 0.0, 0.0);
        assert_eq!(
            set.add(Obstacle::sphere(nan, 1.0)),
            Err(ObstacleError::Pose)
        );
        let id = set.add(Obstacle::sphere(Vector3::zeros(), 0.1)).unwrap();
        assert_eq!(
            set.add(Obstacle::sphere(Vector3::zeros(), 0.1)),
            Err(ObstacleError::Full { capacity: 1 })
        );
        assert!(set.set_pose(ObstacleId(1), Isometry3::identity()).is_err());
        assert!(set.set_pose(id, Isometry3::identity()).is_ok());
    }

    #[test]
    fn disabled_obstacles_are_packed_away() {
        let mut set = ObstacleSet::with_capacity(9);
        let ids: Vec<_> = (0..9)
            .map(|i| {
                let center = Vector3::new(f64::from(i), 0.0, 0.0);
                set.add(Obstacle::sphere(center, 0.1)).unwrap()
            })
            .collect();
        assert_eq!(set.packed().blocks().len(), 3);
        set.set_enabled(ids[0], false).unwrap();
        assert_eq!(set.packed().blocks().len(), 2);
        assert_eq!(set.packed().blocks()[0].0[0], [1.0, 2.0, 3.0, 4.0]);
        set.set_pose(ids[2], Isometry3::translation(7.5, 0.0, 0.0))
            .unwrap();
        assert_eq!(set.packed().blocks()[0].0[0], [1.0, 7.5, 3.0, 4.0]);
    }
}
