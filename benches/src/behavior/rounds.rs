//! All subjects in turns.

use crate::report::Row;
use cell_rt::{alloc, monotonic_ns};

use super::subject::Subject;

/// Repetitions of the work for one sample: several jobs of a tree.
pub(crate) const TIMES: u64 = 1_000;
/// Suffix of the rows that count allocations.
pub(crate) const ALLOCATIONS: &str = ", allocations";
/// Samples of each row.
const ROUNDS: usize = 501;
/// Rounds before the first sample: caches fill, lists grow.
const WARM_UP: usize = 20;

/// Time of each subject's work (ns).
pub(crate) fn times(all: &mut [Subject]) -> Vec<Row> {
    let mut samples = vec![Vec::with_capacity(ROUNDS); all.len()];
    for round in 0..WARM_UP + ROUNDS {
        for (subject, samples) in all.iter_mut().zip(&mut samples) {
            let began_ns = monotonic_ns();
            (subject.work)(TIMES);
            let took_ns = monotonic_ns().saturating_sub(began_ns);
            if round >= WARM_UP {
                samples.push(took_ns as f64 / TIMES as f64);
            }
        }
    }
    let rows = all.iter().zip(samples);
    rows.map(|(subject, samples)| row(subject.name, samples))
        .collect()
}

/// The row of samples (ns).
pub(super) fn row(name: &str, mut samples: Vec<f64>) -> Row {
    samples.sort_unstable_by(f64::total_cmp);
    let at = |permille: usize| {
        let rank = (samples.len() * permille).div_ceil(1000).max(1) - 1;
        samples.get(rank).copied().unwrap_or(0.0)
    };
    let figures = [at(500), at(990), at(999), at(1000)];
    Row::new(name.to_owned(), samples.len(), figures).in_unit("ns")
}

/// Allocations per repetition of the work, after the warm-up.
pub(crate) fn allocations(all: &mut [Subject]) -> Vec<Row> {
    let count = |subject: &mut Subject| {
        let before = alloc::count();
        (subject.work)(TIMES);
        let taken = (alloc::count() - before) as f64 / TIMES as f64;
        let name = format!("{}{ALLOCATIONS}", subject.name);
        Row::new(name, 1, [taken; 4]).in_unit("allocations")
    };
    all.iter_mut().map(count).collect()
}
