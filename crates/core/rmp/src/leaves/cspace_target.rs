//! Pull towards the default posture:
//! `a = kp r(q0 - q) - kd qd`, `M = mu I`, `r` capping the norm of the error at
//! `theta`; and a second leaf of weight `inertia` that requests zero acceleration.

use crate::{CspaceTargetParameters, Root};

pub(crate) fn add(
    root: &mut Root,
    p: &CspaceTargetParameters,
    posture: &[f64],
    q: &[f64],
    qd: &[f64],
) {
    let squared: f64 = posture.iter().zip(q).map(|(t, x)| (t - x) * (t - x)).sum();
    let norm = squared.sqrt();
    let cap = p.robust_position_term_thresh;
    let scale = if norm > cap { cap / norm } else { 1.0 };
    for (slot, ((target, x), xd)) in posture.iter().zip(q).zip(qd).enumerate() {
        let a = p.position_gain * (scale * (target - x)) - p.damping_gain * xd;
        root.add_joint(slot, p.metric_scalar + p.inertia, p.metric_scalar * a);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: CspaceTargetParameters = CspaceTargetParameters {
        metric_scalar: 50.0,
        position_gain: 100.0,
        damping_gain: 50.0,
        robust_position_term_thresh: 0.5,
        inertia: 1.0,
    };

    #[test]
    fn a_far_posture_pulls_no_harder_than_the_cap() {
        let mut root = Root::new(2);
        add(&mut root, &P, &[3.0, 4.0], &[0.0, 0.0], &[0.0, 0.0]);
        // Error of norm 5 is capped at 0.5 along its direction.
        assert!((root.force[0] - 50.0 * 100.0 * 0.3).abs() < 1e-9);
        assert!((root.force[1] - 50.0 * 100.0 * 0.4).abs() < 1e-9);
        assert_eq!(root.metric[(0, 0)], 51.0);
        assert_eq!(root.metric[(0, 1)], 0.0);
    }

    #[test]
    fn at_the_posture_only_damping_acts() {
        let mut root = Root::new(1);
        add(&mut root, &P, &[0.2], &[0.2], &[1.0]);
        assert_eq!(root.force[0], -50.0 * 50.0);
    }
}
