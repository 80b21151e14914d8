//! Drag and inertia of a target frame's origin, on its velocity as a vector:
//! `a = -kd |xd| xd`, `M = mu |xd| I`, and a second leaf of weight `inertia I`
//! that requests zero acceleration. Present for every target frame, target or not.

use nalgebra::Vector3;

use crate::DampingParameters;
use crate::kinematics::PointMotion;

/// Weight (times identity) and force of both leaves.
pub(crate) fn leaf(p: &DampingParameters, point: &PointMotion) -> (f64, Vector3<f64>) {
    let speed = point.velocity.norm();
    let drag = p.metric_scalar * speed;
    let weight = drag + p.inertia;
    let force = point.velocity * (-drag * p.accel_d_gain * speed) - point.bias * weight;
    (weight, force)
}
