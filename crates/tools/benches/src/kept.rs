//! The loop of physics in real time, with and without a state of 1 MB that is saved.
//!
//! Without a bus, so that nothing else delays it. Objects are at rest: a tick is short then,
//! and the bytes of a state are the same.

use std::path::Path;

use cell_rt::{Grid, monotonic_ns};
use cell_run::spec::Speed;
use cell_sim::eval::template;
use ipc_types::MAX_ARMS;
use physics_proc::keeper::Keeper;
use physics_proc::plant::Plant;
use physics_proc::world::StepInput;

use crate::error::CoreError;
use crate::fleet::scenes;
use crate::report::Samples;

/// Bins of the scene: a state of about 1 MB.
const BINS: usize = 100;
/// Ticks until the scene is at rest.
const SETTLE_TICKS: u64 = 4000;

/// A scene whose state takes about 1 MB.
pub(crate) struct KeptPhysics {
    plant: Plant,
    keeper: Keeper,
    bytes: usize,
}

impl KeptPhysics {
    /// Sets the scene up and waits until it is at rest. `dir` is on tmpfs.
    pub(crate) fn new(dir: &Path) -> Result<Self, CoreError> {
        let cell = scenes::bins_asleep(BINS)?;
        let mut spec = template(scenes::DEMO, "");
        (spec.speed, spec.until_done) = (Speed::RealTime, false);
        let mut plant = Plant::new(&cell, &spec)?;
        for _ in 0..SETTLE_TICKS {
            tick(&mut plant);
        }
        let bytes = plant.save().len();
        let keeper = Keeper::open(dir, &mut plant);
        Ok(Self {
            plant,
            keeper,
            bytes,
        })
    }

    /// Size of a state.
    pub(crate) fn megabytes(&self) -> f64 {
        self.bytes as f64 * 1.0e-6
    }

    /// A block of ticks on `grid`, without saving.
    pub(crate) fn not_kept(&mut self, grid: &mut Grid, ticks: usize, late: &mut Samples) {
        for _ in 0..ticks {
            late.record(grid.wait().lateness_ns());
            tick(&mut self.plant);
        }
    }

    /// The same with saving; `keeping` is the time that each tick spends on it.
    pub(crate) fn kept(
        &mut self,
        grid: &mut Grid,
        ticks: usize,
        (late, keeping): (&mut Samples, &mut Samples),
    ) {
        for _ in 0..ticks {
            late.record(grid.wait().lateness_ns());
            tick(&mut self.plant);
            // After the tick, where physics does it: a late start
            // of the next tick is its effect.
            let began_ns = monotonic_ns();
            self.keeper.save_if_due(&self.plant);
            keeping.record(monotonic_ns().saturating_sub(began_ns));
        }
    }
}

fn tick(plant: &mut Plant) {
    // Nothing pauses it.
    let _next = plant.before_step(None);
    plant.step(&StepInput {
        commands: [None; MAX_ARMS],
        decision: None,
    });
}
