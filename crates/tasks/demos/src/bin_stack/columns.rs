//! Nine columns: the poses of their bins, and the order in which they are filled.

use behavior::numbers::Numbers;
use nalgebra::{Isometry3, Translation3, Vector3};
use robocell_skills::pose;

use super::numbers::{BinColumns, COLUMNS};

/// Largest number of levels, as in the schema of `levels`; `Occupied` has a bit for each in a
/// `u8`.
const MAX_LEVELS: usize = 5;

/// The order in which the columns are filled, chosen so that the arm never reaches over a full
/// one.
pub(super) struct Order {
    /// The columns: first plus three times second index.
    columns: Vec<u32>,
    /// Ranges of columns, by place in the order, that grow together, level by level.
    groups: Vec<(usize, usize)>,
}

impl Order {
    /// Of `[numbers]`: `column_order`, and `filled_together`, how many columns grow
    /// together.
    pub(super) fn read(from: &mut Numbers) -> Self {
        let columns = from.counts("numbers.column_order", 0, 8);
        let mut sorted = columns.clone();
        sorted.sort_unstable();
        // A column that is missing would never be filled and the job would not end; one that is
        // named twice would be filled twice.
        if !sorted.into_iter().eq(0..9) {
            let why = "each number from 0 to 8 is needed once";
            from.refuse("numbers.column_order", why);
        }
        let mut groups = Vec::new();
        let mut first = 0;
        for count in from.counts("numbers.filled_together", 1, 9) {
            let end = first + count as usize;
            groups.push((first, end));
            first = end;
        }
        if first != COLUMNS {
            from.refuse("numbers.filled_together", "9 in all are needed");
        }
        Self { columns, groups }
    }

    /// The two indices of a column, by its place in the order.
    pub(super) fn column(&self, column: usize) -> (u32, u32) {
        let number = self.columns.get(column).copied().unwrap_or_default();
        (number % 3, number / 3)
    }

    /// The slots that can be filled next, one for each column with room, in the order in which
    /// they are filled.
    pub(super) fn next(&self, taken: Occupied, levels: usize) -> impl Iterator<Item = Slot> {
        // Groups one after the other, and in each the lowest level first: a column that is
        // higher than its neighbours would be in the way of the tool.
        self.groups.iter().flat_map(move |(first, end)| {
            (0..levels).flat_map(move |level| {
                let columns = (*first..*end).filter(move |column| taken.height(*column) == level);
                columns.map(move |column| Slot { column, level })
            })
        })
    }
}

/// A place for a bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slot {
    /// Place of the column in the [`Order`].
    pub(super) column: usize,
    /// From 0 up.
    pub(super) level: usize,
}

/// The slots that are taken by any bin: a bit for each level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Occupied([u8; COLUMNS]);

impl Occupied {
    pub(super) fn take(&mut self, slot: Slot) {
        if let Some(levels) = self.0.get_mut(slot.column) {
            *levels |= 1_u8.checked_shl(bits(slot.level)).unwrap_or(0);
        }
    }

    /// Number of bins in a column without a gap below them.
    pub(super) fn height(&self, column: usize) -> usize {
        let levels = self.0.get(column).copied().unwrap_or(0);
        // Only bits without a gap count: a bin above a gap is not where it belongs.
        levels.trailing_ones() as usize
    }
}

fn bits(level: usize) -> u32 {
    u32::try_from(level).unwrap_or(u32::MAX)
}

/// The poses of the bins in the slots.
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

    pub(super) fn levels(&self) -> usize {
        (self.spec.levels as usize).min(MAX_LEVELS)
    }

    /// Centre of a bin in `slot`, world frame (m).
    fn centre(&self, order: &Order, slot: Slot) -> Vector3<f64> {
        let (i, j) = order.column(slot.column);
        self.at(f64::from(i), f64::from(j), slot.level)
    }

    /// Centre of the lowest bin of the column in the middle, world frame (m).
    pub(super) fn middle(&self) -> Vector3<f64> {
        self.at(1.0, 1.0, 0)
    }

    fn at(&self, i: f64, j: f64, level: usize) -> Vector3<f64> {
        let [x, y, z] = self.spec.first_m;
        let (first, second) = (self.spec.first_step_m, self.spec.second_step_m);
        let level = u32::try_from(level).map_or(0.0, f64::from);
        Vector3::new(
            x + first[0] * i + second[0] * j,
            y + first[1] * i + second[1] * j,
            z + self.height_m * (level + 0.5),
        )
    }

    /// Pose of a bin in `slot`, upside down. A bin turned by half a turn about the vertical is
    /// as good.
    pub(super) fn pose(&self, order: &Order, slot: Slot) -> Isometry3<f64> {
        let yaw = pose::about(Vector3::z(), self.spec.bin_yaw_rad);
        let over = pose::about(Vector3::x(), std::f64::consts::PI);
        Isometry3::from_parts(self.centre(order, slot).into(), yaw * over)
    }

    /// Poses of a bin on its way down into `slot`, one height apart, from the slot up.
    pub(super) fn way_down(
        &self,
        order: &Order,
        slot: Slot,
    ) -> impl Iterator<Item = Isometry3<f64>> {
        let pose = self.pose(order, slot);
        let heights = slot.level..=self.levels();
        let steps = heights.scan(0.0, |up, _| Some(std::mem::replace(up, *up + 1.0)));
        steps.map(move |step| Translation3::new(0.0, 0.0, self.height_m * step) * pose)
    }

    /// The slot of a bin at `at`: upside down, aligned with the column, and near enough to its
    /// axis and to its height. `straight` is the least cosine of both angles.
    pub(super) fn slot_of(
        &self,
        order: &Order,
        straight: f64,
        at: &Isometry3<f64>,
    ) -> Option<Slot> {
        let up = at.rotation * Vector3::z();
        let column = pose::about(Vector3::z(), self.spec.bin_yaw_rad) * Vector3::x();
        // The absolute value accepts both directions: a bin has the same shape after half a
        // turn.
        let along = (at.rotation * Vector3::x()).dot(&column);
        if up.z > -straight || along.abs() < straight {
            return None;
        }
        let position = at.translation.vector;
        let mut slots = (0..COLUMNS)
            .flat_map(|column| (0..self.levels()).map(move |level| Slot { column, level }));
        slots.find(|slot| {
            let offset = position - self.centre(order, *slot);
            offset.xy().norm() < self.spec.tolerance_m
                && offset.z.abs() < self.spec.height_tolerance_m
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use robocell_skills::matrix;

    use super::super::job::{BinStack, BinStackNumbers};
    use super::*;

    fn own() -> BinStackNumbers {
        let text = include_str!("../../../../../cells/ur10-bin-stack.matrix.toml");
        let (_, _, own) = matrix::load::<BinStack>("bins.toml", text).unwrap();
        own
    }

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
        let (mut taken, order) = (Occupied::default(), own().order);
        let mut filled = Vec::new();
        while let Some(slot) = order.next(taken, 4).next() {
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
        let order = own().order;
        let next: Vec<_> = order.next(taken, 4).collect();
        let slot = |column, level| Slot { column, level };
        // One slot of each column that has room: the lowest one.
        assert_eq!(next[..3], [slot(0, 1), slot(2, 0), slot(1, 1)]);
        assert_eq!(next.len(), 9);
    }

    #[test]
    fn a_bin_is_in_its_slot_upside_down_and_near_enough_only() {
        let (columns, own) = (columns(), own());
        let slot = Slot {
            column: 4,
            level: 2,
        };
        let pose = columns.pose(&own.order, slot);
        assert!((pose.translation.vector - Vector3::new(0.8, -0.3, -0.15)).norm() < 1.0e-12);
        // Long side along y.
        assert!((pose.rotation * Vector3::x()).y.abs() > 0.999);
        assert_eq!(columns.slot_of(&own.order, own.straight, &pose), Some(slot));
        let moved = |x: f64, z: f64| Translation3::new(x, 0.0, z) * pose;
        assert_eq!(
            columns.slot_of(&own.order, own.straight, &moved(0.019, 0.009)),
            Some(slot)
        );
        assert_eq!(
            columns.slot_of(&own.order, own.straight, &moved(0.021, 0.0)),
            None
        );
        assert_eq!(
            columns.slot_of(&own.order, own.straight, &moved(0.0, 0.02)),
            None
        );
        let across = Isometry3::from_parts(
            pose.translation,
            UnitQuaternion::from_euler_angles(0.0, 0.0, 0.2) * pose.rotation,
        );
        assert_eq!(columns.slot_of(&own.order, own.straight, &across), None);
        let upright = Isometry3::from_parts(pose.translation, UnitQuaternion::identity());
        assert_eq!(columns.slot_of(&own.order, own.straight, &upright), None);
    }
}
