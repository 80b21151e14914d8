//! Turn one axis `n` of a frame (unit, base frame) to `n0`:
//! `a = kp (n0 - n) - kd nd`, `M = mu I`, times `beta b + 1 - beta` while the
//! frame has a position target, `beta` as in the position leaf with its own scale.

use nalgebra::Vector3;

use super::bell;
use crate::AxisTargetParameters;
use crate::kinematics::Link;

/// Weight shared by the three axes; `squared` is the squared distance to the
/// position target, m^2, when there is one.
pub(crate) fn weight(p: &AxisTargetParameters, squared: Option<f64>) -> f64 {
    let beta = squared.map_or(0.0, |s| bell(s, p.proximity_metric_boost_length_scale));
    p.metric_scalar * (beta * p.proximity_metric_boost_scalar + 1.0 - beta)
}

/// Force of the leaf for the axis `n` of a link.
pub(crate) fn force(
    p: &AxisTargetParameters,
    weight: f64,
    n: &Vector3<f64>,
    target: &Vector3<f64>,
    link: &Link,
) -> Vector3<f64> {
    let rate = link.angular.cross(n);
    let bias = link.angular_bias.cross(n) + link.angular.cross(&rate);
    ((target - n) * p.accel_p_gain - rate * p.accel_d_gain - bias) * weight
}
