//! The names of the behaviour file, and what they stand for here.

use robocell_skills::Precision;
use robocell_skills::named;

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
    /// When a waypoint that is passed counts as reached, and when the last one does.
    /// One that waits for the gripper to open is no longer precise.
    pub(super) fn precision(self, opening: bool) -> [Precision; 2] {
        let goal = match self {
            Self::Standby => Precision::new(0.08, 0.4),
            Self::Picking => Precision::new(0.0005, 0.005),
            Self::Flipping => Precision::new(0.05, 0.2),
            Self::Detach if opening => Precision::new(0.08, 0.4),
            Self::Attach | Self::Placing | Self::Detach => Precision::new(0.0005, 0.0025),
        };
        [Precision::new(0.18, 0.6), goal]
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
