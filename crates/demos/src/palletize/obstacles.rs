//! Which obstacles count: some keep the arm away from a place only until it is
//! to go there.

use nalgebra::Vector3;

use super::memory::{Work, WorkKind};
use super::setup::PalletizeSetup;

/// A tool this far above what is between the two sides has passed it (m).
const ABOVE_M: f64 = 0.05;

/// The mask of [`ipc_types::ArmGoal::obstacle_mask`] with the tool at `tool` on
/// its way to `target`.
pub(super) fn mask(
    setup: &PalletizeSetup,
    work: Option<&Work>,
    tool: &Vector3<f64>,
    target: &Vector3<f64>,
) -> u64 {
    let bits = setup.obstacles;
    let mut off = 0;
    if at_jig(setup, work, tool, target) {
        off |= bits.flip_sphere | bits.flip_barrier;
    }
    if !crosses(setup, tool, target) {
        off |= bits.between | bits.flip_barrier;
    }
    !off
}

/// The two sides are parted by the line from the arm's base through a point of
/// reference: whether tool and target stand on different ones.
fn crosses(setup: &PalletizeSetup, tool: &Vector3<f64>, target: &Vector3<f64>) -> bool {
    let [x, y] = setup.numbers.side_m;
    let side = |p: &Vector3<f64>| x * p.y - y * p.x > 0.0;
    side(tool) != side(target)
}

/// The arm works at the jig: it brings a bin or leaves it, or takes one there.
fn at_jig(
    setup: &PalletizeSetup,
    work: Option<&Work>,
    tool: &Vector3<f64>,
    target: &Vector3<f64>,
) -> bool {
    if work.is_some_and(|work| work.kind == WorkKind::Flip) {
        return true;
    }
    let flip = &setup.numbers.flip;
    let near = |p: &Vector3<f64>| {
        let off = p.xy() - nalgebra::Vector2::from(flip.jig_m);
        let low = p.z < flip.position_m[2] + setup.numbers.pick.lift_m + ABOVE_M;
        off.norm() < flip.jig_radius_m && low
    };
    near(tool) || near(target)
}
