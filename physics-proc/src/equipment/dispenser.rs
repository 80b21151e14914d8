//! The dispenser: drops parts, some at a time, in any orientation.

use cell_model::Cell;
use cell_model::cells::cell::DispenserTable;
use cell_model::random::Random;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::engine::settings::ticks;
use crate::engine::simulation::Engine;
use crate::equipment::stream::Stream;

/// Its stream of random numbers.
const DEVICE: u64 = 2;
/// Largest spin of a part about each axis (rad/s).
// In a fall of half a metre this turns a part by about one radian.
const SPIN_RAD_S: f64 = 3.0;
/// Parts waiting at most.
// More parts than a cell has objects.
const MOST_WAITING: u32 = 1_000;

/// A dispenser of parts.
pub(crate) struct Dispenser {
    pub(super) table: DispenserTable,
    /// Objects that it may drop.
    objects: Vec<usize>,
}

/// State of a dispenser: part of every snapshot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct DispenserState {
    /// Parts requested and not yet dropped.
    pub(super) waiting: u32,
    /// No part is dropped before this tick.
    free_at: u64,
    /// Parts dropped since the start of the scene: the position in the stream of random
    /// numbers.
    drawn: u64,
    pub(super) dropped: u32,
}

impl DispenserState {
    /// Requests parts; those beyond the limit are dropped.
    pub(super) fn request(&mut self, parts: u32) {
        self.waiting = self.waiting.saturating_add(parts).min(MOST_WAITING);
    }
}

impl Dispenser {
    /// The dispenser of a cell.
    pub(super) fn new(table: &DispenserTable, cell: &Cell) -> Self {
        let objects = cell.objects.iter().enumerate();
        let parts = objects.filter(|(_, object)| object.kind == table.objects && object.parked);
        Self {
            table: table.clone(),
            objects: parts.map(|(index, _)| index).collect(),
        }
    }

    /// Parts that are neither in the cell nor on their way.
    pub(super) fn parts_left(&self, state: &DispenserState, engine: &Engine) -> u32 {
        let left = u32::try_from(self.parked_parts(engine).len()).unwrap_or(u32::MAX);
        left.saturating_sub(state.waiting)
    }

    fn parked_parts(&self, engine: &Engine) -> Vec<usize> {
        let parts = self.objects.iter().copied();
        parts.filter(|part| !engine.is_here(*part)).collect()
    }

    /// Drops the next parts when they are due.
    pub(super) fn before_step(
        &self,
        state: &mut DispenserState,
        engine: &mut Engine,
        tick: u64,
        stream: Stream,
    ) {
        if state.waiting == 0 || tick < state.free_at {
            return;
        }
        state.free_at = tick + ticks(self.table.interval_s);
        for layer in 0..state.waiting.min(self.table.per_drop) {
            let parked = self.parked_parts(engine);
            if parked.is_empty() {
                // All parts are in the cell: open requests can never be met.
                state.waiting = 0;
                return;
            }
            // Each part has a generator by its number: parts do not depend on the ticks of the
            // requests.
            let mut random = stream.random(DEVICE, state.drawn);
            state.drawn += 1;
            state.waiting -= 1;
            state.dropped = state.dropped.wrapping_add(1);
            let place = usize::try_from(random.bits() % parked.len() as u64).unwrap_or(0);
            let Some(&part) = parked.get(place) else {
                return;
            };
            let (pose, spin) = fall(&self.table, layer, &mut random);
            engine.bring(part, &pose, &Vector3::zeros(), &spin);
        }
    }
}

/// Initial pose and spin (rad/s) of a part.
fn fall(table: &DispenserTable, layer: u32, random: &mut Random) -> (Isometry3<f64>, Vector3<f64>) {
    let [x, y] = table.spread_m.map(|half| random.around_zero(half));
    let above = table.layer_m * f64::from(layer);
    let place = Vector3::from(table.position_m) + Vector3::new(x, y, above);
    let spin: [f64; 3] = std::array::from_fn(|_| random.around_zero(SPIN_RAD_S));
    (
        Isometry3::from_parts(Translation3::from(place), any_orientation(random)),
        Vector3::from(spin),
    )
}

/// Uniform over all orientations: a random point of the unit ball in four dimensions, not near
/// its centre, projected to the sphere.
fn any_orientation(random: &mut Random) -> UnitQuaternion<f64> {
    loop {
        let [w, x, y, z] = std::array::from_fn(|_| random.around_zero(1.0));
        let quaternion = Quaternion::new(w, x, y, z);
        if (0.01..=1.0).contains(&quaternion.norm_squared()) {
            return UnitQuaternion::new_normalize(quaternion);
        }
    }
}
