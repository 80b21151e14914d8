//! The leaves, one concept a file. `d` denotes a time derivative; every leaf gives an
//! acceleration `a` and a weight `M`, and adds `M` and `M (a - Jdot qd)`.

pub(crate) mod axis_target;
pub(crate) mod collision;
pub(crate) mod cspace_target;
pub(crate) mod damping;
pub(crate) mod joint_limit;
pub(crate) mod joint_velocity_cap;
pub(crate) mod self_collision;
pub(crate) mod surface;
pub(crate) mod target;

/// Least distance in the weights of repulsive leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Floor {
    /// No floor: the published formulas to the letter, with their poles.
    None,
    /// Contact: a smaller distance counts as zero, so that no weight turns negative.
    Contact,
}

impl Floor {
    pub(crate) fn distance(self) -> f64 {
        match self {
            Self::None => f64::NEG_INFINITY,
            Self::Contact => 0.0,
        }
    }
}

/// `1 - sigmoid(rate / scale)`: one while approaching, zero while moving away.
#[inline]
pub(crate) fn approach_gate(rate: f64, scale: f64) -> f64 {
    1.0 / (1.0 + libm::exp(rate / scale))
}

/// `exp(-distance^2 / (2 scale^2))` for a squared distance.
#[inline]
pub(crate) fn bell(squared: f64, scale: f64) -> f64 {
    libm::exp(-squared / (2.0 * scale * scale))
}
