//! The stop policy: one pure function per side, from ages and flags to an action.
//!
//! Both the controller and physics use this table, so that the loss of a peer has the same
//! meaning everywhere. The terms are those of the standards (category 2: controlled stop, power
//! stays on), used for a simulation; no safety function is claimed.
//!
//! What can go wrong: an arm that moves on without a living controller or task, and an arm that
//! stops without need, which ends a job. The rules:
//!
//! - Ages are differences of ticks (ADR 0002), so a paused cell stops nothing, and a recording
//!   is verified with the same stops.
//! - The functions have no state. A latch (a tracking error that has not ended, a quarantine)
//!   is a flag of the caller, which is part of its checkpoint.
//! - The worst action wins; of equals the first cause, in the order fault, tracking, decision.
//! - A value that cannot be compared (NaN) stops the arm.
//!
//! A change of an age limit changes how long an arm moves on: the limits are chosen such that
//! the state reports the stop within 20 ms of the last command, and within 30 ms of the last
//! decision.

use ipc_types::arm::{StopAction, StopCause};

/// Physics brakes when the newest command is older than this (ticks), so that the state reports
/// it within 20 ms of the command.
pub const COMMAND_AGE_TICKS: u64 = 17;
/// Drives count as stopped by category 1 after this time without commands (ticks).
pub const COMMAND_LOST_TICKS: u64 = 2_000;
/// Age limit of a decision with real-time scheduling (ticks): the arm holds within 30 ms of it.
pub const DECISION_AGE_FIFO_TICKS: u64 = 28;
/// Age limit of a decision without real-time scheduling (ticks): longer, since a busy machine
/// delays the task then.
pub const DECISION_AGE_OTHER_TICKS: u64 = 100;
/// A commanded joint farther than this from the measured one is a fault (rad or m).
pub const TRACKING_LIMIT: f64 = 0.25;
/// Such a fault ends when every joint is this near to its command again (rad or m): well below
/// the limit, so that an arm at the limit does not alternate between the two.
pub const TRACKING_CLEAR: f64 = 0.05;

/// An action and its cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stop {
    /// The action.
    pub action: StopAction,
    /// Its cause.
    pub cause: StopCause,
}

impl Stop {
    /// Normal operation.
    pub const NONE: Self = Self {
        action: StopAction::None,
        cause: StopCause::None,
    };

    const fn new(action: StopAction, cause: StopCause) -> Self {
        Self { action, cause }
    }

    /// The worse of two; the first if they are equally bad.
    fn worst(self, other: Self) -> Self {
        if other.action > self.action {
            other
        } else {
            self
        }
    }

    /// Whether motion has to end.
    pub fn stops_motion(self) -> bool {
        self.action >= StopAction::Hold
    }
}

/// The inputs of the controller's stop policy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControllerFlags {
    /// Age of the newest decision, `None` when there never was one (ticks).
    pub decision_age_ticks: Option<u64>,
    /// Age limit in force (ticks).
    pub decision_limit_ticks: u64,
    /// Largest distance of a commanded joint from the measured one (rad, m).
    pub tracking_error: f64,
    /// Whether the arm stopped for that before, and the fault has not ended.
    pub is_giving_way: bool,
    /// Whether physics latched a fault of this arm.
    pub fault: bool,
}

/// The controller's stop policy.
pub fn controller_stop(flags: &ControllerFlags) -> Stop {
    let decision = match flags.decision_age_ticks {
        Some(age) if age <= flags.decision_limit_ticks => Stop::NONE,
        _ => Stop::new(StopAction::Hold, StopCause::DecisionLost),
    };
    let limit = if flags.is_giving_way {
        TRACKING_CLEAR
    } else {
        TRACKING_LIMIT
    };
    // Written such that a NaN counts as too far.
    let tracking = if flags.tracking_error <= limit {
        Stop::NONE
    } else {
        Stop::new(StopAction::Hold, StopCause::TrackingError)
    };
    let fault = if flags.fault {
        Stop::new(StopAction::Hold, StopCause::Quarantine)
    } else {
        Stop::NONE
    };
    fault.worst(tracking).worst(decision)
}

/// The inputs of physics' stop policy, for one arm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhysicsFlags {
    /// Age of the newest accepted command, `None` before the first (ticks).
    pub command_age_ticks: Option<u64>,
    /// Whether the engine disabled a body of this arm.
    pub quarantined: bool,
}

/// Physics' stop policy for one arm. Before the first command the arm holds its pose, which is
/// not a stop.
pub fn physics_stop(flags: PhysicsFlags) -> Stop {
    let command = match flags.command_age_ticks {
        Some(age) if age > COMMAND_LOST_TICKS => {
            Stop::new(StopAction::Stop1, StopCause::CommandLost)
        }
        Some(age) if age > COMMAND_AGE_TICKS => Stop::new(StopAction::Hold, StopCause::CommandLost),
        _ => Stop::NONE,
    };
    if flags.quarantined {
        Stop::new(StopAction::Stop0, StopCause::Quarantine).worst(command)
    } else {
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn healthy() -> ControllerFlags {
        ControllerFlags {
            decision_age_ticks: Some(0),
            decision_limit_ticks: DECISION_AGE_FIFO_TICKS,
            tracking_error: 0.0,
            is_giving_way: false,
            fault: false,
        }
    }

    #[test]
    fn an_arm_that_gives_way_does_so_until_it_is_near() {
        for (error, is_giving_way, cause) in [
            (0.24, false, StopCause::None),
            (0.26, false, StopCause::TrackingError),
            (0.06, true, StopCause::TrackingError),
            (0.04, true, StopCause::None),
        ] {
            let flags = ControllerFlags {
                tracking_error: error,
                is_giving_way,
                ..healthy()
            };
            assert_eq!(controller_stop(&flags).cause, cause, "{error}");
        }
    }

    #[test]
    fn a_silent_task_means_hold_and_a_fresh_one_clears_it() {
        let mut flags = healthy();
        for (age, action) in [
            (Some(DECISION_AGE_FIFO_TICKS), StopAction::None),
            (Some(DECISION_AGE_FIFO_TICKS + 1), StopAction::Hold),
            (None, StopAction::Hold),
            (Some(1), StopAction::None),
        ] {
            flags.decision_age_ticks = age;
            assert_eq!(controller_stop(&flags).action, action, "{age:?}");
        }
    }

    #[test]
    fn a_fault_wins_over_a_silent_task_and_nan_counts_as_far() {
        let flags = ControllerFlags {
            decision_age_ticks: None,
            fault: true,
            ..healthy()
        };
        assert_eq!(controller_stop(&flags).cause, StopCause::Quarantine);
        let flags = ControllerFlags {
            tracking_error: f64::NAN,
            ..healthy()
        };
        assert_eq!(controller_stop(&flags).cause, StopCause::TrackingError);
    }

    #[test]
    fn physics_brakes_after_its_limit_of_silence() {
        for (age, action) in [
            (None, StopAction::None),
            (Some(COMMAND_AGE_TICKS), StopAction::None),
            (Some(COMMAND_AGE_TICKS + 1), StopAction::Hold),
            (Some(2_001), StopAction::Stop1),
        ] {
            let flags = PhysicsFlags {
                command_age_ticks: age,
                quarantined: false,
            };
            assert_eq!(physics_stop(flags).action, action, "{age:?}");
        }
        let flags = PhysicsFlags {
            command_age_ticks: Some(5_000),
            quarantined: true,
        };
        assert_eq!(physics_stop(flags).action, StopAction::Stop0);
    }
}
