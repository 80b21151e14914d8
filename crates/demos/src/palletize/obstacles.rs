//! The obstacles that count: some keep the arm away from a place only while it has nothing to
//! do there.

use nalgebra::{Vector2, Vector3};

use super::memory::{Work, WorkKind};
use super::setup::PalletizeSetup;

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
    let [x, y] = setup.task.side_m;
    let side = |p: &Vector3<f64>| x * p.y - y * p.x > 0.0;
    let mut off = 0;
    if at_jig {
        off |= bits.flip_sphere | bits.flip_barrier;
    }
    if side(tool) == side(target) {
        off |= bits.between | bits.flip_barrier;
    }
    !off
}
