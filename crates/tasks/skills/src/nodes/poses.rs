//! Probable mistakes in poses of files: far away, or with an orientation that is none.

use behavior::tree::Binder;
use nalgebra::Vector3;

use crate::setup::{ARM, Setup};
use crate::shared::ROBOT;

/// No cell is wider: numbers that are millimetres are detected by it (m).
const FAR_M: f64 = 20.0;
/// A quaternion shorter than this has no direction.
pub(super) const NO_LENGTH: f64 = 1.0e-6;
/// A quaternion whose length differs by more was probably mistyped; it is scaled.
const LENGTH_TOLERANCE: f64 = 0.01;

/// Length of a quaternion.
pub(super) fn length(wxyz: [f64; 4]) -> f64 {
    wxyz.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Warns about a doubtful pose of 3 or 7 numbers in `port`.
pub(super) fn check(binder: &mut Binder<'_>, setup: &Setup, port: &str, numbers: &[f64]) {
    let [x, y, z, turn @ ..] = numbers else {
        return;
    };
    let point = Vector3::new(*x, *y, *z);
    let named = binder.text_constant(ROBOT).ok();
    let arm = named.and_then(|name| setup.arm(name)).unwrap_or(ARM);
    let far = match setup.arms.get(arm) {
        // A warning only: the tool may point sideways there, or the tree may never go to it.
        Some(arm) if !arm.reaches(point) => {
            let (off, reach) = ((point - arm.base).norm(), arm.reach_m);
            Some(format!(
                "{off:.2} m from the base of {}, which reaches {reach:.2} m",
                arm.name
            ))
        }
        // A file that is checked without its cell.
        None if point.norm() > FAR_M => Some(format!(
            "{:.0} m from the origin of the cell; are these millimetres?",
            point.norm()
        )),
        _ => None,
    };
    if let Some(far) = far {
        binder.warn("far_pose", format!("'{port}' is {far}"));
    }
    let [w, i, j, k] = *turn else { return };
    let length = length([w, i, j, k]);
    if length < NO_LENGTH {
        let message = format!(
            "the orientation of '{port}' is a quaternion of zeros, which is none, so the node \
             fails; write w x y z of length 1, or x y z only"
        );
        binder.warn("zero_quaternion", message);
    } else if (length - 1.0).abs() > LENGTH_TOLERANCE {
        let message = format!(
            "the quaternion of '{port}' has the length {length:.3} and is scaled to 1; the order is \
             w x y z"
        );
        binder.warn("quaternion_length", message);
    }
}
