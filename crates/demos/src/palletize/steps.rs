//! The substeps of each state, in their order.

use ipc_types::GripperGoal;

/// One substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The arm stays where it is while the bin comes to the end of the belt; then
    /// the belt stops.
    WaitForBin,
    /// The cup to the bin.
    ReachToPick,
    /// The arm settles at the bin.
    WaitAtBin,
    /// Suction on, until something is attached.
    CloseSuctionGripper,
    /// Up, for a fixed time, reached or not.
    TimedLift,
    /// Up, until it is reached.
    LiftToClearance,
    /// Over the rest pose.
    OrientToHome,
    /// The bin into the jig.
    MoveToFlipStation,
    /// Suction off.
    OpenSuctionGripper,
    /// The bin settles on jig and cup.
    WaitAfterRelease,
    /// Away from under the bin.
    ReleaseFlipStationBin,
    /// Out of the jig's surroundings, the tool still pointing up.
    LeaveFlipStation,
    /// The bin around the arm's own base, which the straight way from the belt to
    /// the pallet passes.
    SwingOut,
    /// The bin to its place.
    ReachToPlace,
    /// The arm settles at the place.
    WaitAtPlace,
}

use Step::{
    CloseSuctionGripper, LeaveFlipStation, LiftToClearance, MoveToFlipStation, OpenSuctionGripper,
    OrientToHome, ReachToPick, ReachToPlace, ReleaseFlipStationBin, SwingOut, TimedLift,
    WaitAfterRelease, WaitAtBin, WaitAtPlace, WaitForBin,
};

/// A bin that opens upwards.
const PICK: &[Step] = &[
    WaitForBin,
    ReachToPick,
    WaitAtBin,
    CloseSuctionGripper,
    LiftToClearance,
];

/// A bin that lies upside down.
const PICK_FLIPPED: &[Step] = &[
    WaitForBin,
    ReachToPick,
    WaitAtBin,
    CloseSuctionGripper,
    TimedLift,
];

const FLIP: &[Step] = &[
    OrientToHome,
    MoveToFlipStation,
    OpenSuctionGripper,
    WaitAfterRelease,
    ReleaseFlipStationBin,
    LeaveFlipStation,
    OrientToHome,
];

const PLACE: &[Step] = &[
    ReachToPlace,
    WaitAtPlace,
    OpenSuctionGripper,
    TimedLift,
    OrientToHome,
];

const SWING_AND_PLACE: &[Step] = &[
    SwingOut,
    ReachToPlace,
    WaitAtPlace,
    OpenSuctionGripper,
    TimedLift,
    OrientToHome,
];

const HOME_AND_PLACE: &[Step] = &[
    OrientToHome,
    ReachToPlace,
    WaitAtPlace,
    OpenSuctionGripper,
    TimedLift,
    OrientToHome,
];

/// How a bin comes to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// From where it is.
    Straight,
    /// Around the base.
    Around,
    /// Over the rest pose.
    Home,
}

/// What a state does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sequence {
    /// Take a bin that opens upwards, or one that lies upside down.
    Pick {
        /// It lies upside down.
        flipped: bool,
    },
    /// Bring one to the jig.
    Flip,
    /// Set one down.
    Place {
        /// On which way.
        way: Way,
    },
}

impl Sequence {
    /// Its substeps.
    pub(super) fn steps(self) -> &'static [Step] {
        match self {
            Self::Pick { flipped: false } => PICK,
            Self::Pick { flipped: true } => PICK_FLIPPED,
            Self::Flip => FLIP,
            Self::Place { way: Way::Straight } => PLACE,
            Self::Place { way: Way::Around } => SWING_AND_PLACE,
            Self::Place { way: Way::Home } => HOME_AND_PLACE,
        }
    }

    /// The substep at `at`; `None` behind the last.
    pub(super) fn step(self, at: usize) -> Option<Step> {
        self.steps().get(at).copied()
    }

    /// Whether the bin has to be on the cup at substep `at`.
    pub(super) fn holds(self, at: usize) -> bool {
        let steps = self.steps();
        let first = |step: Step| steps.iter().position(|it| *it == step);
        match self {
            Self::Pick { .. } => first(CloseSuctionGripper).is_some_and(|close| at > close),
            Self::Flip | Self::Place { .. } => {
                first(OpenSuctionGripper).is_some_and(|open| at < open)
            }
        }
    }

    /// What the gripper is told at substep `at`.
    pub(super) fn gripper(self, at: usize) -> GripperGoal {
        if self.holds(at) || self.step(at) == Some(CloseSuctionGripper) {
            GripperGoal::Close
        } else {
            GripperGoal::Open
        }
    }
}

impl Step {
    /// Its name for people.
    pub(super) fn name(self) -> &'static str {
        match self {
            WaitForBin => "WaitForBin",
            ReachToPick => "ReachToPick",
            WaitAtBin => "WaitAtBin",
            CloseSuctionGripper => "CloseSuctionGripper",
            TimedLift => "TimedLift",
            LiftToClearance => "LiftToClearance",
            OrientToHome => "OrientToHome",
            MoveToFlipStation => "MoveToFlipStation",
            OpenSuctionGripper => "OpenSuctionGripper",
            WaitAfterRelease => "WaitAfterRelease",
            ReleaseFlipStationBin => "ReleaseFlipStationBin",
            LeaveFlipStation => "LeaveFlipStation",
            SwingOut => "SwingOut",
            ReachToPlace => "ReachToPlace",
            WaitAtPlace => "WaitAtPlace",
        }
    }
}
