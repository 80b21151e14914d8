//! The trait of a controller, and controllers that are composed of others.

use nalgebra::{UnitQuaternion, Vector3};

use crate::checkpoint::{CheckpointError, Codec};
use crate::planning::PlanGoal;
use crate::robot_state::RobotState;

/// The goal of a controller for one cycle. Without a position the tool has no goal; a joint
/// that is missing has no preferred position.
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
    /// Starts from `estimated`: the setpoint of the drives, or the last command where controllers
    /// are switched; `false` if that is impossible.
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

/// The controller of an arm and that of its hand, on different joints. Both must give a command.
pub struct CombinedController<A, H> {
    pub(crate) arm: A,
    pub(crate) hand: H,
}

impl<A: Controller, H: Controller> CombinedController<A, H> {
    /// Both together.
    pub fn new(arm: A, hand: H) -> Self {
        Self { arm, hand }
    }
}

impl<A: Controller, H: Controller> Controller for CombinedController<A, H> {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        self.arm.reset(estimated) && self.hand.reset(estimated)
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        let arm = self.arm.forward(estimated, setpoint)?;
        let hand = self.hand.forward(estimated, setpoint)?;
        // Two writers of one joint: no command is better than half a command.
        arm.combine(&hand).ok()
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

/// One of several controllers, chosen by key, or the default one. A switch takes effect at the
/// next forward; the newcomer starts from the last command, so the joints do not jump.
pub struct SelectableController<K, D, C> {
    default: D,
    choices: Vec<Choice<K, C>>,
    /// `None` for the default one.
    active: Option<usize>,
    next: Option<usize>,
    last: RobotState,
}

struct Choice<K, C> {
    key: K,
    name: &'static str,
    controller: C,
}

impl<K: PartialEq, D: Controller, C: Controller> SelectableController<K, D, C> {
    /// The default controller, which is active.
    pub fn new(default: D) -> Self {
        Self {
            default,
            choices: Vec::new(),
            active: None,
            next: None,
            last: RobotState::EMPTY,
        }
    }

    /// Adds a choice.
    #[must_use]
    pub fn or(mut self, key: K, name: &'static str, controller: C) -> Self {
        self.choices.push(Choice {
            key,
            name,
            controller,
        });
        self
    }

    /// Whether a controller beside the default one has that key.
    pub fn has(&self, key: &K) -> bool {
        self.choices.iter().any(|choice| choice.key == *key)
    }

    /// Chooses; takes effect at the next forward. The default one for `None` and for an
    /// unknown key.
    pub fn select(&mut self, key: Option<&K>) {
        let mut choices = self.choices.iter();
        self.next = key.and_then(|key| choices.position(|choice| choice.key == *key));
    }

    /// Name and controller that gave the last command; `None` for the default one.
    pub fn active(&self) -> Option<(&'static str, &C)> {
        let choice = self.choices.get(self.active?)?;
        Some((choice.name, &choice.controller))
    }

    /// The default controller.
    pub fn default(&self) -> &D {
        &self.default
    }

    /// The default controller.
    pub(crate) fn default_mut(&mut self) -> &mut D {
        &mut self.default
    }

    /// Writes or reads which controller is active, the last command, and the state of every
    /// choice: also of those that are not active, so that the number of values stays the same.
    pub(crate) fn checkpoint(
        &mut self,
        codec: &mut Codec<'_>,
        mut choice: impl FnMut(&mut C, &mut Codec<'_>) -> Result<(), CheckpointError>,
    ) -> Result<(), CheckpointError> {
        let mut active = self.active.map_or(0, |active| active + 1);
        codec.index("active controller", &mut active, self.choices.len() + 1)?;
        self.active = active.checked_sub(1);
        self.last.checkpoint(codec)?;
        self.choices
            .iter_mut()
            .try_for_each(|of| choice(&mut of.controller, codec))
    }
}

impl<K: PartialEq + Send, D: Controller, C: Controller> Controller
    for SelectableController<K, D, C>
{
    fn reset(&mut self, estimated: &RobotState) -> bool {
        self.last = *estimated;
        let active = self.active.and_then(|active| self.choices.get_mut(active));
        let others = active.is_none_or(|choice| choice.controller.reset(estimated));
        // The default one also while another is active: it takes over at any cycle.
        self.default.reset(estimated) && others
    }

    fn forward(&mut self, estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        // Here, not in `select`: a switch within a cycle would mix two controllers.
        let is_new = self.next != self.active;
        self.active = self.next;
        let active = self.active.and_then(|active| self.choices.get_mut(active));
        let controller: &mut dyn Controller = match active {
            Some(choice) => &mut choice.controller,
            None => &mut self.default,
        };
        // From the last command, not from the drives: those are one message behind.
        if is_new {
            controller.reset(&self.last);
        }
        self.last = controller.forward(estimated, setpoint)?;
        Some(self.last)
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
    fn a_newcomer_starts_once_from_the_last_command() {
        struct From(f64);
        impl Controller for From {
            fn reset(&mut self, estimated: &RobotState) -> bool {
                self.0 = estimated.positions.get(0).unwrap_or(f64::NAN);
                true
            }
            fn forward(&mut self, _: &RobotState, _: &Setpoint) -> Option<RobotState> {
                let mut state = RobotState::EMPTY;
                state.positions.set(1, self.0);
                Some(state)
            }
        }
        let mut choice = SelectableController::new(Counter::on(0)).or("other", "name", From(0.0));
        assert!(choice.has(&"other") && !choice.has(&"unknown"));
        call(&mut choice).unwrap();
        call(&mut choice).unwrap();
        choice.select(Some(&"other"));
        assert!(choice.active().is_none());
        assert_eq!(call(&mut choice).unwrap().positions.get(1), Some(2.0));
        assert_eq!(choice.active().map(|(name, _)| name), Some("name"));
        choice.select(Some(&"unknown"));
        let last = call(&mut choice).unwrap();
        // Three calls and one reset of the default one.
        assert_eq!(
            (last.positions.get(0), last.velocities.get(0)),
            (Some(3.0), Some(1.0))
        );
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
