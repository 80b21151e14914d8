//! The names of the behaviour file, and what they stand for here.

use behavior::machine::StateId;
use behavior::matrix::{HandlerId, Vocabulary};

/// The nine events of the source.
pub(super) const EVENTS: &[&str] = &[
    "START",
    "WAYPOINT_REACHED",
    "GOAL_REACHED",
    "ATTACHED",
    "DETACHED",
    "TIMEOUT",
    "STOP",
    "BROKENGRIP",
    "NONE",
];

/// The states, in the order of [`State`].
pub(super) const STATES: &[&str] = &[
    "STANDBY", "PICKING", "ATTACH", "PLACING", "DETACH", "FLIPPING",
];

/// The handlers, in the order of [`Handler`].
pub(super) const HANDLERS: &[&str] = &[
    "to_above_bin",
    "rest",
    "aim_again",
    "to_surface",
    "close_gripper",
    "back_off",
    "choose_way",
    "over_holder",
    "over_column",
    "open_gripper",
    "count_or_regrip",
    "give_up",
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

/// A state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    Standby,
    Picking,
    Attach,
    Placing,
    Detach,
    Flipping,
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
            3 => Self::Placing,
            4 => Self::Detach,
            5 => Self::Flipping,
            _ => Self::Standby,
        }
    }

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

/// A handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Handler {
    ToAboveBin,
    Rest,
    AimAgain,
    ToSurface,
    CloseGripper,
    BackOff,
    ChooseWay,
    OverHolder,
    OverColumn,
    OpenGripper,
    CountOrRegrip,
    GiveUp,
}

impl Handler {
    /// The handler of that id.
    pub(super) fn of(id: HandlerId) -> Option<Self> {
        const ALL: [Handler; 12] = [
            Handler::ToAboveBin,
            Handler::Rest,
            Handler::AimAgain,
            Handler::ToSurface,
            Handler::CloseGripper,
            Handler::BackOff,
            Handler::ChooseWay,
            Handler::OverHolder,
            Handler::OverColumn,
            Handler::OpenGripper,
            Handler::CountOrRegrip,
            Handler::GiveUp,
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
            (State::Standby, "STANDBY"),
            (State::Picking, "PICKING"),
            (State::Attach, "ATTACH"),
            (State::Placing, "PLACING"),
            (State::Detach, "DETACH"),
            (State::Flipping, "FLIPPING"),
        ];
        for (state, name) in states {
            assert_eq!(STATES[usize::from(state.id().0)], name);
            assert_eq!(State::of(state.id()), state);
        }
        for (index, name) in HANDLERS.iter().enumerate() {
            let id = HandlerId(u16::try_from(index).unwrap());
            let handler = format!("{:?}", Handler::of(id).unwrap()).to_lowercase();
            assert_eq!(handler, name.replace('_', ""));
        }
        assert_eq!(Handler::of(HandlerId(12)), None);
    }
}
