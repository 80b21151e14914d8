//! The ring of eight phases, and the conditions for their ends.

use robocell_task::PolicyTime;
use serde::{Deserialize, Serialize};

use super::numbers::StackTask;

/// The phase between two transfers: nothing to do, or not possible.
pub const HOLD: &str = "HOLD";
/// Names of the phases in their order; the last one is that between two transfers.
pub const NAMES: [&str; 9] = [
    "PRE_GRASP",
    "APPROACH",
    "GRASP",
    "LIFT",
    "TRANSPORT",
    "LOWER",
    "RELEASE",
    "RETRACT",
    HOLD,
];

/// A phase of picking up one cube and setting it down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Phase {
    /// Above the cube, gripper open.
    PreGrasp,
    /// Down to the cube.
    Approach,
    /// Close.
    Grasp,
    /// Straight up from the position of the grip.
    Lift,
    /// Above the destination.
    Transport,
    /// Down to it.
    Lower,
    /// Open.
    Release,
    /// Straight up, gripper open.
    Retract,
}

/// State of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhaseStatus {
    /// In progress.
    Running,
    /// Over: its time has passed and its gripper condition is met (GRASP, RELEASE).
    Ok,
    /// Over: the target was reached for long enough.
    Settled,
    /// Over: it took too long; the next phase detects the cause.
    Timeout,
    /// The gripper does not open, so the phase cannot end.
    Blocked,
}

impl PhaseStatus {
    /// Reason for the end of the phase in the log; `None` while it is not over.
    pub fn reason(self) -> Option<&'static str> {
        match self {
            Self::Running | Self::Blocked => None,
            Self::Ok => Some("ok"),
            Self::Settled => Some("settled"),
            Self::Timeout => Some("timeout"),
        }
    }
}

impl Phase {
    /// All phases, in the order of the ring.
    pub const RING: [Self; 8] = [
        Self::PreGrasp,
        Self::Approach,
        Self::Grasp,
        Self::Lift,
        Self::Transport,
        Self::Lower,
        Self::Release,
        Self::Retract,
    ];

    /// Name in logs, scripts and decisions.
    pub fn name(self) -> &'static str {
        NAMES.get(self as usize).unwrap_or(&HOLD)
    }

    /// The phase after this one; `None` after the last.
    pub fn next(self) -> Option<Self> {
        Self::RING.get(self as usize + 1).copied()
    }

    /// Whether the cube has to be in the gripper.
    pub fn holding(self) -> bool {
        matches!(self, Self::Lift | Self::Transport | Self::Lower)
    }

    /// Whether the gripper is closed; it is open in the other four phases.
    pub fn closed(self) -> bool {
        self.holding() || self == Self::Grasp
    }

    /// Whether the TCP is at a cube or its destination; in the other four phases it is above.
    pub fn low(self) -> bool {
        matches!(
            self,
            Self::Approach | Self::Grasp | Self::Lower | Self::Release
        )
    }

    /// State of the phase after `lasted`, with its target reached for long enough (`settled`)
    /// and the gripper `open` or not. GRASP takes its time in any case, RELEASE needs the open
    /// gripper and is blocked without it, the others settle or time out. None is shorter than
    /// the minimum.
    pub fn status(
        self,
        spec: &StackTask,
        lasted: PolicyTime,
        settled: bool,
        open: bool,
    ) -> PhaseStatus {
        let past = |seconds| lasted >= PolicyTime::from_seconds(seconds);
        // The minimum keeps a phase from ending with feedback on the target of the phase
        // before.
        let ready = past(spec.min_phase_s);
        let limit = match self {
            Self::PreGrasp | Self::Retract => spec.timeout_s,
            _ => spec.short_timeout_s,
        };
        match self {
            Self::Grasp if ready => PhaseStatus::Ok,
            Self::Release if ready && open => PhaseStatus::Ok,
            // Without this limit a gripper that does not open would hold the job for ever.
            Self::Release if past(spec.release_timeout_s) => PhaseStatus::Blocked,
            Self::Grasp | Self::Release => PhaseStatus::Running,
            _ if ready && settled => PhaseStatus::Settled,
            _ if past(limit) => PhaseStatus::Timeout,
            _ => PhaseStatus::Running,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_model::{Cell, Data};
    use robocell_skills::Step;

    /// Tick at which `phase` ends and how, evaluated every 10 ms.
    fn end(phase: Phase, there: impl Fn(u64) -> bool, open: bool) -> (u64, PhaseStatus) {
        let cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
        let spec: StackTask = cell.task.read().unwrap();
        let settle = PolicyTime::from_seconds(spec.settle_s);
        let mut step = Step::default();
        for tick in (0..20_000).step_by(10) {
            let now = PolicyTime::from_ticks(tick);
            let settled = step.settles(there(tick), settle, now);
            match phase.status(&spec, now, settled, open) {
                PhaseStatus::Running => {}
                over => return (tick, over),
            }
        }
        (20_000, PhaseStatus::Running)
    }

    #[test]
    fn p05_one_lost_tick_restarts_the_settle_timer() {
        let lost_at_700 = |tick| tick >= 500 && tick != 700;
        assert_eq!(
            end(Phase::Lift, lost_at_700, false),
            (960, PhaseStatus::Settled)
        );
    }

    #[test]
    fn p07_grasp_takes_its_time_whatever_the_feedback() {
        for on_target in [false, true] {
            assert_eq!(
                end(Phase::Grasp, |_| on_target, false),
                (500, PhaseStatus::Ok)
            );
        }
    }

    #[test]
    fn no_phase_is_shorter_than_the_minimum_and_none_endless() {
        for phase in Phase::RING {
            assert_eq!(end(phase, |_| true, true).0, 500, "{phase:?}");
            let limit = match phase {
                Phase::Grasp => 500,
                Phase::PreGrasp | Phase::Retract | Phase::Release => 5000,
                _ => 2500,
            };
            assert_eq!(end(phase, |_| false, false).0, limit, "{phase:?}");
        }
        assert_eq!(end(Phase::Release, |_| true, false).1, PhaseStatus::Blocked);
    }

    #[test]
    fn p21_the_gripper_is_closed_from_grasp_to_lower() {
        let names = |is: fn(Phase) -> bool| {
            let phases = Phase::RING.into_iter().filter(|phase| is(*phase));
            phases.map(Phase::name).collect::<Vec<_>>()
        };
        assert_eq!(
            names(Phase::closed),
            ["GRASP", "LIFT", "TRANSPORT", "LOWER"]
        );
        assert_eq!(names(Phase::holding), ["LIFT", "TRANSPORT", "LOWER"]);
        assert_eq!(names(Phase::low), ["APPROACH", "GRASP", "LOWER", "RELEASE"]);
    }

    #[test]
    fn the_ring_ends_with_retract() {
        assert_eq!(Phase::Release.next(), Some(Phase::Retract));
        assert_eq!(Phase::Retract.next(), None);
    }
}
