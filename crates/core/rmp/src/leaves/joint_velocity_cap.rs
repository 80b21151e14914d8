//! Brake near a common joint speed. With `u = |qd| - (vmax - vr)`, for `u > 0`:
//! `a = -kd sgn(qd) u`, `M = mu / max(1 - u^2 / vr^2, 0.001)`; nothing below.
//! The published text clips the weight without naming the value.

use crate::{JointVelocityCapParameters, Root};

/// Least denominator of the weight; ours, see above.
// At the cap the weight is then a thousand times that of the tuning, and stays finite.
const LEAST_DENOMINATOR: f64 = 1e-3;

pub(crate) fn add(root: &mut Root, p: &JointVelocityCapParameters, qd: &[f64]) {
    let region = p.velocity_damping_region;
    for (slot, &velocity) in qd.iter().enumerate() {
        let excess = velocity.abs() - (p.max_velocity - region);
        if excess > 0.0 {
            let denominator = 1.0 - excess * excess / (region * region);
            let weight = p.metric_weight / denominator.max(LEAST_DENOMINATOR);
            let brake = p.damping_gain * excess.copysign(velocity);
            root.add_joint(slot, weight, -weight * brake);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_fast_joint_is_braked_and_beyond_the_cap_too() {
        let p = JointVelocityCapParameters {
            max_velocity: 1.7,
            velocity_damping_region: 0.35,
            damping_gain: 10.0,
            metric_weight: 2000.0,
        };
        let mut root = Root::new(3);
        add(&mut root, &p, &[1.3, -1.5, 5.0]);
        assert_eq!(root.force[0], 0.0);
        assert!(root.force[1] > 0.0);
        assert!(root.force[2] < 0.0 && root.metric[(2, 2)] > 0.0);
    }
}
