//! Pallet and columns: every bin in its place, the right way up, at rest for ten more seconds,
//! turned over only if it arrived the wrong way up.

use std::ops::RangeInclusive;

use cell_model::TaskTable;
use demos::bin_stack::numbers::BinStackTask;
use demos::palletize::numbers::PalletizeTask;
use ipc_types::ObjectState;
use ipc_types::decision::Outcome;
use ipc_types::world::OBJECT_ENABLED;
use nalgebra::Vector3;

use crate::watched::{Watched, up};

/// How long all has to rest after the job (ticks).
const REST_TICKS: u64 = 10_000;
/// A bin is in its slot up to this (m).
const IN_SLOT_M: f64 = 0.02;
/// A bin that moved further in that time did not rest (m).
const AT_REST_M: f64 = 1.0e-3;

struct Series {
    run: Watched,
    flips: usize,
    came_upside_down: Vec<Option<bool>>,
}

/// Runs every seed; whether all were good.
pub(crate) fn series(demo: &str, seeds: RangeInclusive<u64>) -> bool {
    let (mut good, mut all) = (0, 0);
    for seed in seeds {
        let (is_good, line) = one(demo, seed);
        println!(
            "{} seed {seed}: {line}",
            if is_good { "ok " } else { "BAD" }
        );
        good += u32::from(is_good);
        all += 1;
    }
    println!("{demo}: {good} of {all} seeds good");
    good == all
}

fn one(demo: &str, seed: u64) -> (bool, String) {
    // The pallet is built with bins that open up, the columns with bins that open
    // down.
    let (policy, right, flips_when) = match demo {
        "ur10-palletize" => ("table", 1.0, true),
        _ => ("matrix", -1.0, false),
    };
    let run = Watched::new(demo, policy, seed);
    let came_upside_down = vec![None; run.bins];
    let mut series = Series {
        run,
        flips: 0,
        came_upside_down,
    };
    while series.run.outcome() != Some(Outcome::Done) && series.tick() {}
    let done_s = series.run.now_s();
    let drift = series.drift();
    let lies = series.came_upside_down.iter();
    let wanted = lies.filter(|lie| **lie == Some(flips_when)).count();
    let Series { run, flips, .. } = series;
    let objects = run.sim.state().objects();
    let upright = objects.iter().take(run.bins).all(|b| up(b) * right > 0.999);
    let off = off_place(&run.task, run.bins, objects);
    let decision = run.sim.decision();
    let good = run.outcome() == Some(Outcome::Done)
        && decision.placed_count as usize == run.bins
        && upright
        && flips == wanted
        && off < IN_SLOT_M
        && drift < AT_REST_M
        && run.violations() == 0
        && !run.touches.any();
    let line = format!(
        "{:?} at {done_s:.1} s, {} of {} placed, at most {:.2} mm off, right way up {upright}, {flips} flips of {wanted}, drift {:.4} mm in 10 s, drops {}, recoveries {}, {} violations, {}",
        run.outcome(),
        decision.placed_count,
        run.bins,
        off * 1.0e3,
        drift * 1.0e3,
        decision.drops,
        decision.recoveries,
        run.violations(),
        run.touches
    );
    (good, line)
}

impl Series {
    fn tick(&mut self) -> bool {
        let flips = &mut self.flips;
        let goes_on = self.run.tick(|line| {
            let flip = line.contains("<flip>") || line.contains("[decide] -> flip");
            *flips += usize::from(flip);
        });
        let objects = self.run.sim.state().objects().iter();
        for (lie, object) in self.came_upside_down.iter_mut().zip(objects) {
            if lie.is_none() && object.flags & OBJECT_ENABLED != 0 {
                *lie = Some(up(object) < 0.0);
            }
        }
        goes_on
    }

    /// How far any bin moves while all should rest (m).
    fn drift(&mut self) -> f64 {
        let place = |object: &ObjectState| Vector3::from(object.pose.position);
        let objects = self.run.sim.state().objects();
        let before: Vec<_> = objects.iter().take(self.run.bins).map(place).collect();
        for _ in 0..REST_TICKS {
            if !self.tick() {
                break;
            }
        }
        let now = self.run.sim.state().objects().iter().map(place);
        let moved = now.zip(before).map(|(now, before)| (now - before).norm());
        moved.fold(0.0, f64::max)
    }
}

/// How far the worst bin is from its place (m): infinite where two are in one.
fn off_place(task: &TaskTable, bins: usize, objects: &[ObjectState]) -> f64 {
    let mut places = places(task);
    places.truncate(bins);
    let mut worst = 0.0_f64;
    for object in objects.iter().take(bins) {
        let at = Vector3::from(object.pose.position);
        let off = |place: &Vector3<f64>| (at - place).norm();
        let nearest =
            (0..places.len()).min_by(|a, b| off(&places[*a]).total_cmp(&off(&places[*b])));
        let Some(nearest) = nearest else {
            return f64::INFINITY;
        };
        worst = worst.max(off(&places.swap_remove(nearest)));
    }
    worst
}

/// Centres of all places (m).
fn places(task: &TaskTable) -> Vec<Vector3<f64>> {
    match task.kind() {
        "palletize" => {
            let task: PalletizeTask = task.read().expect("the table was read before");
            let row = |x: f64| task.slot_y_m.iter().map(move |y| (x, *y));
            let all = task.slot_x_m.iter().copied().flat_map(row);
            all.map(|(x, y)| Vector3::new(x, y, task.slot_z_m))
                .collect()
        }
        "bin_stack" => {
            let task: BinStackTask = task.read().expect("the table was read before");
            let stack = &task.stack;
            let [x, y, z] = stack.first_m;
            let (first, second) = (stack.first_step_m, stack.second_step_m);
            let column = |index: u32| {
                let (i, j) = (f64::from(index % 3), f64::from(index / 3));
                let at = |axis: usize| first[axis] * i + second[axis] * j;
                (x + at(0), y + at(1))
            };
            let levels = 0..stack.levels;
            let place =
                |level: u32, (x, y)| Vector3::new(x, y, z + BIN_M * (f64::from(level) + 0.5));
            levels
                .flat_map(|level| (0..9).map(move |index| (level, index)))
                .map(|(level, index)| place(level, column(index)))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// Height of a bin (m).
const BIN_M: f64 = 0.135;
