//! The trait of a controller, and controllers that are composed of others.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, TryLockError};

use nalgebra::{UnitQuaternion, Vector3};

use crate::checkpoint::{CheckpointError, Codec};
use crate::planning::PlanGoal;
use crate::robot_state::RobotState;

/// The goal of a controller for one cycle; a missing part keeps its last value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint {
    /// TCP position in the arm's base frame (m).
    pub position: Option<Vector3<f64>>,
    /// TCP orientation in the arm's base frame; only with `position`.
    pub orientation: Option<UnitQuaternion<f64>>,
    /// The goal behind position and orientation, for a planner; `None` for a setpoint without
    /// a goal of the tool.
    pub goal: Option<PlanGoal>,
    /// Joint values: a preferred posture, or the output of another controller.
    pub joints: RobotState,
    /// Obstacles in force, bit per obstacle.
    pub obstacle_mask: u64,
    /// End every motion and stay at rest.
    pub hold: bool,
}

impl Setpoint {
    /// No goal.
    pub const EMPTY: Self = Self {
        position: None,
        orientation: None,
        goal: None,
        joints: RobotState::EMPTY,
        obstacle_mask: u64::MAX,
        hold: false,
    };
}

/// A part of the control of an arm: one call per cycle. It may be moved to another thread
/// between two cycles.
pub trait Controller: Send {
    /// Starts from `estimated`, the setpoint of the drives; `false` if that is impossible.
    fn reset(&mut self, estimated: &RobotState) -> bool;

    /// The command of this cycle (1 ms); `None` if there is none.
    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState>;

    /// State from cycle to cycle, with a constant number of values: it is in the checkpoint,
    /// from which a recorded run is computed again.
    fn memory(&mut self) -> &mut [f64] {
        &mut []
    }
}

impl Controller for Box<dyn Controller> {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        (**self).reset(estimated)
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        (**self).forward(estimated, setpoint)
    }

    fn memory(&mut self) -> &mut [f64] {
        (**self).memory()
    }
}

/// A controller that is part of several others and keeps its integrated state
/// when they are switched: only its first reset takes effect.
///
/// Those that share it are called one after the other by one cycle, so the mutex is
/// always free: it is tried, never waited for.
pub struct Shared<C> {
    inner: Arc<Mutex<C>>,
    started: Arc<AtomicBool>,
}

impl<C> Clone for Shared<C> {
    fn clone(&self) -> Self {
        Self {
            inner: Arc::clone(&self.inner),
            started: Arc::clone(&self.started),
        }
    }
}

impl<C: Controller> Shared<C> {
    /// Shares `controller`, which has not been reset yet.
    pub fn new(controller: C) -> Self {
        Self {
            inner: Arc::new(Mutex::new(controller)),
            started: Arc::new(AtomicBool::new(false)),
        }
    }

    /// Calls `f` with the controller; `None` from within the controller's own call.
    pub fn with<R>(&self, f: impl FnOnce(&mut C) -> R) -> Option<R> {
        match self.inner.try_lock() {
            Ok(mut inner) => Some(f(&mut inner)),
            // The state is still used after a panic: without it no command would be sent any
            // more.
            Err(TryLockError::Poisoned(inner)) => Some(f(&mut inner.into_inner())),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Writes or reads whether it was reset, and its state by `inner`.
    pub(crate) fn checkpoint(
        &self,
        codec: &mut Codec<'_>,
        inner: impl FnOnce(&mut C, &mut Codec<'_>) -> Result<(), CheckpointError>,
    ) -> Result<(), CheckpointError> {
        let mut started = self.started.load(Ordering::Relaxed);
        codec.bool("started", &mut started)?;
        self.started.store(started, Ordering::Relaxed);
        // A checkpoint is never written from within the controller's own call.
        self.with(|controller| inner(controller, codec))
            .unwrap_or(Ok(()))
    }

    /// Makes the next reset take effect again.
    pub fn restart(&self) {
        self.started.store(false, Ordering::Relaxed);
    }
}

impl<C: Controller> Controller for Shared<C> {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        // Only the first reset counts: a switch of the hand must not stop the arm.
        if self.started.swap(true, Ordering::Relaxed) {
            return true;
        }
        self.with(|inner| inner.reset(estimated)).unwrap_or(false)
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        self.with(|inner| inner.forward(estimated, setpoint))
            .flatten()
    }
}

/// Two controllers on different joints. Both must give a command.
pub struct CombinedController<A, B> {
    first: A,
    second: B,
}

impl<A: Controller, B: Controller> CombinedController<A, B> {
    /// Both together.
    pub fn new(first: A, second: B) -> Self {
        Self { first, second }
    }
}

impl<A: Controller, B: Controller> Controller for CombinedController<A, B> {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        self.first.reset(estimated) && self.second.reset(estimated)
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        let first = self.first.forward(estimated, setpoint)?;
        let second = self.second.forward(estimated, setpoint)?;
        // Two writers of one joint: no command is better than half a command.
        first.combine(&second).ok()
    }
}

/// Two controllers in sequence: the command of the first is the setpoint of the second.
pub struct SequentialController<A, B> {
    first: A,
    second: B,
}

impl<A: Controller, B: Controller> SequentialController<A, B> {
    /// `first` feeding `second`.
    pub fn new(first: A, second: B) -> Self {
        Self { first, second }
    }

    /// The second controller.
    pub fn second(&self) -> &B {
        &self.second
    }

    /// Both.
    pub(crate) fn parts_mut(&mut self) -> (&mut A, &mut B) {
        (&mut self.first, &mut self.second)
    }
}

impl<A: Controller, B: Controller> Controller for SequentialController<A, B> {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        self.first.reset(estimated) && self.second.reset(estimated)
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        let joints = self.first.forward(estimated, setpoint)?;
        self.second.forward(
            estimated,
            &Setpoint {
                joints,
                ..*setpoint
            },
        )
    }
}

/// One of several controllers, chosen by key. A switch takes effect at the next forward; a
/// controller is reset when it becomes active for the first time.
pub struct SelectableController<K> {
    choices: Vec<Choice<K>>,
    active: usize,
    next: usize,
}

struct Choice<K> {
    key: K,
    name: &'static str,
    controller: Box<dyn Controller>,
    started: bool,
}

/// Unknown controller key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown controller key")]
pub struct UnknownKey;

impl<K: PartialEq> SelectableController<K> {
    /// A choice with one entry, which is active.
    pub fn new(key: K, name: &'static str, controller: Box<dyn Controller>) -> Self {
        let choice = Choice {
            key,
            name,
            controller,
            started: false,
        };
        Self {
            choices: vec![choice],
            active: 0,
            next: 0,
        }
    }

    /// Adds an entry.
    #[must_use]
    pub fn or(mut self, key: K, name: &'static str, controller: Box<dyn Controller>) -> Self {
        self.choices.push(Choice {
            key,
            name,
            controller,
            started: false,
        });
        self
    }

    /// Chooses; takes effect at the next forward.
    pub fn select(&mut self, key: &K) -> Result<(), UnknownKey> {
        let found = self.choices.iter().position(|c| c.key == *key);
        self.next = found.ok_or(UnknownKey)?;
        Ok(())
    }

    /// Writes or reads which controller is active and which were started. The state of the
    /// controllers is recorded by their owners.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        let count = self.choices.len();
        codec.index("active controller", &mut self.active, count)?;
        codec.index("next controller", &mut self.next, count)?;
        self.choices
            .iter_mut()
            .try_for_each(|choice| codec.bool("started", &mut choice.started))
    }

    /// Name of the active controller.
    pub fn active_name(&self) -> &'static str {
        self.choices.get(self.active).map_or("", |c| c.name)
    }
}

impl<K: PartialEq + Send> Controller for SelectableController<K> {
    fn reset(&mut self, _estimated: &RobotState) -> bool {
        // Each is reset when it becomes active next, with the setpoint of that cycle.
        self.choices.iter_mut().for_each(|c| c.started = false);
        true
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        // Here, not in `select`: a switch within a cycle would mix two controllers.
        self.active = self.next;
        let choice = self.choices.get_mut(self.active)?;
        if !choice.started {
            choice.started = choice.controller.reset(estimated);
        }
        // A controller that cannot start gives no command; the cycle repeats its last one.
        if !choice.started {
            return None;
        }
        choice.controller.forward(estimated, setpoint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts its resets in the velocity, its calls in the position of a joint.
    struct Counter {
        joint: usize,
        resets: f64,
        calls: f64,
    }

    impl Counter {
        fn on(joint: usize) -> Self {
            Self {
                joint,
                resets: 0.0,
                calls: 0.0,
            }
        }
    }

    impl Controller for Counter {
        fn reset(&mut self, _: &RobotState) -> bool {
            self.resets += 1.0;
            true
        }

        fn forward(&mut self, _: &RobotState, _: &Setpoint) -> Option<RobotState> {
            self.calls += 1.0;
            let mut state = RobotState::EMPTY;
            state.positions.set(self.joint, self.calls);
            state.velocities.set(self.joint, self.resets);
            Some(state)
        }
    }

    fn call(controller: &mut impl Controller) -> Option<RobotState> {
        controller.forward(&RobotState::EMPTY, &Setpoint::EMPTY)
    }

    #[test]
    fn a_switch_keeps_the_arm_and_resets_a_newcomer_once() {
        let arm = Shared::new(Counter::on(0));
        let pair = |finger| Box::new(CombinedController::new(arm.clone(), Counter::on(finger)));
        let mut choice =
            SelectableController::new("open", "open", pair(1)).or("close", "close", pair(2));
        assert_eq!(choice.select(&"ajar"), Err(UnknownKey));
        call(&mut choice).unwrap();
        choice.select(&"close").unwrap();
        assert_eq!(choice.active_name(), "open");
        call(&mut choice).unwrap();
        assert_eq!(choice.active_name(), "close");
        choice.select(&"open").unwrap();
        let last = call(&mut choice).unwrap();
        // Three calls and one reset of the arm; two calls, one reset of the finger.
        assert_eq!(
            (last.positions.get(0), last.velocities.get(0)),
            (Some(3.0), Some(1.0))
        );
        assert_eq!(
            (last.positions.get(1), last.velocities.get(1)),
            (Some(2.0), Some(1.0))
        );
        assert_eq!(last.positions.get(2), None);
    }

    #[test]
    fn two_writers_of_one_joint_give_no_command() {
        let mut both = CombinedController::new(Counter::on(0), Counter::on(0));
        assert_eq!(call(&mut both), None);
    }

    #[test]
    fn the_output_of_the_first_is_the_setpoint_of_the_second() {
        struct Echo;
        impl Controller for Echo {
            fn reset(&mut self, _: &RobotState) -> bool {
                true
            }
            fn forward(&mut self, _: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
                Some(setpoint.joints)
            }
        }
        let mut chain = SequentialController::new(Counter::on(4), Echo);
        assert_eq!(call(&mut chain).unwrap().positions.get(4), Some(1.0));
    }
}
