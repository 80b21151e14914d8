//! Limits on position, velocity, acceleration and jerk of the controlled joints.

use thiserror::Error;

/// Limits of each controlled joint, in the order of the controlled joints.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLimits {
    /// Lower position limits, rad or m; `-inf` where there is none.
    pub lower: Vec<f64>,
    /// Upper position limits, rad or m; `+inf` where there is none.
    pub upper: Vec<f64>,
    /// Largest speed, rad/s or m/s, > 0.
    pub velocity: Vec<f64>,
    /// Largest acceleration, rad/s^2 or m/s^2, > 0.
    pub acceleration: Vec<f64>,
    /// Largest jerk, rad/s^3 or m/s^3, > 0.
    pub jerk: Vec<f64>,
}

/// Why limits cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LimitsError {
    /// One of the vectors has another length.
    #[error("limits list {found} values for '{what}', but {expected} joints are controlled")]
    Length {
        /// Which vector.
        what: &'static str,
        /// Its length.
        found: usize,
        /// Number of controlled joints.
        expected: usize,
    },
    /// A limit is not a positive finite number.
    #[error("the {what} limit of joint {joint} is {value}; it must be finite and greater than 0")]
    NotPositive {
        /// Which vector.
        what: &'static str,
        /// Index of the joint.
        joint: usize,
        /// The value.
        value: f64,
    },
    /// Lower is not less than upper.
    #[error("joint {joint} has position limits [{lower}, {upper}]; lower must be less than upper")]
    EmptyRange {
        /// Index of the joint.
        joint: usize,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
}

impl JointLimits {
    /// Number of joints; the vectors agree after [`JointLimits::validate`].
    pub fn len(&self) -> usize {
        self.lower.len()
    }

    /// Whether the limits are of no joint.
    pub fn is_empty(&self) -> bool {
        self.lower.is_empty()
    }

    /// Checks lengths against `joints`, signs and ranges.
    ///
    /// # Errors
    /// [`LimitsError`] naming the first value that cannot be used.
    pub fn validate(&self, joints: usize) -> Result<(), LimitsError> {
        let all = [
            ("lower", &self.lower),
            ("upper", &self.upper),
            ("velocity", &self.velocity),
            ("acceleration", &self.acceleration),
            ("jerk", &self.jerk),
        ];
        for (what, values) in all {
            if values.len() != joints {
                return Err(LimitsError::Length {
                    what,
                    found: values.len(),
                    expected: joints,
                });
            }
        }
        for (what, values) in &all[2..] {
            for (joint, &value) in values.iter().enumerate() {
                if !(value.is_finite() && value > 0.0) {
                    return Err(LimitsError::NotPositive { what, joint, value });
                }
            }
        }
        for (joint, (&lower, &upper)) in self.lower.iter().zip(&self.upper).enumerate() {
            // Infinite limits are valid; NaN would pass a comparison for "less".
            if lower.is_nan() || upper.is_nan() || lower >= upper {
                return Err(LimitsError::EmptyRange {
                    joint,
                    lower,
                    upper,
                });
            }
        }
        Ok(())
    }
}
