//! Brings bins onto the belt on request.

use cell_model::cells::cell::SupplyTable;
use cell_model::random::Random;
use cell_model::{Cell, ObjectSpec, Shape};
use ipc_types::TICK_NS;
use ipc_types::equipment::SupplyRefusal;
use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use parry3d_f64::bounding_volume::BoundingVolume;
use parry3d_f64::query::intersection_test;
use serde::{Deserialize, Serialize};

use crate::engine::convert;
use crate::engine::settings::ticks;
use crate::engine::shapes;
use crate::engine::simulation::Engine;
use crate::engine::tag::Tag;
use crate::equipment::conveyor::Belt;
use crate::equipment::stream::Stream;
use crate::gripper::grippers::Grippers;

/// Its stream of random numbers.
const DEVICE: u64 = 1;
/// Largest number of open requests; the others are refused.
// More than a belt takes: the others could not be met for long.
const MOST_PENDING: u32 = 64;
/// A bin arrives at most this far above the place of the cell file (m).
// A rounding error and the way of a few ticks.
const ARRIVAL_M: f64 = 1.0e-3;

/// A supply of bins.
pub(crate) struct Supply {
    table: SupplyTable,
    /// Objects that it may bring, in this order.
    objects: Vec<usize>,
}

/// The cell around a supply.
pub(crate) struct Surroundings<'c> {
    pub(super) engine: &'c mut Engine,
    pub(super) grippers: &'c Grippers,
    /// The belt, where there is one.
    pub(super) belt: Option<&'c Belt>,
    /// Random numbers of the equipment.
    pub(super) stream: Stream,
    pub(super) tick: u64,
}

/// State of a supply: part of every snapshot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct SupplyState {
    /// Bins that the task requested and that were not brought yet.
    pending: u32,
    /// No bin is brought before this tick.
    free_at: u64,
    pub(super) supplied: u32,
    pub(super) refusals: u32,
    pub(super) refusal: u32,
}

impl SupplyState {
    /// Adds requests of the task; requests beyond [`MOST_PENDING`] are refused.
    pub(super) fn request(&mut self, count: u32) {
        let all = self.pending.saturating_add(count);
        self.pending = all.min(MOST_PENDING);
        for _ in self.pending..all {
            self.refuse(SupplyRefusal::TooManyWaiting);
        }
    }

    fn refuse(&mut self, why: SupplyRefusal) {
        self.refusals = self.refusals.wrapping_add(1);
        self.refusal = why.code();
    }
}

impl Supply {
    /// The supply of a cell, with as many bins as the job needs.
    pub(super) fn new(table: &SupplyTable, cell: &Cell) -> Self {
        let bins = cell.objects.iter().enumerate();
        let spare: Vec<usize> = bins
            .filter(|(_, object)| object.is_bin())
            .map(|(index, _)| index)
            .skip(cell.bins)
            .collect();
        let objects = cell.objects.iter().enumerate();
        let brought = objects.filter(|(index, object)| {
            object.kind == table.objects && object.parked && !spare.contains(index)
        });
        Self {
            table: table.clone(),
            objects: brought.map(|(index, _)| index).collect(),
        }
    }

    /// Brings a requested bin as soon as possible.
    pub(super) fn before_step(&self, state: &mut SupplyState, cell: &mut Surroundings<'_>) {
        if state.pending == 0 {
            return;
        }
        match self.bring(state, cell, false) {
            Ok(()) => state.pending -= 1,
            // A request that can never be met is dropped, or it would block the ones after it.
            Err(why @ SupplyRefusal::NoneLeft) => {
                state.pending -= 1;
                state.refuse(why);
            }
            // All other reasons pass: the request is kept and tried in the next tick.
            Err(_) => {}
        }
    }

    /// Brings a bin for the operator in this tick.
    ///
    /// # Errors
    /// The reason if no bin can be brought.
    pub(super) fn add(
        &self,
        state: &mut SupplyState,
        cell: &mut Surroundings<'_>,
        flipped: bool,
    ) -> Result<(), SupplyRefusal> {
        let brought = self.bring(state, cell, flipped);
        if let Err(why) = brought {
            state.refuse(why);
        }
        brought
    }

    /// The sentence for a refused request of the operator, with the time of the next try.
    pub(super) fn refusal(&self, why: SupplyRefusal, state: &SupplyState, tick: u64) -> String {
        match why {
            SupplyRefusal::NoneLeft => "every bin is in the cell".to_owned(),
            SupplyRefusal::TooManyWaiting => {
                let most = self.table.max_waiting;
                format!(
                    "{most} bins wait on the belt, which is all it takes; ask again when one was picked"
                )
            }
            SupplyRefusal::CoolDown => {
                let seconds = |ticks: u64| (ticks * TICK_NS) as f64 * 1.0e-9;
                let (at, left) = (state.free_at, state.free_at.saturating_sub(tick));
                format!(
                    "the last bin arrived a moment ago; the next can be added at {:.3} s, in {:.3} s",
                    seconds(at),
                    seconds(left)
                )
            }
            SupplyRefusal::PlaceTaken | SupplyRefusal::None => {
                "an arm or an object occupies the place of the bin; ask again when it has moved"
                    .to_owned()
            }
        }
    }

    fn bring(
        &self,
        state: &mut SupplyState,
        cell: &mut Surroundings<'_>,
        flipped: bool,
    ) -> Result<(), SupplyRefusal> {
        let mut left = self.objects.iter().filter(|o| !cell.engine.is_here(**o));
        let object = *left.next().ok_or(SupplyRefusal::NoneLeft)?;
        let spec = cell.engine.specs().get(object);
        let spec = spec.ok_or(SupplyRefusal::NoneLeft)?;
        // Checked in order of cost; the last one compares shapes with all colliders.
        if cell.tick < state.free_at {
            return Err(SupplyRefusal::CoolDown);
        }
        if self.waiting_bins(cell) >= self.table.max_waiting as usize {
            return Err(SupplyRefusal::TooManyWaiting);
        }
        // By the number of the object, not by the tick: a bin arrives alike whenever it is
        // requested.
        let mut random = cell.stream.random(DEVICE, object as u64);
        let pose = self.arrival(&mut random, spec, flipped);
        if is_occupied(cell.engine, spec, &pose) {
            return Err(SupplyRefusal::PlaceTaken);
        }
        let velocity = Vector3::from(self.table.velocity_m_s);
        cell.engine
            .bring(object, &pose, &velocity, &Vector3::zeros());
        state.free_at = cell.tick + ticks(self.table.cool_down_s);
        state.supplied = state.supplied.wrapping_add(1);
        Ok(())
    }

    /// Number of bins on the belt, and on their way down to it.
    fn waiting_bins(&self, cell: &Surroundings<'_>) -> usize {
        let (Some(belt), engine) = (cell.belt, &*cell.engine) else {
            return 0;
        };
        let touching = belt.touching(engine);
        // A bin that is higher than one that arrives is on something else, above the belt.
        let highest = belt.height_of(&Vector3::from(self.table.position_m)) + ARRIVAL_M;
        let waits = |object: &&usize| {
            let pose = engine.object_pose(**object);
            let falls = pose.is_some_and(|pose| belt.is_below(&pose.translation.vector, highest));
            engine.is_here(**object)
                && !cell.grippers.is_attached(**object)
                && (falls || touching.binary_search(object).is_ok())
        };
        self.objects.iter().filter(waits).count()
    }

    /// Pose of a bin on arrival: equal for equal seeds, at any time.
    fn arrival(&self, random: &mut Random, spec: &ObjectSpec, flipped: bool) -> Isometry3<f64> {
        let table = &self.table;
        let x = random.around_zero(table.spawn.x_m);
        let y = random.around_zero(table.spawn.y_m);
        let yaw = 0.5 * (table.yaw_rad + random.around_zero(table.spawn.yaw_rad));
        let by_seed = 0.5 * (random.around_zero(1.0) + 1.0) < table.flipped_share;
        let turn = Quaternion::new(libm::cos(yaw), 0.0, 0.0, libm::sin(yaw));
        let over = if flipped || by_seed {
            upside_down(&spec.shape)
        } else {
            UnitQuaternion::identity()
        };
        let place = Vector3::from(table.position_m) + Vector3::new(x, y, 0.0);
        Isometry3::from_parts(Translation3::from(place), Unit::new_unchecked(turn) * over)
    }
}

/// Whether the place of arrival is occupied by an arm or another object.
fn is_occupied(engine: &Engine, spec: &ObjectSpec, pose: &Isometry3<f64>) -> bool {
    // A bin is checked as a full box: another one could otherwise arrive inside of it.
    let outside = match spec.shape {
        Shape::Bin { size_m, .. } => Shape::Box { size_m },
        ref other => other.clone(),
    };
    let (shape, own) = shapes::shared(&outside);
    let pose = convert::to_pose(&(pose * own));
    let bounds = shape.compute_aabb(&pose);
    let rapier = engine.rapier();
    let mut colliders = rapier.colliders.iter();
    colliders.any(|(_, collider)| {
        let body = collider.parent().and_then(|b| rapier.bodies.get(b));
        let Some(body) = body.filter(|body| body.is_enabled()) else {
            return false;
        };
        // A body that was brought since the last step has not moved its colliders yet, so
        // poses are computed from bodies.
        let own = collider.position_wrt_parent().copied().unwrap_or_default();
        let there = *body.position() * own;
        let other = collider.shape();
        let meets = || intersection_test(&pose, &*shape, &there, other);
        !matches!(Tag::decode(collider.user_data), Tag::Fixture(_))
            && other.compute_aabb(&there).intersects(&bounds)
            && meets().is_ok_and(|meeting| meeting.intersecting)
    })
}

/// Half a turn about the longer of the horizontal axes.
fn upside_down(shape: &Shape) -> UnitQuaternion<f64> {
    let along_y = match *shape {
        Shape::Bin {
            size_m: [x, y, _], ..
        }
        | Shape::Box { size_m: [x, y, _] } => y > x,
        _ => false,
    };
    let (x, y) = if along_y { (0.0, 1.0) } else { (1.0, 0.0) };
    Unit::new_unchecked(Quaternion::new(0.0, x, y, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_beyond_what_can_wait_are_counted_as_refused() {
        let mut state = SupplyState::default();
        state.request(MOST_PENDING - 1);
        assert_eq!(state.refusals, 0);
        state.request(3);
        assert_eq!((state.pending, state.refusals), (MOST_PENDING, 2));
        assert_eq!(state.refusal, SupplyRefusal::TooManyWaiting.code());
    }
}
