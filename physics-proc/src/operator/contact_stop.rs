//! Ends a target of the operator at a contact force.
//!
//! The drives are stiff: a target that a person sets 1 mm into a table presses with more than
//! 300 N. The arm therefore stays where it touched.

use ipc_types::MAX_JOINTS;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Share of a tick in the mean of the force: a mean of about 16 ms, as that of the suction cup.
// A hand that sets an object down presses with hundreds of newtons for a single tick.
const SHARE: f64 = 1.0 / 16.0;

/// Share of the limit below which the arm may stay.
const CALM: f64 = 0.5;

/// The watch over the arm that the operator leads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ContactStop {
    /// A target leads the arm: it was given in this pause of the task, and did not end yet.
    pub(super) is_on: bool,
    pub(super) limit_n: f64,
    /// Targets that ended so; 0 remains "never".
    pub(super) stops: u32,
    /// Body of the largest contact in the last of them.
    pub(super) with: u32,
    /// Force of the last of them (N).
    pub(super) force_n: f64,
    /// Mean force on the arm and on the held object (N, world frame); `None` before the first tick.
    mean_n: Option<[f64; 3]>,
    /// Force at the first tick (N).
    // An arm that presses already has to get away from there: only more than that ends its target.
    base_n: f64,
    /// Where the arm was when less than half of the limit pressed on it.
    // Where the limit is exceeded the drives are pressed in already, and would press on.
    calm: Option<Place>,
}

/// Where an arm is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Place {
    /// Tool (m, world frame).
    pub(super) position: [f64; 3],
    pub(super) orientation_wxyz: [f64; 4],
    /// Controlled joints (rad or m).
    pub(super) joints: [f64; MAX_JOINTS],
}

/// Contacts of an arm and of the held object.
#[derive(Clone, Copy, Default)]
pub(crate) struct Pressure {
    /// Sum of the contact forces (N, world frame): fingers that close on an object press against
    /// each other, which is no contact force of the arm.
    pub(crate) force: Vector3<f64>,
    /// The body of the largest of them, as in [`ipc_types::contact::Contact`].
    pub(crate) with: u32,
}

impl ContactStop {
    /// Nothing was led yet.
    pub(super) const NEW: Self = Self {
        is_on: false,
        limit_n: ipc_types::operator::CONTACT_LIMIT_N,
        stops: 0,
        with: 0,
        force_n: 0.0,
        mean_n: None,
        base_n: 0.0,
        calm: None,
    };

    /// A new target with its limit (N); not above 0: the default.
    pub(super) fn start(&mut self, limit_n: f64) {
        let default = ipc_types::operator::CONTACT_LIMIT_N;
        self.limit_n = if limit_n > 0.0 { limit_n } else { default };
        // The mean continues: targets come 20 times per second while a handle is dragged.
        self.is_on = true;
    }

    /// The operator leads no longer.
    pub(super) fn end(&mut self) {
        (self.is_on, self.mean_n, self.calm) = (false, None, None);
    }

    /// One tick at `here`; where the arm has to stay if the target has to end.
    pub(super) fn update(&mut self, pressure: &Pressure, here: Place) -> Option<Place> {
        if pressure.force.norm() < CALM * self.limit_n {
            self.calm = Some(here);
        }
        let mean = match self.mean_n {
            None => {
                self.base_n = pressure.force.norm();
                pressure.force
            }
            Some(mean) => {
                let mean = Vector3::from(mean);
                mean + (pressure.force - mean) * SHARE
            }
        };
        self.mean_n = Some(mean.into());
        let force_n = mean.norm();
        // Less than the base is no base any more: it is pressed into again later.
        self.base_n = self.base_n.min(force_n);
        if force_n <= self.limit_n + self.base_n {
            return None;
        }
        self.stops = self.stops.checked_add(1).unwrap_or(1);
        (self.with, self.force_n) = (pressure.with, force_n);
        let stay = self.calm.unwrap_or(here);
        self.end();
        Some(stay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks until a target ends, of those that press with `force_n`.
    fn ends(watch: &mut ContactStop, force_n: f64, ticks: usize) -> Option<usize> {
        let pressure = Pressure {
            force: Vector3::z() * force_n,
            with: 7,
        };
        (0..ticks).find(|tick| {
            let here = Place {
                position: [0.0, 0.0, *tick as f64],
                orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
                joints: [0.0; MAX_JOINTS],
            };
            watch.update(&pressure, here).is_some()
        })
    }

    #[test]
    fn a_force_above_the_limit_ends_a_target_and_a_short_one_does_not() {
        let mut watch = ContactStop::NEW;
        watch.start(0.0);
        assert_eq!(ends(&mut watch, 0.0, 10), None);
        assert_eq!(
            ends(&mut watch, 400.0, 1),
            None,
            "one tick of 25 N in the mean"
        );
        assert_eq!(ends(&mut watch, 10.0, 100), None);
        assert!(ends(&mut watch, 40.0, 100).is_some());
        assert_eq!((watch.stops, watch.with), (1, 7));
        assert!(!watch.is_on && watch.force_n > 30.0, "{watch:?}");
    }

    #[test]
    fn an_arm_that_presses_already_may_leave_and_not_press_harder() {
        let mut watch = ContactStop::NEW;
        watch.start(20.0);
        assert_eq!(ends(&mut watch, 50.0, 100), None);
        assert_eq!(ends(&mut watch, 60.0, 100), None);
        assert!(ends(&mut watch, 75.0, 100).is_some());
        watch.start(20.0);
        assert_eq!(ends(&mut watch, 50.0, 100), None);
        assert_eq!(ends(&mut watch, 0.0, 200), None, "it left");
        assert!(ends(&mut watch, 50.0, 100).is_some(), "and came back");
    }
}
