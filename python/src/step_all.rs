//! Several cells advance at once.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use pyo3::prelude::*;

use crate::sim::Sim;

/// Advances cells on several threads, each as by [`Sim::step`]; the ticks of each.
#[pyfunction]
#[pyo3(signature = (cells, ticks, threads=None))]
pub(crate) fn step_all(
    py: Python<'_>,
    cells: Vec<Py<Sim>>,
    ticks: u64,
    threads: Option<usize>,
) -> PyResult<Vec<u64>> {
    let cores = || thread::available_parallelism().map_or(1, NonZero::get);
    let threads = threads.unwrap_or_else(cores).clamp(1, cells.len().max(1));
    let done: Vec<Mutex<PyResult<u64>>> = cells.iter().map(|_| Mutex::new(Ok(0))).collect();
    py.detach(|| {
        let next = AtomicUsize::new(0);
        let work = || {
            while let Some((cell, slot)) = {
                let i = next.fetch_add(1, Ordering::Relaxed);
                cells.get(i).zip(done.get(i))
            } {
                *slot.lock().unwrap_or_else(PoisonError::into_inner) = cell.get().advance(ticks);
            }
        };
        thread::scope(|scope| {
            (1..threads).for_each(|_| drop(scope.spawn(work)));
            work();
        });
    });
    let shown = cells.iter().try_for_each(|cell| cell.get().show(py));
    let done = done.into_iter();
    let done = done.map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner));
    let done: PyResult<Vec<u64>> = done.collect();
    shown.and(done)
}
