//! The loop of physics in real time, with and without a state of 1 MB that is kept.
//!
//! Without a bus, so that nothing else makes it late. Objects are at rest: a tick is short
//! then, and the bytes of a state are the same.

use std::path::Path;

use cell_model::runs::spec::Speed;
use cell_rt::{Grid, monotonic_ns};
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
/// Ticks until they are at rest.
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

    /// So many ticks on a grid of `period_ns`; how late each one started.
    pub(crate) fn block(
        &mut self,
        samples: &mut Samples,
        (ticks, period_ns): (usize, u64),
        fifo: bool,
        keeps: bool,
    ) {
        let mut grid = Grid::new(period_ns, monotonic_ns(), fifo);
        for _ in 0..ticks {
            samples.record(grid.wait().lateness_ns());
            tick(&mut self.plant);
            if keeps {
                self.keeper.turn(&self.plant);
            }
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
