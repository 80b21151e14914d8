//! Whether an arm that is led to a target arrives there.

use ipc_types::world::FLAG_PAUSED;
use ipc_types::{OperatorPanel, Pose, WorldState};

/// Longest wait (simulated s).
pub(super) const MOST_S: u64 = 20;
/// The arm is at rest when every joint is slower than this (rad/s or m/s) ...
pub(super) const REST: f64 = 2.0e-3;
/// ... for this long (ticks); away from the target longer, as its controller may look for
/// another way.
pub(super) const REST_TICKS: u64 = 300;
pub(super) const AWAY_TICKS: u64 = 1_200;
/// Nearer than this is there (m, rad).
const THERE: (f64, f64) = (2.0e-3, 0.02);

/// How it ended; position and orientation error (m, rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arrival {
    /// The arm is at rest at the target.
    Reached((f64, f64)),
    /// The arm is at rest elsewhere.
    AtRest((f64, f64)),
    /// It moves after [`MOST_S`].
    Moving((f64, f64)),
    /// Simulated time is paused.
    Paused,
    /// There is another target.
    Replaced,
    /// The arm stopped at a contact: its force (N), and the body, as in
    /// [`ipc_types::contact::Contact`].
    Contact(f64, u32),
}

/// An arm on its way.
pub(super) struct Approach {
    target: Pose,
    begin_tick: u64,
    moved_tick: u64,
    /// Contact stops so far, once a state has shown this target.
    heard: Option<u32>,
}

impl Approach {
    /// To `target`, which was given at `tick`.
    pub(super) fn new(target: Pose, tick: u64) -> Self {
        Self {
            target,
            begin_tick: tick,
            moved_tick: tick,
            heard: None,
        }
    }

    /// How it ended, once it has; `state` is the newest.
    pub(super) fn look(&mut self, state: &WorldState, arm: u32) -> Option<Arrival> {
        let (panel, tick) = (&state.panel, state.header.tick);
        let is_ours = panel.target_arm == arm && panel.target == self.target;
        if !is_ours {
            // The request shows in the next state.
            return self
                .heard
                .map(|stops| contact_since(panel, stops).unwrap_or(Arrival::Replaced));
        }
        self.heard = Some(panel.contact_stops);
        // In a pause no tick passes, so none of the limits below would end the wait.
        if state.has(FLAG_PAUSED) {
            return Some(Arrival::Paused);
        }
        let found = state.arms().get(arm as usize)?;
        let joints = found
            .joint_velocities
            .iter()
            .take(found.joint_count as usize);
        if joints.into_iter().any(|rate| rate.abs() > REST) {
            self.moved_tick = tick;
        }
        let error = error(&found.tcp, &self.target);
        let rests = tick.saturating_sub(self.moved_tick);
        if error.0 < THERE.0 && error.1 < THERE.1 {
            if rests >= REST_TICKS {
                return Some(Arrival::Reached(error));
            }
        } else if rests >= AWAY_TICKS {
            return Some(Arrival::AtRest(error));
        }
        (tick > self.begin_tick + 1000 * MOST_S).then_some(Arrival::Moving(error))
    }
}

/// The contact stop after the first `stops` ones, if there was one.
pub(super) fn contact_since(panel: &OperatorPanel, stops: u32) -> Option<Arrival> {
    let is_new = panel.contact_stops != stops;
    is_new.then_some(Arrival::Contact(panel.contact_force, panel.contact_with))
}

/// Distance (m) and angle (rad) between two poses.
fn error(from: &Pose, to: &Pose) -> (f64, f64) {
    let offset = from.position.iter().zip(&to.position).map(|(a, b)| a - b);
    let distance_m = offset.map(|x| x * x).sum::<f64>().sqrt();
    let both = from.orientation_wxyz.iter().zip(&to.orientation_wxyz);
    let cos_half: f64 = both.map(|(a, b)| a * b).sum();
    // `q` and `-q` are one orientation. Rounding may exceed 1, where `acos` is not a number.
    (distance_m, 2.0 * cos_half.abs().min(1.0).acos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    /// An arm at rest `away` from a target that was given at tick 0.
    fn at_rest(away: f64, ticks: u64) -> Option<Arrival> {
        let mut target = Pose::IDENTITY;
        target.position[0] = 0.5;
        let mut approach = Approach::new(target, 0);
        let mut state = WorldState::zeroed();
        (state.arm_count, state.arms[0].joint_count) = (1, 7);
        state.arms[0].tcp = target;
        state.arms[0].tcp.position[0] += away;
        (state.panel.target_seq, state.panel.target) = (1, target);
        (0..ticks).find_map(|tick| {
            state.header.tick = tick;
            state.arms[0].joint_velocities[3] = if tick < 500 { 0.1 } else { 0.0 };
            approach.look(&state, 0)
        })
    }

    #[test]
    fn an_arm_at_rest_is_there_or_says_how_far_away_it_is() {
        assert_eq!(at_rest(0.0, 700), None);
        assert_eq!(at_rest(-2.0, 1600), None);
        assert_eq!(at_rest(0.0, 1000), Some(Arrival::Reached((0.0, 0.0))));
        let Some(Arrival::AtRest((distance_m, _))) = at_rest(-2.053, 2000) else {
            panic!("it is not at rest");
        };
        assert!((distance_m - 2.053).abs() < 1e-9);
    }

    #[test]
    fn what_moves_is_waited_for_and_another_target_ends_the_wait() {
        let mut target = Pose::IDENTITY;
        target.position[2] = 0.3;
        let mut approach = Approach::new(target, 10);
        let mut state = WorldState::zeroed();
        (state.arm_count, state.arms[0].joint_count) = (1, 6);
        assert_eq!(
            approach.look(&state, 0),
            None,
            "the request is not taken yet"
        );
        state.panel.target = target;
        state.arms[0].joint_velocities[0] = 0.5;
        for tick in [11, 400, 1000, 20_000] {
            state.header.tick = tick;
            assert_eq!(approach.look(&state, 0), None, "{tick}");
        }
        state.header.tick = 20_011;
        assert!(matches!(approach.look(&state, 0), Some(Arrival::Moving(_))));
        state.panel.target.position[0] = 1.0;
        assert_eq!(approach.look(&state, 0), Some(Arrival::Replaced));
        (state.panel.contact_stops, state.panel.contact_force) = (1, 34.0);
        assert_eq!(approach.look(&state, 0), Some(Arrival::Contact(34.0, 0)));
    }
}
