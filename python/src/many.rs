//! Several cells at once, on several threads.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use camera::Picture;
use numpy::{PyArray1, PyArray4, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::sim::Sim;

/// Advances cells, each as by [`Sim::step`]; the ticks of each.
#[pyfunction]
#[pyo3(signature = (cells, ticks, threads=None))]
pub(crate) fn step_all(
    py: Python<'_>,
    cells: Vec<Py<Sim>>,
    ticks: u64,
    threads: Option<usize>,
) -> PyResult<Vec<u64>> {
    // Policies in Python attach to the interpreter in the threads; held here, it would block them
    // for ever.
    let done = py.detach(|| each(&cells, threads, |cell| cell.get().advance(ticks)));
    // Before the errors: after one of them the other cells have advanced as well.
    let shown = cells.iter().try_for_each(|cell| cell.get().show(py));
    let done: PyResult<Vec<u64>> = done.into_iter().collect();
    shown.and(done)
}

/// Colour of the cameras of all cells: for each camera an array of cells x height x width x 3.
#[pyfunction]
#[pyo3(signature = (cells, cameras, threads=None))]
pub(crate) fn observe_all(
    py: Python<'_>,
    cells: Vec<Py<Sim>>,
    cameras: Vec<String>,
    threads: Option<usize>,
) -> PyResult<Vec<Bound<'_, PyArray4<u8>>>> {
    let seen = py.detach(|| each(&cells, threads, |cell| cell.get().pictures(&cameras)));
    let seen: Result<Vec<Vec<Picture>>, String> = seen.into_iter().collect();
    let seen = seen.map_err(PyValueError::new_err)?;
    let array = |camera: usize| {
        let pictures = seen.iter().filter_map(|pictures| pictures.get(camera));
        let size = pictures.clone().next().map_or([0, 0], |picture| {
            [picture.height, picture.width].map(|count| count as usize)
        });
        let bytes: Vec<u8> = pictures
            .flat_map(|picture| picture.rgb.iter().copied())
            .collect();
        PyArray1::from_vec(py, bytes).reshape([seen.len(), size[0], size[1], 3])
    };
    (0..cameras.len()).map(array).collect()
}

/// The result of `work` for each cell; by default one thread for each core.
fn each<T: Send>(
    cells: &[Py<Sim>],
    threads: Option<usize>,
    work: impl Fn(&Py<Sim>) -> T + Sync,
) -> Vec<T> {
    let cores = || thread::available_parallelism().map_or(1, NonZero::get);
    let threads = threads.unwrap_or_else(cores).clamp(1, cells.len().max(1));
    let done: Vec<Mutex<Option<T>>> = cells.iter().map(|_| Mutex::new(None)).collect();
    let next = AtomicUsize::new(0);
    let take = || {
        while let Some((cell, slot)) = {
            // Relaxed: the slots have locks of their own, and only the number is shared.
            let i = next.fetch_add(1, Ordering::Relaxed);
            cells.get(i).zip(done.get(i))
        } {
            *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(work(cell));
        }
    };
    thread::scope(|scope| {
        (1..threads).for_each(|_| drop(scope.spawn(take)));
        take();
    });
    // Every slot was filled: a thread that panics ends the scope with its panic.
    let done = done.into_iter();
    done.filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner))
        .collect()
}
