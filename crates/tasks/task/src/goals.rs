//! The slots of a job, by which it is judged from the observation alone: for policies that do
//! not know the job themselves.

use ipc_types::world::OBJECT_ENABLED;

use crate::observation::Observation;

/// An object that moves faster has not been put down (m/s).
const AT_REST_M_S: f64 = 0.05;

/// Slots that are filled in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Slots {
    /// Centre of the object in each slot, world frame (m).
    pub centres: Vec<[f64; 3]>,
    /// By slot: index of the object that belongs there; `None` for any object.
    pub objects: Option<Vec<usize>>,
    /// Distance in the plane, and in height, within which an object is in its slot (m).
    pub tolerance_m: [f64; 2],
}

/// All slots of a job.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Goals(pub Vec<Slots>);

impl Goals {
    /// The centres of all slots, world frame (m).
    pub fn centres(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.0
            .iter()
            .flat_map(|slots| slots.centres.iter().copied())
    }

    /// Appends the objects that are in place: at rest, in their slots, with all slots before
    /// them filled.
    pub fn placed(&self, observation: &Observation<'_>, out: &mut Vec<u32>) {
        for slots in &self.0 {
            let found = (0..slots.centres.len()).map_while(|slot| slots.filled(slot, observation));
            out.extend(found.filter_map(|object| u32::try_from(object).ok()));
        }
    }

    /// Number of slots.
    pub fn count(&self) -> usize {
        self.centres().count()
    }
}

impl Slots {
    /// The object in a slot.
    fn filled(&self, slot: usize, observation: &Observation<'_>) -> Option<usize> {
        let all = 0..observation.state().objects().len();
        let belongs = |object: &usize| match &self.objects {
            Some(objects) => objects.get(slot) == Some(object),
            None => true,
        };
        let mut objects = all.filter(belongs);
        objects.find(|object| self.is_in(slot, *object, observation))
    }

    fn is_in(&self, slot: usize, object: usize, observation: &Observation<'_>) -> bool {
        let (Some(state), Some(centre)) = (observation.object(object), self.centres.get(slot))
        else {
            return false;
        };
        let [x, y, z] = std::array::from_fn(|axis| state.pose.position[axis] - centre[axis]);
        let [plane_m, height_m] = self.tolerance_m;
        let speed = state
            .twist
            .linear
            .iter()
            .map(|part| part * part)
            .sum::<f64>();
        let arms = 0..observation.state().arms().len();
        let is_held = arms
            .into_iter()
            .any(|arm| observation.held_object(arm) == Some(object));
        state.flags & OBJECT_ENABLED != 0
            && x.hypot(y) <= plane_m
            && z.abs() <= height_m
            && speed.sqrt() < AT_REST_M_S
            && !is_held
    }
}
