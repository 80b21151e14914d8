//! How exactly the demos place: the distance in the plane between each object at the end of a run
//! and the nearest position that the cell file gives. `SEEDS` is the number of runs.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use cell_model::{Cell, Data};
use cell_sim::{OneProcess, eval::template};
use ipc_types::decision::Outcome;

/// Without `SEEDS`.
const SEEDS: u64 = 1;
/// A series that is stopped early has printed figures after each so many runs.
const PROGRESS: usize = 20;
/// Largest error of 99 % of the cubes (m).
const CUBES_M: f64 = 1.0e-3;
/// Largest error of a bin (m).
const BINS_M: f64 = 0.02;

/// Positions in the plane where objects belong (m).
type Goals = fn() -> Vec<[f64; 2]>;

fn demo(name: &str, policy: &str, goals: Goals) -> Vec<f64> {
    let seeds = std::env::var("SEEDS").map_or(SEEDS, |text| text.parse().expect("a number"));
    let (next, errors) = (AtomicU64::new(1), Mutex::new(Vec::new()));
    let goals = goals();
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed > seeds {
                return;
            }
            let of_run = run(name, policy, seed, &goals);
            let mut errors = errors.lock().unwrap();
            errors.push(of_run);
            if errors.len() % PROGRESS == 0 {
                figures(name, &errors);
            }
        }
    };
    std::thread::scope(|threads| {
        for _ in 0..std::thread::available_parallelism().map_or(1, Into::into) {
            threads.spawn(work);
        }
    });
    figures(name, &errors.into_inner().unwrap())
}

/// Prints the figures of `runs`, and gives all errors in rising order (m).
#[allow(clippy::print_stdout, reason = "a series prints its figures")]
fn figures(name: &str, runs: &[Vec<f64>]) -> Vec<f64> {
    let mut errors = runs.concat();
    errors.sort_by(f64::total_cmp);
    println!(
        "{name}: {} seeds, {} objects, p50 {:.3} mm, p99 {:.3} mm, largest {:.3} mm",
        runs.len(),
        errors.len(),
        1.0e3 * quantile(&errors, 50),
        1.0e3 * quantile(&errors, 99),
        1.0e3 * quantile(&errors, 100),
    );
    errors
}

fn run(name: &str, policy: &str, seed: u64, goals: &[[f64; 2]]) -> Vec<f64> {
    let mut spec = template(name, policy);
    spec.seed = seed;
    let cell = spec.load_cell_from(&Data::checkout()).expect("a cell");
    spec.time_limit_s = Some(cell.time_limit_s);
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell).expect("a cell that runs");
    while sim.tick().expect("a tick") {}
    let decision = sim.decision();
    let outcome = Outcome::from_code(decision.outcome);
    assert_eq!(outcome, Some(Outcome::Done), "{name}, seed {seed}");
    let placed = &decision.placed[..decision.placed_count as usize];
    let error = |object: &u32| {
        let [x, y, _] = sim.state().objects()[*object as usize].pose.position;
        let off = goals.iter().map(|[gx, gy]| (x - gx).hypot(y - gy));
        off.fold(f64::INFINITY, f64::min)
    };
    assert!(!placed.is_empty(), "{name}, seed {seed}");
    placed.iter().map(error).collect()
}

fn quantile(sorted: &[f64], percent: usize) -> f64 {
    sorted[(sorted.len() - 1) * percent / 100]
}

/// `[task]` of a demo.
fn task(name: &str) -> toml::Table {
    let cell = Cell::load(&Data::checkout(), name, 0, None).expect("a cell");
    cell.task.read().expect("a table")
}

fn pair(value: &toml::Value) -> [f64; 2] {
    let numbers = value.as_array().expect("a list");
    [0, 1].map(|index| numbers[index].as_float().expect("a number"))
}

#[test]
fn cubes_are_placed_within_a_millimetre() {
    let cube: Goals = || vec![pair(&task("cube")["place"]["mark"]["position_m"])];
    let stack: Goals = || vec![pair(&task("franka-stack")["stack_position_m"])];
    let pyramid: Goals = || {
        let task = task("franka-pyramid");
        let arms = task["robot"].as_table().expect("a table");
        arms.values().map(|arm| pair(&arm["goal_m"])).collect()
    };
    for (name, policy, goals) in [
        ("cube", "ifelse", cube),
        ("franka-stack", "fsm", stack),
        ("franka-pyramid", "json", pyramid),
    ] {
        let errors = demo(name, policy, goals);
        assert!(quantile(&errors, 99) <= CUBES_M, "{name}");
    }
}

/// Every bin is in its place.
fn bins_are_placed(name: &str, policy: &str, goals: Goals) {
    let errors = demo(name, policy, goals);
    assert!(quantile(&errors, 100) <= BINS_M, "{name}");
}

#[test]
#[ignore = "slow: .ci/long"]
fn bins_on_the_pallet_are_placed_within_their_tolerance() {
    bins_are_placed("ur10-palletize", "table", || {
        let task = task("ur10-palletize");
        let [columns, rows] = ["slot_x_m", "slot_y_m"].map(|key| {
            let numbers = task[key].as_array().expect("a list").iter();
            numbers
                .map(|value| value.as_float().expect("a number"))
                .collect::<Vec<_>>()
        });
        let column = |x: &f64| rows.iter().map(|y| [*x, *y]).collect::<Vec<_>>();
        columns.iter().flat_map(column).collect()
    });
}

#[test]
#[ignore = "slow: .ci/long"]
fn bins_in_columns_are_placed_within_their_tolerance() {
    bins_are_placed("ur10-bin-stack", "matrix", || {
        let task = task("ur10-bin-stack");
        let of = |key: &str| pair(&task["stack"][key]);
        let (first, a, b) = (of("first_m"), of("first_step_m"), of("second_step_m"));
        let at = |i: u8, j: u8| {
            [0, 1].map(|axis| first[axis] + f64::from(i) * a[axis] + f64::from(j) * b[axis])
        };
        (0..9).map(|column| at(column % 3, column / 3)).collect()
    });
}
