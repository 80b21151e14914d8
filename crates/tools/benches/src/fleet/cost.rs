//! The tick over the size of a cell: obstacles, objects, bins, arms.

use cell_model::{Cell, ModelError};
use cell_rt::monotonic_ns;
use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::{DECISION_TICKS, MAX_ARMS};
use physics_proc::world::{StepInput, World};

use super::fit;
use super::scenes::{self, DEMO};
use crate::error::FleetError;
use crate::report::{Report, Row, Samples};

/// A cost with a larger exponent is reported with its reason.
// Above 1 by the error of a fit over noisy medians.
const LINEAR: f64 = 1.15;
/// Blocks of each size before the turn of the next one: a slow minute of the machine affects
/// all.
const BLOCKS: usize = 5;
/// Blocks of each size in a second of `--seconds`.
const BLOCKS_PER_SECOND: f64 = 40.0;
/// Length of the bench at which everything is at rest before it is measured (s).
const FULL_S: f64 = 5.0;

/// Reason of an axis that is linear on an idle machine.
const UNKNOWN: &str = "No reason is known: measure again when the machine is idle";

/// A size that grows.
struct Axis {
    name: &'static str,
    sizes: &'static [usize],
    scene: fn(usize) -> Result<Cell, ModelError>,
    /// Ticks until it is at rest.
    settle_ticks: f64,
    /// Reason if its exponent is above [`LINEAR`].
    reason: &'static str,
}

/// All axes; each has the size 0, from which the growth is counted.
const AXES: [Axis; 5] = [
    Axis {
        name: "obstacles",
        sizes: &[0, 8, 16, 32, 48, 64],
        scene: scenes::obstacles,
        settle_ticks: 100.0,
        reason: UNKNOWN,
    },
    Axis {
        name: "objects on the floor",
        sizes: &[0, 1, 10, 25, 50, 100, 150],
        scene: scenes::cubes,
        settle_ticks: 1500.0,
        reason: UNKNOWN,
    },
    Axis {
        name: "objects in a pile",
        sizes: &[0, 10, 25, 50, 100, 150],
        scene: scenes::pile,
        settle_ticks: 2500.0,
        reason: "The engine tracks every pair within 1 cm, which are many pairs of a pile \
                 of small parts, and the higher the pile, the more contacts a part has",
    },
    Axis {
        name: "bins, asleep",
        sizes: &[0, 1, 4, 8, 16, 36],
        scene: scenes::bins_asleep,
        settle_ticks: 4000.0,
        reason: UNKNOWN,
    },
    Axis {
        name: "arms",
        sizes: &[0, 1, MAX_ARMS],
        scene: scenes::arms,
        settle_ticks: 100.0,
        reason: "Each arm keeps away from every other one",
    },
];

/// The part that ticks.
enum Ticks {
    /// A whole cell.
    Cell(Box<OneProcess>),
    /// Physics alone: a cell without an arm has no task.
    Physics(Box<World>),
}

/// A cell of one size.
struct Sized {
    size: usize,
    ticks: Ticks,
    samples: Samples,
}

/// Adds the rows of all axes.
pub(super) fn run(report: &mut Report, seconds: f64) -> Result<(), FleetError> {
    for axis in &AXES {
        let rows = measure(axis, seconds)?;
        let costs: Vec<(usize, f64)> = rows.iter().map(|(size, row)| (*size, row.p50)).collect();
        report.rows.extend(rows.into_iter().map(|(_, row)| row));
        let Some((exponent, sizes)) = fit::exponent(&costs) else {
            let name = axis.name;
            let percent = 100.0 * fit::LEAST_GROWTH;
            let note =
                format!("{name}: no exponent; two sizes do not cost {percent:.0} % more than 0");
            report.notes.push(note);
            continue;
        };
        let name = format!("{}: exponent", axis.name);
        let row = Row::new(name, sizes, [exponent; 4]).in_unit("exponent");
        report.rows.push(row);
        if exponent > LINEAR {
            let note = format!("{}: more than linear. {}", axis.name, axis.reason);
            report.notes.push(note);
        }
    }
    Ok(())
}

/// The row of each size.
fn measure(axis: &Axis, seconds: f64) -> Result<Vec<(usize, Row)>, FleetError> {
    let share = (seconds / FULL_S).min(1.0);
    let settle_blocks = blocks(share * axis.settle_ticks / DECISION_TICKS as f64);
    let rounds = blocks(seconds * BLOCKS_PER_SECOND / BLOCKS as f64);
    let mut all = Vec::new();
    for size in axis.sizes {
        let mut one = Sized {
            size: *size,
            ticks: cell(axis, *size)?,
            samples: Samples::with_capacity(rounds * BLOCKS),
        };
        // Settled and measured by the same code, so caches are warm; those samples are dropped.
        one.blocks(settle_blocks)?;
        one.samples = Samples::with_capacity(rounds * BLOCKS);
        all.push(one);
    }
    // All sizes in each round: the exponent compares them with each other.
    for _ in 0..rounds {
        for one in &mut all {
            one.blocks(BLOCKS)?;
        }
    }
    let rows = all.into_iter().map(|one| {
        let row = one.samples.into_row(format!("{}: {}", axis.name, one.size));
        (one.size, row)
    });
    Ok(rows.collect())
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the command line allows up to 1e6 s"
)]
fn blocks(count: f64) -> usize {
    count.max(1.0) as usize
}

fn cell(axis: &Axis, size: usize) -> Result<Ticks, FleetError> {
    let cell = (axis.scene)(size)?;
    if cell.arms.is_empty() {
        return Ok(Ticks::Physics(Box::new(World::new(&cell)?)));
    }
    let mut spec = template(DEMO, "");
    spec.policy.clone_from(&cell.default_policy);
    let sim = OneProcess::new(&demos::policies(), &spec, cell)?;
    Ok(Ticks::Cell(Box::new(sim)))
}

impl Ticks {
    /// One tick; false at the end of the run.
    fn tick(&mut self) -> Result<bool, FleetError> {
        match self {
            Self::Cell(sim) => Ok(sim.tick()?),
            Self::Physics(world) => {
                world.step(&StepInput::default());
                Ok(true)
            }
        }
    }
}

impl Sized {
    /// Runs `count` blocks of ticks, each with one decision; a sample is the mean tick of a
    /// block.
    fn blocks(&mut self, count: usize) -> Result<(), FleetError> {
        for _ in 0..count {
            let began_ns = monotonic_ns();
            for _ in 0..DECISION_TICKS {
                self.ticks.tick()?;
            }
            let block_ns = monotonic_ns().saturating_sub(began_ns);
            self.samples.record(block_ns / DECISION_TICKS);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_size_0_and_cells_of_its_largest_size_run() {
        for axis in &AXES {
            assert_eq!(axis.sizes.first(), Some(&0), "{}", axis.name);
            let largest = axis.sizes.last().copied().unwrap();
            for size in [0, largest] {
                let mut ticks = cell(axis, size).unwrap();
                assert!(ticks.tick().unwrap(), "{}: {size}", axis.name);
                assert!(ticks.tick().unwrap(), "{}: {size}", axis.name);
            }
        }
    }
}
