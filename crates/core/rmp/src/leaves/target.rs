//! Pull of a frame's origin `x` to a position `x0`, with `d = x0 - x`:
//! `a = kp d / (|d| + eps) - kd xd`,
//! `M = [beta b + 1 - beta] [alpha near I + (1 - alpha) far d d^T / |d|^2]`,
//! `alpha = (1 - amin) exp(-|d|^2 / 2 sa^2) + amin`, `beta = exp(-|d|^2 / 2 sb^2)`.

use nalgebra::{Matrix3, Vector3};

use super::bell;
use crate::TargetParameters;
use crate::kinematics::PointMotion;

/// Weight and force of the leaf.
pub(crate) fn leaf(
    p: &TargetParameters,
    target: &Vector3<f64>,
    point: &PointMotion,
) -> (Matrix3<f64>, Vector3<f64>) {
    let d = target - point.position;
    let squared = d.norm_squared();
    let a = d * (p.accel_p_gain / (squared.sqrt() + p.accel_norm_eps))
        - point.velocity * p.accel_d_gain;
    let least = p.min_metric_alpha;
    let alpha = (1.0 - least) * bell(squared, p.metric_alpha_length_scale) + least;
    let beta = bell(squared, p.proximity_metric_boost_length_scale);
    let boost = beta * p.proximity_metric_boost_scalar + 1.0 - beta;
    let mut metric = Matrix3::identity() * (boost * alpha * p.max_metric_scalar);
    // At the target the direction is undefined, and its share of the weight is zero.
    if squared > 0.0 {
        let along = boost * (1.0 - alpha) * p.min_metric_scalar / squared;
        metric += d * d.transpose() * along;
    }
    let force = metric * (a - point.bias);
    (metric, force)
}
