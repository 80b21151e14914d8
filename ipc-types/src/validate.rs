//! Every message is validated once, by its receiver.
//!
//! Not only finiteness: the physics engine accepts a velocity of 1e30 without complaint, so
//! values must be plausible as well.
//!
//! The limits are far outside of any cell, so that a valid message is never refused, and far
//! inside of what disturbs the engine. A NaN or an infinite force on one body of a pile
//! disabled six bodies in one step. A change must not break: every `f64` that reaches a
//! computation is checked, by a comparison that is false for NaN.

/// Largest coordinate in a cell (m).
pub const MAX_POSITION_M: f64 = 1.0e3;
/// Largest speed of a body (m/s).
pub const MAX_SPEED_M_S: f64 = 1.0e3;
/// Largest angular speed of a body (rad/s).
pub const MAX_RATE_RAD_S: f64 = 1.0e4;
/// Largest joint position (rad or m).
pub const MAX_JOINT_POSITION: f64 = 1.0e2;
/// Largest joint speed (rad/s or m/s).
pub const MAX_JOINT_VELOCITY: f64 = 1.0e3;
/// Largest effort of a drive (N·m or N).
pub const MAX_EFFORT: f64 = 1.0e5;

/// Reason why a message was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invalid {
    /// The field.
    pub field: &'static str,
    /// Index within the field where it is an array.
    pub index: usize,
    /// The value found.
    pub value: f64,
    /// Allowed values.
    pub allowed: &'static str,
}

impl core::fmt::Display for Invalid {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            field,
            index,
            value,
            allowed,
        } = self;
        write!(f, "{field}[{index}] is {value}, allowed is {allowed}")
    }
}

impl std::error::Error for Invalid {}

/// A message that can check its own content.
pub trait Validate {
    /// Returns the first invalid field as the error.
    fn validate(&self) -> Result<(), Invalid>;
}

/// Checks of single fields: the rules in one place.
pub(crate) struct Check;

impl Check {
    pub(crate) fn within(field: &'static str, values: &[f64], limit: f64) -> Result<(), Invalid> {
        // Written as a negated comparison, so that NaN fails it.
        match values.iter().position(|v| !(v.abs() <= limit)) {
            None => Ok(()),
            Some(index) => Err(Invalid {
                field,
                index,
                value: values[index],
                allowed: "a finite, plausible value",
            }),
        }
    }

    pub(crate) fn unit_quaternion(field: &'static str, q: &[f64; 4]) -> Result<(), Invalid> {
        // Far above rounding in `f64`, far below an angle that matters.
        let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (norm - 1.0).abs() <= 1.0e-6 {
            return Ok(());
        }
        Err(Invalid {
            field,
            index: 0,
            value: norm,
            allowed: "a norm of 1 within 1e-6",
        })
    }

    pub(crate) fn count(field: &'static str, count: u32, capacity: usize) -> Result<(), Invalid> {
        if count as usize <= capacity {
            return Ok(());
        }
        Err(Invalid {
            field,
            index: 0,
            value: f64::from(count),
            allowed: "a count within capacity",
        })
    }

    pub(crate) fn code(field: &'static str, code: u32, known: bool) -> Result<(), Invalid> {
        // Enums travel as numbers: an unknown number would be undefined behaviour as an enum.
        if known {
            return Ok(());
        }
        Err(Invalid {
            field,
            index: 0,
            value: f64::from(code),
            allowed: "a known code",
        })
    }
}

/// Declares an enum that is sent as its `u32` code.
macro_rules! code {
    ($(#[$meta:meta])* pub enum $name:ident { $($(#[$vmeta:meta])* $variant:ident = $code:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(u32)]
        pub enum $name { #[default] $($(#[$vmeta])* $variant = $code,)* }

        impl $name {
            /// The value of a received code, if it is known.
            pub fn from_code(code: u32) -> Option<Self> {
                match code { $($code => Some(Self::$variant),)* _ => None }
            }
            /// The code to send.
            pub fn code(self) -> u32 { self as u32 }
            /// Names and codes of all values.
            pub const CODES: &'static [(&'static str, u32)] =
                &[$((stringify!($variant), $code)),*];
        }
    };
}
pub(crate) use code;
