//! Push away from joint limits. For each limit, with `x` the distance to it over
//! the buffered range and `xd` its rate:
//! `a = kp / (x^2 / lp^2 + ep) - kd xd`,
//! `M = (1 - sigmoid(xd / vm)) mu / (x / lm + em)`.
//!
//! Outside the buffered range the published weight turns negative, and the sum of
//! leaves may become indefinite: with [`Floor::Contact`] `x` counts as zero in
//! the weight there. A joint without limits has no leaf.
//!
//! The weight on the joint is `M` over the square of the range: in a range of millimetres the
//! leaf would hold the joint against any target. With [`Floor::Contact`] it is limited to the
//! weight in a range of [`NARROW`]; the limit itself is kept by the resolve.

use super::{Floor, approach_gate};
use crate::{JointLimitParameters, Root};

/// Range (rad or m) below which the weight grows no more. With the published weight a joint
/// with a stroke of 1 mm makes a quarter of the motion to a target in 8 s, with this one all
/// of it in 0.1 s. No joint of a usual arm has such a narrow range.
const NARROW: f64 = 0.1;

/// Buffered range of one controlled joint, rad or m; infinite for none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Range {
    pub(crate) lower: f64,
    pub(crate) upper: f64,
}

pub(crate) fn add(
    root: &mut Root,
    p: &JointLimitParameters,
    ranges: &[Range],
    q: &[f64],
    qd: &[f64],
    floor: Floor,
) {
    for (slot, ((range, &position), &velocity)) in ranges.iter().zip(q).zip(qd).enumerate() {
        let width = range.upper - range.lower;
        // A joint that turns without end has no limit to keep away from.
        if !width.is_finite() {
            continue;
        }
        let scale = 1.0 / width;
        let (pull, push) = match floor {
            Floor::Contact if width < NARROW => (1.0 / NARROW, width / (NARROW * NARROW)),
            _ => (scale, scale),
        };
        // Both limits are one formula with opposite signs.
        let sides = [
            (position - range.lower, 1.0),
            (range.upper - position, -1.0),
        ];
        for (distance, sign) in sides {
            let x = distance * scale;
            let rate = sign * velocity * scale;
            let (a, weight) = one_side(p, x, rate, floor);
            root.add_joint(slot, weight * pull * pull, weight * a * sign * push);
        }
    }
}

fn one_side(p: &JointLimitParameters, x: f64, rate: f64, floor: Floor) -> (f64, f64) {
    let lp = p.accel_potential_exploder_length_scale;
    let push = p.accel_potential_gain / (x * x / (lp * lp) + p.accel_potential_exploder_eps);
    let gate = approach_gate(rate, p.metric_velocity_gate_length_scale);
    let weight = gate * p.metric_scalar
        / (x.max(floor.distance()) / p.metric_length_scale + p.metric_exploder_eps);
    (push - p.accel_damper_gain * rate, weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: JointLimitParameters = JointLimitParameters {
        metric_scalar: 1000.0,
        metric_length_scale: 0.01,
        metric_exploder_eps: 1e-3,
        metric_velocity_gate_length_scale: 0.01,
        accel_damper_gain: 200.0,
        accel_potential_gain: 1.0,
        accel_potential_exploder_length_scale: 0.1,
        accel_potential_exploder_eps: 1e-2,
    };
    const RANGE: [Range; 1] = [Range {
        lower: -1.0,
        upper: 1.0,
    }];

    #[test]
    fn the_nearer_limit_pushes_back() {
        let mut root = Root::new(1);
        add(&mut root, &P, &RANGE, &[0.95], &[0.0], Floor::Contact);
        assert!(root.force[0] < -100.0, "{}", root.force[0]);
        add(&mut root, &P, &RANGE, &[-0.95], &[0.0], Floor::Contact);
        assert!(
            root.force[0].abs() < 1e-6,
            "the two sides mirror each other"
        );
    }

    #[test]
    fn outside_the_range_the_weight_stays_positive_and_points_inward() {
        let mut root = Root::new(1);
        add(&mut root, &P, &RANGE, &[1.2], &[0.0], Floor::Contact);
        assert!(root.metric[(0, 0)] > 0.0);
        assert!(root.force[0] < 0.0);
    }

    #[test]
    fn the_weight_of_a_narrow_range_is_bounded_where_the_formula_is_not_to_the_letter() {
        let weight = |width: f64, floor: Floor| {
            let range = [Range {
                lower: 0.0,
                upper: width,
            }];
            let mut root = Root::new(1);
            add(&mut root, &P, &range, &[0.5 * width], &[0.0], floor);
            root.metric[(0, 0)]
        };
        let at = |width: f64| (weight(width, Floor::None), weight(width, Floor::Contact));
        let (published, ours) = at(NARROW);
        assert_eq!(published, ours);
        let (published, bounded) = at(1.0e-3);
        assert!((published / ours - 1.0e4).abs() < 1.0, "{published} {ours}");
        assert!((bounded / ours - 1.0).abs() < 1.0e-9, "{bounded} {ours}");
    }

    #[test]
    fn a_joint_without_limits_has_no_leaf() {
        let mut root = Root::new(1);
        let free = [Range {
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
        }];
        add(&mut root, &P, &free, &[100.0], &[3.0], Floor::Contact);
        assert_eq!((root.metric[(0, 0)], root.force[0]), (0.0, 0.0));
    }
}
