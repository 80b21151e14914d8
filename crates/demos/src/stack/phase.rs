//! The ring of eight phases, and when a phase is over.

use serde::{Deserialize, Serialize};

use super::setup::Timing;
use robocell_task::time::PolicyTime;

/// A phase of picking one cube up and setting it down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Above the cube, gripper open.
    PreGrasp,
    /// Down to the cube.
    Approach,
    /// Close.
    Grasp,
    /// Straight up from where the cube stood.
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

impl Phase {
    /// All of them, in the order of the ring.
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
        match self {
            Self::PreGrasp => "PRE_GRASP",
            Self::Approach => "APPROACH",
            Self::Grasp => "GRASP",
            Self::Lift => "LIFT",
            Self::Transport => "TRANSPORT",
            Self::Lower => "LOWER",
            Self::Release => "RELEASE",
            Self::Retract => "RETRACT",
        }
    }

    /// Place in the ring, 0 to 7.
    pub fn index(self) -> u32 {
        self as u32
    }

    /// The phase after this one; `None` after the last.
    pub fn next(self) -> Option<Self> {
        Self::RING.get(self as usize + 1).copied()
    }

    /// The cube has to be in the gripper.
    pub fn holding(self) -> bool {
        matches!(self, Self::Lift | Self::Transport | Self::Lower)
    }

    /// The gripper is closed; it is open in the other four.
    pub fn closed(self) -> bool {
        self.holding() || self == Self::Grasp
    }

    /// The short timeout counts.
    pub fn short(self) -> bool {
        matches!(
            self,
            Self::Approach | Self::Lift | Self::Transport | Self::Lower
        )
    }
}

/// Why a phase is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DoneReason {
    /// Its time is up and its gripper condition is met (GRASP, RELEASE).
    Ok,
    /// The target was reached for long enough.
    Settled,
    /// It took too long; the next phase finds out.
    Timeout,
}

impl DoneReason {
    /// Word in the log.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Settled => "settled",
            Self::Timeout => "timeout",
        }
    }
}

/// What a phase's clock says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Not over.
    Running,
    /// Over.
    Done(DoneReason),
    /// The gripper does not open: it will never be over.
    Blocked,
}

/// How the previous command was obeyed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Feedback {
    /// The TCP is at the previous target.
    pub target_reached: bool,
    /// The gripper is as commanded.
    pub gripper_reached: bool,
}

/// When a phase began, and since when its target is reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PhaseClock {
    started: PolicyTime,
    settled_since: Option<PolicyTime>,
}

impl PhaseClock {
    /// A phase that begins at `now`.
    pub fn start(now: PolicyTime) -> Self {
        Self {
            started: now,
            settled_since: None,
        }
    }

    /// Forgets that the target was reached.
    pub fn unsettle(&mut self) {
        self.settled_since = None;
    }

    /// Guards of the phases: GRASP takes its time whatever the feedback,
    /// RELEASE needs the open gripper besides and is blocked without it, the
    /// others settle or time out. No phase is shorter than the minimum.
    pub fn progress(
        &mut self,
        phase: Phase,
        timing: &Timing,
        now: PolicyTime,
        feedback: Feedback,
    ) -> Progress {
        self.settled_since = match (feedback.target_reached, self.settled_since) {
            (false, _) => None,
            (true, since) => since.or(Some(now)),
        };
        let elapsed = now.since(self.started);
        let ready = elapsed >= timing.min_phase;
        match phase {
            Phase::Grasp if ready => Progress::Done(DoneReason::Ok),
            Phase::Release if ready && feedback.gripper_reached => Progress::Done(DoneReason::Ok),
            Phase::Release if elapsed >= timing.release_timeout => Progress::Blocked,
            Phase::Grasp | Phase::Release => Progress::Running,
            _ if ready && self.settled(timing, now) => Progress::Done(DoneReason::Settled),
            _ if elapsed >= timeout(phase, timing) => Progress::Done(DoneReason::Timeout),
            _ => Progress::Running,
        }
    }

    fn settled(&self, timing: &Timing, now: PolicyTime) -> bool {
        self.settled_since
            .is_some_and(|since| now.since(since) >= timing.settle)
    }
}

fn timeout(phase: Phase, timing: &Timing) -> PolicyTime {
    if phase.short() {
        timing.short_timeout
    } else {
        timing.timeout
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMING: Timing = Timing {
        min_phase: PolicyTime::from_ticks(500),
        settle: PolicyTime::from_ticks(250),
        timeout: PolicyTime::from_ticks(5000),
        short_timeout: PolicyTime::from_ticks(2500),
        release_timeout: PolicyTime::from_ticks(3000),
    };

    /// Tick at which `phase` ends and how, fed every 10 ms.
    fn end(phase: Phase, feedback: impl Fn(u64) -> Feedback) -> (u64, Progress) {
        let mut clock = PhaseClock::start(PolicyTime::default());
        for tick in (0..20_000).step_by(10) {
            let now = PolicyTime::from_ticks(tick);
            match clock.progress(phase, &TIMING, now, feedback(tick)) {
                Progress::Running => {}
                over => return (tick, over),
            }
        }
        (20_000, Progress::Running)
    }

    fn reached(target_reached: bool) -> Feedback {
        Feedback {
            target_reached,
            gripper_reached: false,
        }
    }

    #[test]
    fn p05_one_lost_tick_restarts_the_settle_timer() {
        let lost_at_700 = |tick| reached(tick >= 500 && tick != 700);
        assert_eq!(
            end(Phase::Lift, lost_at_700),
            (960, Progress::Done(DoneReason::Settled))
        );
    }

    #[test]
    fn p07_grasp_takes_its_time_whatever_the_feedback() {
        for on_target in [false, true] {
            let over = end(Phase::Grasp, |_| reached(on_target));
            assert_eq!(over, (500, Progress::Done(DoneReason::Ok)));
        }
    }

    #[test]
    fn no_phase_is_shorter_than_the_minimum_and_none_endless() {
        for phase in Phase::RING {
            let always = Feedback {
                target_reached: true,
                gripper_reached: true,
            };
            assert_eq!(end(phase, |_| always).0, 500, "{phase:?}");
            let limit = match phase {
                Phase::Grasp => 500,
                Phase::PreGrasp | Phase::Retract => 5000,
                Phase::Release => 3000,
                _ => 2500,
            };
            assert_eq!(end(phase, |_| Feedback::default()).0, limit, "{phase:?}");
        }
        assert_eq!(end(Phase::Release, |_| reached(true)).1, Progress::Blocked);
    }

    #[test]
    fn p21_the_gripper_is_closed_from_grasp_to_lower() {
        let closed: Vec<_> = Phase::RING
            .into_iter()
            .filter(|p| p.closed())
            .map(Phase::name)
            .collect();
        assert_eq!(closed, ["GRASP", "LIFT", "TRANSPORT", "LOWER"]);
        let holding: Vec<_> = Phase::RING
            .iter()
            .filter(|p| p.holding())
            .map(|p| p.index())
            .collect();
        assert_eq!(holding, [3, 4, 5]);
    }

    #[test]
    fn the_ring_ends_with_retract() {
        assert_eq!(Phase::Release.next(), Some(Phase::Retract));
        assert_eq!(Phase::Retract.next(), None);
    }
}
