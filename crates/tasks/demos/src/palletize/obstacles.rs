//! The obstacles that count: some keep the arm away from a place only while it has nothing to
//! do there.

use nalgebra::{Vector2, Vector3};

use super::memory::Work;
use super::setup::PalletizeSetup;
use super::work_kind::WorkKind;

/// The mask of [`ipc_types::ArmGoal::obstacle_mask`] with the tool at `tool` and its goal at
/// `target` (m).
pub(super) fn mask(
    setup: &PalletizeSetup,
    work: Option<&Work>,
    tool: &Vector3<f64>,
    target: &Vector3<f64>,
) -> u64 {
    let bits = setup.obstacles;
    let jig = &setup.task.jig;
    let near = |p: &Vector3<f64>| {
        let off = p.xy() - Vector2::from(jig.middle_m);
        off.norm() < jig.radius_m && p.z < jig.below_z_m
    };
    // The arm brings a bin to the jig, leaves the jig, or picks a bin there.
    let at_jig = work.is_some_and(|work| work.kind == WorkKind::Flip) || near(tool) || near(target);
    // The line from the arm's base through `side_m` separates the two sides: on one side no
    // dome is needed between tool and target.
    let base = setup.base;
    let line = Vector2::from(setup.task.side_m) - base;
    let side = |p: &Vector3<f64>| line.perp(&(p.xy() - base)) > 0.0;
    let mut off = 0;
    if at_jig {
        off |= bits.flip_sphere | bits.flip_barrier;
    }
    if side(tool) == side(target) {
        off |= bits.between | bits.flip_barrier;
    }
    !off
}

#[cfg(test)]
mod tests {
    use cell_model::{Cell, Data};

    use super::super::numbers::PalletizeTask;
    use super::*;

    /// Whether the dome between the two sides counts, with all points moved by `base`.
    fn dome(base: Vector3<f64>, tool: [f64; 3], target: [f64; 3]) -> bool {
        let mut cell = Cell::load(&Data::checkout(), "ur10-palletize", 1, None).unwrap();
        cell.arms[0].base.translation.vector = base;
        let mut task: PalletizeTask = cell.task.read().unwrap();
        task.side_m[0] += base.x;
        task.side_m[1] += base.y;
        let setup = PalletizeSetup::new(&task, &cell).unwrap();
        let (tool, target) = (Vector3::from(tool) + base, Vector3::from(target) + base);
        mask(&setup, None, &tool, &target) & setup.obstacles.between != 0
    }

    #[test]
    fn the_sides_are_those_of_a_line_through_the_base_of_the_arm() {
        for base in [Vector3::zeros(), Vector3::new(2.0, -3.0, 0.5)] {
            for x in [-1.0, -0.5, 0.5, 1.0] {
                for y in [-1.0, -0.5, 0.5, 1.0] {
                    let at = [x, y, 0.0];
                    let same = dome(Vector3::zeros(), at, [0.7, 0.3, 0.0]);
                    assert_eq!(dome(base, at, [0.7, 0.3, 0.0]), same, "{base} {at:?}");
                }
            }
        }
    }
}
