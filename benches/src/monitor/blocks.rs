//! Blocks of a running cell in turns, without and with a disturbance.

use ipc_types::Health;

use crate::report::{Report, Row};

const SECOND_NS: u64 = 1_000_000_000;
/// Health has figures of the last second; a block has to be longer.
const BLOCK_NS: u64 = 2 * SECOND_NS;
/// Pairs of blocks, without and with the disturbance.
const PAIRS: usize = 10;

/// Lateness of a controller in the blocks of both kinds.
#[derive(Default)]
pub(super) struct Blocks {
    /// p99 (us) of each block.
    lateness_us: [Vec<f64>; 2],
    /// Missed cycles.
    pub(super) missed: [u64; 2],
    count: usize,
    began: Option<(u64, u64)>,
}

impl Blocks {
    /// Evaluates the controller's health; returns whether the present block is a disturbed one;
    /// `None` after the last one.
    pub(super) fn turn(&mut self, now: u64, health: &Health) -> Option<bool> {
        let (began_ns, missed_before) = *self.began.get_or_insert((now, health.missed_cycles));
        // Alternating: both kinds meet the same minutes of the machine.
        let kind = self.count % 2;
        if now - began_ns < BLOCK_NS {
            return Some(kind == 1);
        }
        self.lateness_us[kind].push(health.lateness_p99_ns * 1.0e-3);
        self.missed[kind] += health.missed_cycles.saturating_sub(missed_before);
        self.count += 1;
        self.began = Some((now, health.missed_cycles));
        (self.count < 2 * PAIRS).then_some(kind == 0)
    }

    /// Rows for both kinds, and their ratio.
    pub(super) fn report(self, report: &mut Report, names: [&str; 2]) {
        for (name, figures) in names.into_iter().zip(self.lateness_us) {
            report.rows.push(median_row(name, figures));
        }
        report.compare(names[1], names[0]);
    }
}

/// The blocks' figures: median, and the worst for all the others.
fn median_row(name: &str, mut figures: Vec<f64>) -> Row {
    figures.sort_by(f64::total_cmp);
    let median = figures.get(figures.len() / 2).copied().unwrap_or(0.0);
    let worst = figures.last().copied().unwrap_or(0.0);
    Row::new(
        name.to_owned(),
        figures.len(),
        [median, worst, worst, worst],
    )
}
