//! The names of the behaviour file, and what they stand for here.

use crate::ur10::named;

named! {
    /// The nine events of the source.
    pub(super) enum Event {
        Start = "START",
        WaypointReached = "WAYPOINT_REACHED",
        GoalReached = "GOAL_REACHED",
        Attached = "ATTACHED",
        Detached = "DETACHED",
        Timeout = "TIMEOUT",
        Stop = "STOP",
        BrokenGrip = "BROKENGRIP",
        None = "NONE",
    }
}

named! {
    /// The states.
    pub(super) enum State {
        Standby = "STANDBY",
        Picking = "PICKING",
        Attach = "ATTACH",
        Placing = "PLACING",
        Detach = "DETACH",
        Flipping = "FLIPPING",
    }
}

impl State {
    /// Row of the precision table for its last waypoint. One that waits for the
    /// gripper to open is no longer precise.
    pub(super) fn row(self, opening: bool) -> usize {
        match self {
            Self::Standby => 3,
            Self::Picking => 1,
            Self::Flipping => 2,
            Self::Detach if opening => 3,
            Self::Attach | Self::Placing | Self::Detach => 0,
        }
    }
}

named! {
    /// The handlers.
    pub(super) enum Handler {
        ToAboveBin = "to_above_bin",
        Rest = "rest",
        AimAgain = "aim_again",
        ToSurface = "to_surface",
        CloseGripper = "close_gripper",
        BackOff = "back_off",
        ChooseWay = "choose_way",
        OverHolder = "over_holder",
        OverColumn = "over_column",
        OpenGripper = "open_gripper",
        CountOrRegrip = "count_or_regrip",
        GiveUp = "give_up",
    }
}
