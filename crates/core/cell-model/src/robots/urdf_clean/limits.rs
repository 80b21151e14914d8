//! The limits of joints that are used: a file may have none, infinite ones, or degrees.

use std::f64::consts::TAU;

use roxmltree::Node;

use super::parts::{elements, number};
use crate::robots::load::{EFFORT, SLIDE_VELOCITY, TURN_VELOCITY};
use crate::robots::urdf::CONTINUOUS_TURNS;
use crate::robots::urdf_check::{MAX_COORDINATE, MAX_QUANTITY};

/// Travel to one side of a prismatic joint without a limit (m).
const SLIDE_M: f64 = 1.0;
/// Few joints turn farther than this (rad), while ranges of less than [`DEGREES`] degrees are
/// usual.
const TURNS: f64 = CONTINUOUS_TURNS * TAU;
const DEGREES: f64 = 720.0;

/// Limits of a joint (rad or m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) lower: f64,
    pub(super) upper: f64,
}

impl Range {
    pub(super) const NONE: Self = Self {
        lower: 0.0,
        upper: 0.0,
    };

    /// Whether it is narrower than `other` by more than rounding.
    pub(super) fn is_within(self, other: Self) -> bool {
        let rounding = 1.0e-3 * (other.upper - other.lower);
        self.lower > other.lower + rounding || self.upper < other.upper - rounding
    }

    fn is_sound(self) -> bool {
        self.lower < self.upper
    }

    fn farthest(self) -> f64 {
        self.lower.abs().max(self.upper.abs())
    }

    /// Whether it is too far for radians, and usual in degrees.
    fn looks_like_degrees(self) -> bool {
        self.is_sound() && self.farthest() > TURNS && self.farthest() <= DEGREES
    }

    fn radians(self) -> Self {
        Self {
            lower: self.lower.to_radians(),
            upper: self.upper.to_radians(),
        }
    }
}

/// Whether the limits of most revolute joints look like degrees; in a single joint such numbers
/// may also mean no limit.
pub(super) fn in_degrees(robot: Node<'_, '_>) -> bool {
    let (mut suspicious, mut sound) = (0, 0);
    for joint in elements(robot, "joint") {
        let limit = elements(joint, "limit").next();
        let (Some("revolute"), Some(limit)) = (joint.attribute("type"), limit) else {
            continue;
        };
        let value = |key: &str| number(limit, key).unwrap_or(0.0);
        let range = Range {
            lower: value("lower"),
            upper: value("upper"),
        };
        if range.looks_like_degrees() {
            suspicious += 1;
        } else if range.is_sound() && range.farthest() <= TURNS {
            sound += 1;
        }
    }
    suspicious > sound
}

/// The limits that are used.
pub(super) struct Taken {
    pub(super) range: Range,
    /// Whether there are none, and the joint turns.
    pub(super) turns_on: bool,
    pub(super) warning: Option<String>,
}

/// The limits that are used for those of a file.
pub(super) fn taken(stated: Range, slides: bool, in_degrees: bool) -> Taken {
    let Range { lower, upper } = stated;
    let as_stated = |warning| Taken {
        range: stated,
        turns_on: false,
        warning,
    };
    let is_missing = stated == Range::NONE;
    let is_open = (lower < -MAX_COORDINATE, upper > MAX_COORDINATE);
    let suspects = !slides && stated.looks_like_degrees();
    if suspects && in_degrees {
        let range = stated.radians();
        let warning = format!(
            "limits {lower} to {upper} rad: degrees? {:.4} to {:.4} rad are taken",
            range.lower, range.upper
        );
        return Taken {
            range,
            turns_on: false,
            warning: Some(warning),
        };
    }
    // Contradictory limits are passed on, so that they are refused with the numbers of the
    // file.
    if !is_missing && (!stated.is_sound() || is_open == (false, false)) {
        let doubt = format!("limits {lower} to {upper} rad: degrees? they are taken as radians");
        return as_stated(suspects.then_some(doubt));
    }
    let (range, what) = completed(stated, slides, is_open);
    let turns_on = !slides && (is_missing || is_open == (true, true));
    Taken {
        range,
        turns_on,
        warning: Some(what),
    }
}

/// Range in place of one that is missing or open to a side (`is_open`: below, above), with the
/// warning about it.
fn completed(stated: Range, slides: bool, is_open: (bool, bool)) -> (Range, String) {
    let Range { lower, upper } = stated;
    let (doubt, unit) = match (slides, stated.farthest()) {
        (false, far) if stated != Range::NONE && far <= DEGREES => (" (degrees?)", "rad"),
        (true, far) if far.is_finite() && far > MAX_COORDINATE => (" (millimetres?)", "m"),
        (slides, _) => ("", if slides { "m" } else { "rad" }),
    };
    let side = if slides { SLIDE_M } else { TURNS };
    // Measured from zero, or from the given limit where that is beyond it: so zero is in the range
    // if the file allows it.
    let range = match is_open {
        (true, false) => Range {
            lower: upper.min(0.0) - side,
            upper,
        },
        (false, true) => Range {
            lower,
            upper: lower.max(0.0) + side,
        },
        _ => Range {
            lower: -side,
            upper: side,
        },
    };
    let what = match is_open {
        (true, false) => format!("no lower limit{doubt}, {:.3} {unit} is taken", range.lower),
        (false, true) => format!("no upper limit{doubt}, {:.3} {unit} is taken", range.upper),
        _ if slides => format!("no limits{doubt}, {SLIDE_M} m to both sides is taken"),
        _ => format!("no limits{doubt}, two turns to both sides are taken"),
    };
    (range, what)
}

/// The limit of velocity or effort that is used; 0 means none.
pub(super) fn rate_taken(
    stated: f64,
    key: &str,
    slides: bool,
    in_degrees: bool,
) -> (f64, Option<String>) {
    let default = match (key, slides) {
        ("velocity", false) => format!("{TURN_VELOCITY} rad/s"),
        ("velocity", true) => format!("{SLIDE_VELOCITY} m/s"),
        (_, false) => format!("{EFFORT} N m"),
        (_, true) => format!("{EFFORT} N"),
    };
    if stated == 0.0 {
        let what = format!("a limit of {key} of 0 allows no motion; {default} is taken");
        return (0.0, Some(what));
    }
    if stated > MAX_QUANTITY {
        let what = format!("no practical limit of {key}, {default} is taken");
        return (0.0, Some(what));
    }
    if key == "velocity" && in_degrees && !slides && stated > TURNS && stated <= DEGREES {
        let taken = stated.to_radians();
        let what = format!("velocity {stated} rad/s: degrees? {taken:.4} rad/s is taken");
        return (taken, Some(what));
    }
    (stated, None)
}
