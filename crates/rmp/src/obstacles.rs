//! Obstacles: one shape, the rounded box, stands for sphere, capsule and cuboid,
//! so that one branch-free kernel serves them all.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use thiserror::Error;

use crate::lanes::LANES;

/// A box of given half extents grown by a radius. Half extents of zero make a
/// sphere, a single one a capsule, radius zero a cuboid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacle {
    /// Pose of the centre in the base frame, m.
    pub pose: Isometry3<f64>,
    /// Half extents of the core box, m, >= 0.
    pub half_extents: Vector3<f64>,
    /// How far the surface lies outside the core box, m, >= 0.
    pub radius: f64,
}

/// Why an obstacle is refused.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ObstacleError {
    /// A size is negative or not finite, or everything has size zero.
    #[error(
        "an obstacle has half extents {half_extents:?} m and radius {radius} m; all must be finite and >= 0, and one greater than 0"
    )]
    Size {
        /// Half extents as given.
        half_extents: [f64; 3],
        /// Radius as given.
        radius: f64,
    },
    /// The pose is not finite or its orientation not a unit quaternion.
    #[error("an obstacle's pose is not a finite position with a unit quaternion")]
    Pose,
    /// The set is full.
    #[error("the obstacle set is full: its capacity is {capacity}")]
    Full {
        /// Its fixed capacity.
        capacity: usize,
    },
    /// No obstacle has this id.
    #[error("there is no obstacle {id}; the set holds {count}")]
    NoSuchId {
        /// The id.
        id: usize,
        /// How many there are.
        count: usize,
    },
}

impl Obstacle {
    /// A sphere at `center` (base frame, m).
    pub fn sphere(center: Vector3<f64>, radius: f64) -> Self {
        Self {
            pose: Isometry3::from_parts(center.into(), UnitQuaternion::identity()),
            half_extents: Vector3::zeros(),
            radius,
        }
    }

    /// A capsule: all points within `radius` of the segment `pt1`-`pt2` (base frame, m).
    pub fn capsule(pt1: Vector3<f64>, pt2: Vector3<f64>, radius: f64) -> Self {
        let along = pt2 - pt1;
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along)
            .unwrap_or_else(UnitQuaternion::identity);
        Self {
            pose: Isometry3::from_parts(((pt1 + pt2) * 0.5).into(), turn),
            half_extents: Vector3::new(0.0, 0.0, 0.5 * along.norm()),
            radius,
        }
    }

    /// A cuboid with these side lengths (m), centred on `pose` (base frame).
    pub fn cuboid(pose: Isometry3<f64>, side_lengths: Vector3<f64>) -> Self {
        Self {
            pose,
            half_extents: side_lengths * 0.5,
            radius: 0.0,
        }
    }

    /// Checks sizes and pose.
    ///
    /// # Errors
    /// [`ObstacleError::Size`] or [`ObstacleError::Pose`].
    pub fn validate(&self) -> Result<(), ObstacleError> {
        let sizes = [
            self.half_extents.x,
            self.half_extents.y,
            self.half_extents.z,
            self.radius,
        ];
        let valid = sizes.iter().all(|s| s.is_finite() && *s >= 0.0);
        if !valid || sizes.iter().all(|&s| s <= 0.0) {
            return Err(ObstacleError::Size {
                half_extents: self.half_extents.into(),
                radius: self.radius,
            });
        }
        check_pose(&self.pose)
    }
}

fn check_pose(pose: &Isometry3<f64>) -> Result<(), ObstacleError> {
    let far = 1e6;
    let unit = (pose.rotation.coords.norm() - 1.0).abs() < 1e-6;
    let near = pose.translation.vector.iter().all(|x| x.abs() < far);
    if unit && near {
        Ok(())
    } else {
        Err(ObstacleError::Pose)
    }
}

/// Names one obstacle of an [`ObstacleSet`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObstacleId(pub usize);

/// Rows of a [`Block`]: centre, the three box axes in the base frame, half
/// extents, radius.
pub(crate) const ROWS: usize = 16;

/// Four obstacles, structure of arrays.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Block(pub(crate) [[f64; LANES]; ROWS]);

/// Centre coordinate of an unused lane, m: so far that it weighs exactly nothing.
const PARKED: f64 = 1e7;

const EMPTY_BLOCK: Block = {
    let mut rows = [[0.0; LANES]; ROWS];
    rows[0] = [PARKED; LANES];
    // Axes of the identity.
    rows[3] = [1.0; LANES];
    rows[7] = [1.0; LANES];
    rows[11] = [1.0; LANES];
    Block(rows)
};

/// A fixed-capacity set of obstacles. Poses and the enable mask may change every
/// tick without allocating; disabled obstacles cost nothing.
#[derive(Debug, Clone)]
pub struct ObstacleSet {
    obstacles: Vec<Obstacle>,
    enabled: Vec<bool>,
    capacity: usize,
    blocks: Vec<Block>,
    /// For each obstacle its place among the enabled ones.
    places: Vec<usize>,
    count: usize,
}

impl ObstacleSet {
    /// An empty set that will hold at most `capacity` obstacles.
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            obstacles: Vec::with_capacity(capacity),
            enabled: Vec::with_capacity(capacity),
            capacity,
            blocks: vec![EMPTY_BLOCK; capacity.div_ceil(LANES)],
            places: Vec::with_capacity(capacity),
            count: 0,
        }
    }

    /// Adds an enabled obstacle.
    ///
    /// # Errors
    /// [`ObstacleError`] for an invalid obstacle or a full set.
    pub fn add(&mut self, obstacle: Obstacle) -> Result<ObstacleId, ObstacleError> {
        obstacle.validate()?;
        if self.obstacles.len() >= self.capacity {
            return Err(ObstacleError::Full {
                capacity: self.capacity,
            });
        }
        self.obstacles.push(obstacle);
        self.enabled.push(true);
        self.places.push(0);
        self.pack();
        Ok(ObstacleId(self.obstacles.len() - 1))
    }

    /// Number of obstacles, enabled or not.
    pub fn len(&self) -> usize {
        self.obstacles.len()
    }

    /// Whether there is no obstacle at all.
    pub fn is_empty(&self) -> bool {
        self.obstacles.is_empty()
    }

    /// Removes every obstacle; ids start from zero again.
    pub fn clear(&mut self) {
        self.obstacles.clear();
        self.enabled.clear();
        self.places.clear();
        self.pack();
    }

    /// The obstacle of that id.
    pub fn get(&self, id: ObstacleId) -> Option<&Obstacle> {
        self.obstacles.get(id.0)
    }

    /// Whether the obstacle of that id is enabled; `false` for an unknown id.
    pub fn is_enabled(&self, id: ObstacleId) -> bool {
        self.enabled.get(id.0).copied().unwrap_or(false)
    }

    /// Moves an obstacle. Does not allocate.
    ///
    /// # Errors
    /// [`ObstacleError::Pose`] or [`ObstacleError::NoSuchId`]; nothing is changed.
    pub fn set_pose(&mut self, id: ObstacleId, pose: Isometry3<f64>) -> Result<(), ObstacleError> {
        check_pose(&pose)?;
        let count = self.obstacles.len();
        let Some(obstacle) = self.obstacles.get_mut(id.0) else {
            return Err(ObstacleError::NoSuchId { id: id.0, count });
        };
        obstacle.pose = pose;
        if self.enabled[id.0] {
            write_lane(&mut self.blocks, self.places[id.0], obstacle);
        }
        Ok(())
    }

    /// Enables or disables an obstacle. Does not allocate.
    ///
    /// # Errors
    /// [`ObstacleError::NoSuchId`].
    pub fn set_enabled(&mut self, id: ObstacleId, enabled: bool) -> Result<(), ObstacleError> {
        let count = self.obstacles.len();
        let Some(flag) = self.enabled.get_mut(id.0) else {
            return Err(ObstacleError::NoSuchId { id: id.0, count });
        };
        if *flag != enabled {
            *flag = enabled;
            self.pack();
        }
        Ok(())
    }

    /// The enabled obstacles, packed, with unused lanes parked.
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks[..self.count.div_ceil(LANES)]
    }

    fn pack(&mut self) {
        self.blocks.fill(EMPTY_BLOCK);
        self.count = 0;
        for (index, obstacle) in self.obstacles.iter().enumerate() {
            if self.enabled[index] {
                self.places[index] = self.count;
                write_lane(&mut self.blocks, self.count, obstacle);
                self.count += 1;
            }
        }
    }
}

fn write_lane(blocks: &mut [Block], place: usize, obstacle: &Obstacle) {
    let center = obstacle.pose.translation.vector;
    let axes = obstacle.pose.rotation.to_rotation_matrix().into_inner();
    let rows = &mut blocks[place / LANES].0;
    let values = center
        .iter()
        .chain(axes.iter())
        .chain(obstacle.half_extents.iter())
        .chain(std::iter::once(&obstacle.radius));
    for (row, value) in rows.iter_mut().zip(values) {
        row[place % LANES] = *value;
    }
}

#[cfg(test)]
mod tests {
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
        assert_eq!(set.blocks().len(), 3);
        set.set_enabled(ids[0], false).unwrap();
        assert_eq!(set.blocks().len(), 2);
        assert_eq!(set.blocks()[0].0[0], [1.0, 2.0, 3.0, 4.0]);
        set.set_pose(ids[2], Isometry3::translation(7.5, 0.0, 0.0))
            .unwrap();
        assert_eq!(set.blocks()[0].0[0], [1.0, 7.5, 3.0, 4.0]);
    }
}
