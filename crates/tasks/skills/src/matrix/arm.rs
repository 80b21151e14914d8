//! The memory and the numbers of a matrix job's arm.

use behavior::numbers::Numbers;
use ipc_types::GripperGoal;
use robocell_task::PolicyTime;
use robocell_task::job::MOST_COUNTED;
use serde::{Deserialize, Serialize};

use crate::named::Named;
use crate::path::{Path, Precision};
use crate::suction::GripMemory;

/// The memory of the arm; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ArmMemory {
    /// The path of the arm.
    pub path: Path,
    /// The gripper as last observed.
    pub grip: GripMemory,
    suction: Suction,
    /// Time before which no goal counts as reached.
    pub(super) wait_until: PolicyTime,
    /// Time at which the state was entered.
    pub since: PolicyTime,
    /// Number of times that suction attached nothing at this surface.
    pub(super) refused: u32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Suction {
    #[default]
    Keep,
    Off,
    On,
}

impl ArmMemory {
    /// The memory at the start: the arm holds, and the gripper keeps its state.
    pub fn new() -> Self {
        Self {
            path: Path::new(),
            ..Self::default()
        }
    }

    /// Whether a restored memory is valid.
    pub(super) fn is_sound(&self) -> bool {
        self.path.is_sound() && self.refused < MOST_COUNTED
    }

    /// The goal of the gripper.
    pub fn gripper(&self) -> GripperGoal {
        match self.suction {
            Suction::Keep => GripperGoal::Keep,
            Suction::Off => GripperGoal::Open,
            Suction::On => GripperGoal::Close,
        }
    }

    /// Whether suction shall be on.
    pub fn closes(&self) -> bool {
        self.suction == Suction::On
    }

    /// Switches suction on or off.
    pub fn switch(&mut self, on: bool) {
        self.suction = if on { Suction::On } else { Suction::Off };
    }

    /// The goal has to be reached again, `pause` from now on.
    pub fn again_after(&mut self, pause: PolicyTime, now: PolicyTime) {
        self.wait_until = PolicyTime::from_ticks(now.ticks() + pause.ticks());
        self.path.again();
    }
}

/// Numbers about the arm in the behaviour file.
#[derive(Clone, Debug, PartialEq)]
pub struct ArmNumbers {
    /// By state: precision at which a waypoint that is passed counts as reached, and the last
    /// one.
    precision: Vec<[Precision; 2]>,
    /// An arm nearer than this to its target resumes its path (m).
    pub resume_m: f64,
    /// An object slower than this is at rest (m/s).
    pub rest_speed_m_s: f64,
    /// And turns slower than this (rad/s).
    pub rest_turn_rad_s: f64,
    /// At a surface the arm is at rest for this time,
    pub settle: PolicyTime,
    /// eases off by this (m), since the rest of the way down would push the object into its
    /// support and break the grip,
    pub ease_m: f64,
    /// in this time.
    pub ease: PolicyTime,
    /// Number of attempts of suction at one surface.
    pub tries_in_place: u32,
}

impl ArmNumbers {
    /// Reads `[precision]`, by state of `S`, and `[numbers]`.
    pub(super) fn read<S: Named>(from: &mut Numbers) -> Self {
        let passing = precision(from, "passing");
        let states = S::NAMES.iter();
        Self {
            precision: states.map(|s| [passing, precision(from, s)]).collect(),
            resume_m: from.number("numbers.resume_m", 0.0, 10.0),
            rest_speed_m_s: from.number("numbers.rest_speed_m_s", 1.0e-4, 10.0),
            rest_turn_rad_s: from.number("numbers.rest_turn_rad_s", 1.0e-4, 10.0),
            settle: seconds(from, "settle_s", 60.0),
            ease_m: from.number("numbers.ease_m", 0.0, 0.1),
            ease: seconds(from, "ease_s", 60.0),
            tries_in_place: from.count("numbers.tries_in_place", 1, 100),
        }
    }

    /// The precision of `state`; a state without one never reaches a goal.
    pub(super) fn precision<S: Named>(&self, state: S) -> [Precision; 2] {
        let found = self.precision.get(usize::from(state.index()));
        found.copied().unwrap_or([Precision::new(0.0, 0.0); 2])
    }
}

/// The time of `key` in `[numbers]`, from 0 to `most` (s).
pub fn seconds(from: &mut Numbers, key: &str, most: f64) -> PolicyTime {
    PolicyTime::from_seconds(from.number(&format!("numbers.{key}"), 0.0, most))
}

fn precision(from: &mut Numbers, state: &str) -> Precision {
    Precision::new(
        from.number(&format!("precision.{state}.position_m"), 1.0e-5, 10.0),
        from.number(&format!("precision.{state}.axis"), 1.0e-5, 3.0),
    )
}
