//! The names of the behaviour file, and what they stand for here.

use robocell_skills::Precision;
use robocell_skills::named;

named! {
    /// The eight events of the source.
    pub(super) enum Event {
        Start = "START",
        WaypointReached = "WAYPOINT_REACHED",
        GoalReached = "GOAL_REACHED",
        Attached = "ATTACHED",
        Detached = "DETACHED",
        Timeout = "TIMEOUT",
        Stop = "STOP",
        None = "NONE",
    }
}

named! {
    /// The states.
    pub(super) enum State {
        Standby = "STANDBY",
        Picking = "PICKING",
        Attach = "ATTACH",
        Holding = "HOLDING",
    }
}

impl State {
    /// When a waypoint that is passed counts as reached, and when the last one does.
    pub(super) fn precision(self) -> [Precision; 2] {
        let goal = match self {
            Self::Standby | Self::Holding => Precision::new(0.08, 0.4),
            Self::Picking => Precision::new(0.0005, 0.005),
            Self::Attach => Precision::new(0.0005, 0.0025),
        };
        [Precision::new(0.18, 0.6), goal]
    }
}

named! {
    /// The handlers.
    pub(super) enum Handler {
        ToAboveBin = "to_above_bin",
        ToSurface = "to_surface",
        AimAgain = "aim_again",
        CloseGripper = "close_gripper",
        Lift = "lift",
        AskForParts = "ask_for_parts",
        GiveUp = "give_up",
        StopTasks = "stop_tasks",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robocell_skills::Named as _;

    #[test]
    fn a_name_without_a_meaning_is_refused_with_its_line_and_the_nearest() {
        let text = include_str!("../../../../cells/ur10-fill-bin.matrix.toml");
        let wrong = text.replace("\"ask_for_parts\"", "\"ask_for_part\"");
        let vocabulary = behavior::matrix::Vocabulary {
            events: Event::NAMES,
            states: State::NAMES,
            handlers: Handler::NAMES,
            behaviors: &[],
        };
        let refused = behavior::matrix::Definition::load("fill.toml", &wrong, &vocabulary);
        let why = refused.unwrap_err().to_string();
        assert!(
            why.contains("fill.toml:") && why.contains("ask_for_parts"),
            "{why}"
        );
    }
}
