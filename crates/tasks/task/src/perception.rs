//! The poses of objects as the task perceives them, for `[disturbance]`: the poses of the
//! state, each with a constant offset and with noise. Both depend on the seed, the object
//! and the tick alone, so a restarted task perceives the same.

use cell_model::Cell;
use cell_model::cells::cell::{Disturbance, turn_about_z};
use cell_model::random::Random;
use ipc_types::{Pose, Wire as _, WorldState};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The sensor of the task.
#[derive(Default)]
pub(crate) struct Perception {
    disturbance: Disturbance,
    seed: u64,
    /// The disturbed state; none where the state itself is used.
    seen: Option<Box<WorldState>>,
}

impl Perception {
    /// The perception of a cell.
    pub(crate) fn new(cell: &Cell) -> Self {
        let disturbance = cell.disturbance;
        // The delay of drives acts in physics. Without this line a cell with only that delay
        // would copy a state of 20 kB per decision without a change.
        let sees_all = Disturbance {
            drive_delay_s: disturbance.drive_delay_s,
            ..Disturbance::default()
        };
        Self {
            disturbance,
            seed: cell.seed,
            seen: (disturbance != sees_all).then(|| Box::new(WorldState::zeroed())),
        }
    }

    /// The task's view of `state`.
    pub(crate) fn observe<'a>(&'a mut self, state: &'a WorldState) -> &'a WorldState {
        let Some(seen) = &mut self.seen else {
            return state;
        };
        **seen = *state;
        let tick = state.header.tick;
        let disturbance = &self.disturbance;
        let count = state.objects().len();
        // Streams are derived from seed, object and tick each time. One generator that advanced
        // from decision to decision would have to be in the checkpoint, and would give other
        // numbers after a missed decision.
        for (index, object) in seen.objects.iter_mut().take(count).enumerate() {
            let stream = |time: u64| {
                let of_seed = Random::new(self.seed).bits();
                let of_object = Random::new(of_seed ^ index as u64).bits();
                Random::new(of_object ^ time)
            };
            // No decision has this tick: the offset is the same in all decisions, and
            // independent of the noise.
            let mut offset = stream(u64::MAX);
            // The offset of a position is drawn before that of the yaw: a changed order would
            // change the hash of every run with a disturbance.
            let mut noise = stream(tick);
            let shift = draw(&mut offset, disturbance.position_offset_m)
                + draw(&mut noise, disturbance.position_noise_m);
            let yaw = offset.around_zero(disturbance.yaw_offset_rad)
                + noise.around_zero(disturbance.yaw_noise_rad);
            disturb(&mut object.pose, &shift, yaw);
        }
        seen
    }
}

fn draw(random: &mut Random, half: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.around_zero(half))
}

/// Shifts a pose, and turns it about the z of the world (rad).
fn disturb(pose: &mut Pose, shift: &Vector3<f64>, yaw: f64) {
    pose.position = (Vector3::from(pose.position) + shift).into();
    let [w, x, y, z] = pose.orientation_wxyz;
    let turned = turn_about_z(yaw) * UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    pose.orientation_wxyz = [turned.w, turned.i, turned.j, turned.k];
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_model::Data;
    use cell_model::cells::setting::Setting;

    fn cell(seed: u64, settings: &[&str]) -> Cell {
        let settings: Vec<Setting> = settings.iter().map(|text| text.parse().unwrap()).collect();
        Cell::load_with(&Data::checkout(), "franka-stack", seed, None, &settings).unwrap()
    }

    fn state(tick: u64) -> WorldState {
        let mut state = WorldState::zeroed();
        state.header.tick = tick;
        state.object_count = 4;
        for object in &mut state.objects {
            object.pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
        }
        state
    }

    fn positions(perception: &mut Perception, tick: u64) -> Vec<[f64; 3]> {
        let state = state(tick);
        let seen = perception.observe(&state);
        seen.objects().iter().map(|o| o.pose.position).collect()
    }

    #[test]
    fn without_a_disturbance_the_state_itself_is_seen() {
        let mut perception = Perception::new(&cell(1, &["disturbance.drive_delay_s=0.01"]));
        let state = state(0);
        assert!(std::ptr::eq(perception.observe(&state), &raw const state));
    }

    #[test]
    fn an_offset_is_kept_and_noise_is_drawn_anew_both_within_their_bounds() {
        let offset = cell(1, &["disturbance.position_offset_m=0.01"]);
        let kept = positions(&mut Perception::new(&offset), 10);
        assert_eq!(kept, positions(&mut Perception::new(&offset), 20));
        assert_ne!(kept[0], kept[1]);
        let other = cell(2, &["disturbance.position_offset_m=0.01"]);
        assert_ne!(kept, positions(&mut Perception::new(&other), 10));
        let noise = cell(1, &["disturbance.position_noise_m=0.01"]);
        let (mut one, mut other) = (Perception::new(&noise), Perception::new(&noise));
        let drawn: Vec<_> = (0..100).map(|n| positions(&mut one, 10 * n)).collect();
        assert_ne!(drawn[0], drawn[1]);
        // Independent of earlier observations: a restarted task perceives the same.
        assert_eq!(drawn[99], positions(&mut other, 990));
        let all = || drawn.iter().chain([&kept]).flatten().flatten();
        assert!(all().all(|value| value.abs() <= 0.01));
        assert!(all().any(|value| *value > 0.009) && all().any(|value| *value < -0.009));
    }

    #[test]
    fn objects_are_turned_about_z() {
        let mut perception = Perception::new(&cell(1, &["disturbance.yaw_offset_rad=0.2"]));
        let state = state(0);
        for object in perception.observe(&state).objects() {
            let [w, x, y, z] = object.pose.orientation_wxyz;
            assert!((w * w + z * z - 1.0).abs() < 1e-12 && x == 0.0 && y == 0.0);
            assert!(z != 0.0 && z.abs() <= 0.1, "{z}");
            assert_eq!(object.pose.position, [0.0; 3]);
        }
    }
}
