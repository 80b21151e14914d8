//! Nine columns: where their bins belong, and the order in which they are filled.

use crate::bin_stack::numbers::BinColumns;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// Columns there are.
pub(super) const COLUMNS: usize = 9;
/// Most levels a column can have.
pub(super) const MAX_LEVELS: usize = 5;

/// The columns by their two indices, in the source's order: diagonal by
/// diagonal, so that the arm never reaches over a full column.
pub(super) const ORDER: [(u8, u8); COLUMNS] = [
    (0, 0),
    (1, 0),
    (0, 1),
    (2, 0),
    (1, 1),
    (0, 2),
    (2, 1),
    (1, 2),
    (2, 2),
];

/// The source's transitions ((3, 6, 8), (1, 3, 6)): a cursor that gets to 3, 6
/// or 8 goes back to 1, 3 or 6 until that diagonal is full. So a diagonal grows
/// level by level; these are where the diagonals begin and end.
const DIAGONALS: [(usize, usize); 5] = [(0, 1), (1, 3), (3, 6), (6, 8), (8, 9)];

/// A place for a bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slot {
    /// Placement of the column in [`ORDER`].
    pub(super) column: usize,
    /// From 0 up.
    pub(super) level: usize,
}

/// Which slots are taken, by any bin: bit per level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Occupied([u8; COLUMNS]);

impl Occupied {
    pub(super) fn take(&mut self, slot: Slot) {
        if let Some(levels) = self.0.get_mut(slot.column) {
            *levels |= 1_u8.checked_shl(bits(slot.level)).unwrap_or(0);
        }
    }

    /// Bins of a column without a gap below them.
    pub(super) fn height(&self, column: usize) -> usize {
        let levels = self.0.get(column).copied().unwrap_or(0);
        levels.trailing_ones() as usize
    }

    /// The slot that is filled next, if any is free.
    pub(super) fn next(&self, levels: usize) -> Option<Slot> {
        DIAGONALS.into_iter().find_map(|(first, end)| {
            (0..levels).find_map(|level| {
                let free = (first..end).find(|column| self.height(*column) <= level);
                free.map(|column| Slot {
                    column,
                    level: self.height(column),
                })
            })
        })
    }
}

fn bits(level: usize) -> u32 {
    u32::try_from(level).unwrap_or(u32::MAX)
}

/// Where the bins of a slot are.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    spec: BinColumns,
    height_m: f64,
}

impl Columns {
    /// `height_m` is that of a bin.
    pub(super) fn new(spec: BinColumns, height_m: f64) -> Self {
        Self { spec, height_m }
    }

    pub(super) fn spec(&self) -> &BinColumns {
        &self.spec
    }

    pub(super) fn levels(&self) -> usize {
        (self.spec.levels as usize).min(MAX_LEVELS)
    }

    /// Centre of a bin in `slot`, world frame (m).
    pub(super) fn centre(&self, slot: Slot) -> Vector3<f64> {
        let (i, j) = ORDER.get(slot.column).copied().unwrap_or_default();
        let (i, j) = (f64::from(i), f64::from(j));
        let [x, y, z] = self.spec.first_m;
        let (first, second) = (self.spec.first_step_m, self.spec.second_step_m);
        let level = u32::try_from(slot.level).map_or(0.0, f64::from);
        Vector3::new(
            x + first[0] * i + second[0] * j,
            y + first[1] * i + second[1] * j,
            z + self.height_m * (level + 0.5),
        )
    }

    /// Pose of a bin in `slot`: upside down. Turned half about the vertical it
    /// is as good.
    pub(super) fn pose(&self, slot: Slot) -> Isometry3<f64> {
        let yaw = UnitQuaternion::new_unchecked(half_turn_quaternion(
            Vector3::z(),
            self.spec.bin_yaw_rad,
        ));
        let over =
            UnitQuaternion::new_unchecked(half_turn_quaternion(Vector3::x(), std::f64::consts::PI));
        Isometry3::from_parts(Translation3::from(self.centre(slot)), yaw * over)
    }

    /// The slot a bin at `pose` is in: upside down, along the column and near
    /// enough to its axis and its height.
    pub(super) fn slot_of(&self, pose: &Isometry3<f64>) -> Option<Slot> {
        let up = pose.rotation * Vector3::z();
        let (sin, cos) = (
            libm::sin(self.spec.bin_yaw_rad),
            libm::cos(self.spec.bin_yaw_rad),
        );
        let along = (pose.rotation * Vector3::x()).dot(&Vector3::new(cos, sin, 0.0));
        if up.z > UPSIDE_DOWN || along.abs() < ALONG {
            return None;
        }
        let position = pose.translation.vector;
        let mut slots = (0..COLUMNS)
            .flat_map(|column| (0..self.levels()).map(move |level| Slot { column, level }));
        slots.find(|slot| {
            let offset = position - self.centre(*slot);
            offset.xy().norm() < self.spec.tolerance_m
                && offset.z.abs() < self.spec.height_tolerance_m
        })
    }
}

/// Part of a bin's long axis along its column's from which on it is straight
/// enough: 8 degrees off.
const ALONG: f64 = 0.99;
/// Height of a bin's own z axis below which it counts as upside down: 8 degrees
/// off.
pub(super) const UPSIDE_DOWN: f64 = -0.99;

/// A turn about a unit `axis` with sine and cosine that are the same everywhere.
pub(super) fn half_turn_quaternion(axis: Vector3<f64>, angle: f64) -> nalgebra::Quaternion<f64> {
    let (sin, cos) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
    nalgebra::Quaternion::new(cos, axis.x * sin, axis.y * sin, axis.z * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Columns {
        let spec = BinColumns {
            first_m: [1.0, -0.6, -0.4],
            first_step_m: [-0.2, 0.0],
            second_step_m: [0.0, 0.3],
            bin_yaw_rad: std::f64::consts::FRAC_PI_2,
            tool_yaw_rad: 0.0,
            levels: 4,
            tolerance_m: 0.02,
            height_tolerance_m: 0.01,
        };
        Columns::new(spec, 0.1)
    }

    #[test]
    fn diagonals_grow_level_by_level_and_one_after_the_other() {
        let mut taken = Occupied::default();
        let mut filled = Vec::new();
        while let Some(slot) = taken.next(4) {
            taken.take(slot);
            filled.push((slot.column, slot.level));
        }
        assert_eq!(filled.len(), 36);
        assert_eq!(filled[..4], [(0, 0), (0, 1), (0, 2), (0, 3)]);
        assert_eq!(filled[4..8], [(1, 0), (2, 0), (1, 1), (2, 1)]);
        assert_eq!(filled[12..15], [(3, 0), (4, 0), (5, 0)]);
        assert_eq!(filled[32..], [(8, 0), (8, 1), (8, 2), (8, 3)]);
    }

    #[test]
    fn a_gap_is_filled_first_and_what_hangs_above_it_does_not_count() {
        let mut taken = Occupied::default();
        for slot in [(0, 0), (0, 2), (0, 3), (1, 0)] {
            let (column, level) = slot;
            taken.take(Slot { column, level });
        }
        assert_eq!(taken.height(0), 1);
        let next = taken.next(4);
        assert_eq!(
            next,
            Some(Slot {
                column: 0,
                level: 1
            })
        );
    }

    #[test]
    fn a_bin_is_in_its_slot_upside_down_and_near_enough_only() {
        let columns = columns();
        let slot = Slot {
            column: 4,
            level: 2,
        };
        let pose = columns.pose(slot);
        assert!((pose.translation.vector - Vector3::new(0.8, -0.3, -0.15)).norm() < 1.0e-12);
        // Long side along y.
        assert!((pose.rotation * Vector3::x()).y.abs() > 0.999);
        assert_eq!(columns.slot_of(&pose), Some(slot));
        let moved = |x: f64, z: f64| Translation3::new(x, 0.0, z) * pose;
        assert_eq!(columns.slot_of(&moved(0.019, 0.009)), Some(slot));
        assert_eq!(columns.slot_of(&moved(0.021, 0.0)), None);
        assert_eq!(columns.slot_of(&moved(0.0, 0.02)), None);
        let across = Isometry3::from_parts(
            pose.translation,
            UnitQuaternion::from_euler_angles(0.0, 0.0, 0.2) * pose.rotation,
        );
        assert_eq!(columns.slot_of(&across), None);
        let upright = Isometry3::from_parts(pose.translation, UnitQuaternion::identity());
        assert_eq!(columns.slot_of(&upright), None);
    }
}
