//! Physics in a model of the cell: the same loop, on virtual time and files in memory.

use cell_bus::Bus;
use cell_rt::priority::PHYSICS_PRIORITY;
use cell_rt::{Clock, MemoryFile};
use cell_worker::{Start, Turn};

use super::{PhysicsProcess, ProcessError};
use crate::plant::Plant;
use crate::resume::{Resume, Store};
use crate::script_report::ScriptReport;

/// The loop of a modelled physics, whose states are in `store` and whose requests are in
/// `requests`. With `is_ideal` nothing has dynamics: joints are where their setpoints are.
///
/// # Errors
///
/// When the scene cannot be set up, or the bus has no such topics.
pub fn model<C: Clock, S: Store>(
    start: &Start,
    bus: &Bus,
    store: S,
    requests: &MemoryFile,
    (clock, is_ideal): (C, bool),
) -> Result<impl Turn + use<C, S>, ProcessError> {
    let mut plant = Plant::new(&start.cell, &start.spec)?;
    if is_ideal {
        plant.make_ideal();
    }
    let was_one = start.generation > 1;
    let resume = Resume::model(store, requests, start.spec.run, was_one, &mut plant);
    let fifo = start.real_time(PHYSICS_PRIORITY, 0);
    let parts = (plant, resume, ScriptReport::none());
    Ok(PhysicsProcess::new(start, bus, parts, fifo, clock)?)
}
