//! A grasp, and what excludes it.

use std::fmt;

use nalgebra::Isometry3;

/// Where the tool comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Approach {
    /// Straight down.
    Above,
    /// Down and to the side, about half way.
    Oblique,
    /// Level.
    Side,
}

impl Approach {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Above => "above",
            Self::Oblique => "oblique",
            Self::Side => "side",
        }
    }
}

/// Where along its way the tool closes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// At the centre of the object.
    Centre,
    /// As low as the support of the object allows.
    Low,
    /// At the near end of the object.
    Upper,
    /// On a face.
    Face,
}

impl Depth {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Low => "low",
            Self::Upper => "upper part",
            Self::Face => "face",
        }
    }
}

/// A pose of the tool in which it grips an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Pose of the TCP.
    pub tcp: Isometry3<f64>,
    /// Where the tool comes from.
    pub approach: Approach,
    /// Where it closes.
    pub depth: Depth,
    /// Width of the object between the fingers; of the face for a cup (m).
    pub width_m: f64,
    /// Distance of the fingers on the way there; 0 for a cup (m).
    pub opening_m: f64,
    /// The smaller, the better.
    pub cost: f64,
    /// What excludes it.
    pub excluded: Option<Exclusion>,
}

/// Why a grasp is not possible.
#[derive(Clone, Debug, PartialEq)]
pub enum Exclusion {
    /// The object is wider than the hand opens.
    TooWide {
        /// Width of the object there (m).
        width_m: f64,
        /// Width of the open hand, with the clearance that it needs (m).
        opens_m: f64,
    },
    /// Too little of the object is between the pads.
    TooThin {
        /// Length of the pads that touches it (m).
        overlap_m: f64,
    },
    /// The rim of the cup is not on the face.
    CupLargerThanFace {
        /// Radius of the largest circle on the face (m).
        face_m: f64,
        /// Radius of the cup (m).
        cup_m: f64,
    },
    /// The hand would touch the object itself.
    Hand,
    /// A fixture is in the way.
    Fixture(String),
    /// Another object is in the way.
    Object(String),
    /// Another arm is in the way.
    Arm(String),
    /// The joints of the arm cannot bring the tool there.
    OutOfReach,
}

impl Exclusion {
    /// Stable name, as in the outcome of a job.
    pub fn reason(&self) -> &'static str {
        match self {
            Self::TooWide { .. } => "too_wide",
            Self::TooThin { .. } => "too_thin",
            Self::CupLargerThanFace { .. } => "cup_larger_than_face",
            Self::Hand => "no_room_for_fingers",
            Self::Fixture(_) => "blocked_by_fixture",
            Self::Object(_) => "blocked_by_object",
            Self::Arm(_) => "blocked_by_arm",
            Self::OutOfReach => "object_out_of_reach",
        }
    }
}

impl fmt::Display for Exclusion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |m: &f64| 1.0e3 * m;
        match self {
            Self::TooWide { width_m, opens_m } => write!(
                f,
                "it is {:.1} mm wide, and the hand opens {:.1} mm",
                mm(width_m),
                mm(opens_m)
            ),
            Self::TooThin { overlap_m } => {
                write!(f, "{:.1} mm of the pads would touch it", mm(overlap_m))
            }
            Self::CupLargerThanFace { face_m, cup_m } => write!(
                f,
                "a circle of {:.1} mm fits on the face, and the cup has {:.1} mm",
                mm(face_m),
                mm(cup_m)
            ),
            Self::Hand => f.write_str("the hand would touch it"),
            Self::Fixture(name) | Self::Object(name) | Self::Arm(name) => {
                write!(f, "{name} is in the way")
            }
            Self::OutOfReach => f.write_str("the arm does not reach it"),
        }
    }
}
