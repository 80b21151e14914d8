//! The names of the behaviour file, and what they stand for here.

use behavior::machine::StateId;
use behavior::matrix::{EventId, HandlerId, Vocabulary};

/// The eight events of the source, in the order of [`Event`].
pub(super) const EVENTS: &[&str] = &[
    "START",
    "WAYPOINT_REACHED",
    "GOAL_REACHED",
    "ATTACHED",
    "DETACHED",
    "TIMEOUT",
    "STOP",
    "NONE",
];

/// The states, in the order of [`State`].
pub(super) const STATES: &[&str] = &["STANDBY", "PICKING", "ATTACH", "HOLDING"];

/// The handlers, in the order of [`Handler`].
pub(super) const HANDLERS: &[&str] = &[
    "to_above_bin",
    "to_surface",
    "aim_again",
    "close_gripper",
    "lift",
    "ask_for_parts",
    "give_up",
    "stop_tasks",
];

/// All of them.
pub(super) fn vocabulary() -> Vocabulary<'static> {
    Vocabulary {
        events: EVENTS,
        states: STATES,
        handlers: HANDLERS,
        behaviors: &[],
    }
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event {
    Start,
    WaypointReached,
    GoalReached,
    Attached,
    Detached,
    Timeout,
    Stop,
}

impl Event {
    /// Its id in a compiled matrix.
    pub(super) fn id(self) -> EventId {
        EventId(self as u16)
    }
}

/// A state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Standby,
    Picking,
    Attach,
    Holding,
}

impl State {
    /// Its id in a compiled matrix.
    pub(super) fn id(self) -> StateId {
        StateId(self as u16)
    }

    /// The state of that id.
    pub(super) fn of(id: StateId) -> Self {
        match id.0 {
            1 => Self::Picking,
            2 => Self::Attach,
            3 => Self::Holding,
            _ => Self::Standby,
        }
    }

    /// Row of the precision table for its last waypoint.
    pub(super) fn row(self) -> usize {
        match self {
            Self::Standby | Self::Holding => 3,
            Self::Picking => 1,
            Self::Attach => 0,
        }
    }
}

/// A handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Handler {
    ToAboveBin,
    ToSurface,
    AimAgain,
    CloseGripper,
    Lift,
    AskForParts,
    GiveUp,
    StopTasks,
}

impl Handler {
    /// The handler of that id.
    pub(super) fn of(id: HandlerId) -> Option<Self> {
        const ALL: [Handler; 8] = [
            Handler::ToAboveBin,
            Handler::ToSurface,
            Handler::AimAgain,
            Handler::CloseGripper,
            Handler::Lift,
            Handler::AskForParts,
            Handler::GiveUp,
            Handler::StopTasks,
        ];
        ALL.get(usize::from(id.0)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_what_they_stand_for_are_in_the_same_order() {
        let states = [
            State::Standby,
            State::Picking,
            State::Attach,
            State::Holding,
        ];
        for (state, name) in states.into_iter().zip(STATES) {
            assert_eq!(format!("{state:?}").to_uppercase(), *name);
            assert_eq!(State::of(state.id()), state);
        }
        for (index, name) in HANDLERS.iter().enumerate() {
            let id = HandlerId(u16::try_from(index).unwrap());
            let handler = format!("{:?}", Handler::of(id).unwrap()).to_lowercase();
            assert_eq!(handler, name.replace('_', ""));
        }
        let events = [
            Event::Start,
            Event::WaypointReached,
            Event::GoalReached,
            Event::Attached,
            Event::Detached,
            Event::Timeout,
            Event::Stop,
        ];
        for (event, name) in events.into_iter().zip(EVENTS) {
            let written = format!("{event:?}").to_lowercase();
            assert_eq!(written, name.replace('_', "").to_lowercase());
        }
    }

    #[test]
    fn a_name_without_a_meaning_is_refused_with_its_line_and_the_nearest() {
        let text = include_str!("../../../cells/ur10-fill-bin.matrix.toml");
        let wrong = text.replace("\"ask_for_parts\"", "\"ask_for_part\"");
        let refused = behavior::matrix::Definition::load("fill.toml", &wrong, &vocabulary());
        let why = refused.unwrap_err().to_string();
        assert!(
            why.contains("fill.toml:") && why.contains("ask_for_parts"),
            "{why}"
        );
    }
}
