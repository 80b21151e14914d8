//! Long series of the cells with bins: every bin where it belongs, the right way
//! up, at rest for ten more seconds, and the arm touched nothing that stands.
//!
//!     cargo run --release -p cell-sim --example bins -- ur10-palletize 1 30
//!     cargo run --release -p cell-sim --example bins -- ur10-bin-stack 1 5
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a program for people who measure"
)]

use cell_sim::{OneProcess, eval::template, run};
use ipc_types::decision::Outcome;
use ipc_types::operator::OperatorAction;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ObjectState, OperatorRequest};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// How long all has to rest after the job (ticks).
const REST_TICKS: u64 = 10_000;

struct Series {
    sim: OneProcess,
    flips: usize,
    came_upside_down: Vec<Option<bool>>,
    fixture_contacts: u64,
}

fn up(object: &ObjectState) -> f64 {
    let [w, x, y, z] = object.pose.orientation_wxyz;
    (UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)) * Vector3::z()).z
}

impl Series {
    fn new(demo: &str, policy: &str, seed: u64) -> Self {
        let mut spec = template(demo, policy);
        spec.seed = seed;
        spec.until_done = false;
        let cell = run::cell_of(&spec).expect("the built-in cell");
        spec.time_limit_s = Some(cell.time_limit_s);
        let bins = cell.bins;
        let mut sim = OneProcess::new(&spec, cell).expect("a cell that runs");
        sim.operate(&OperatorRequest {
            action: OperatorAction::TaskStart.code(),
            ..OperatorRequest::zeroed_at_identity()
        });
        Self {
            sim,
            flips: 0,
            came_upside_down: vec![None; bins],
            fixture_contacts: 0,
        }
    }

    fn tick(&mut self) -> bool {
        let goes_on = self.sim.tick().expect("a tick");
        let objects = self.sim.state().objects().iter();
        for (lie, object) in self.came_upside_down.iter_mut().zip(objects) {
            if lie.is_none() && object.flags & OBJECT_ENABLED != 0 {
                *lie = Some(up(object) < 0.0);
            }
        }
        for (tick, line) in self.sim.take_trace() {
            let flip = line.contains("<flip>") || line.contains("[decide] -> flip");
            self.flips += usize::from(flip);
            if std::env::var_os("LINES").is_some() {
                println!("{:9.3} {line}", tick as f64 * 1.0e-3);
            }
        }
        self.fixture_contacts += self.sim.plant().world().fixture_contacts(0) as u64;
        goes_on
    }

    fn outcome(&self) -> Option<Outcome> {
        Outcome::from_code(self.sim.decision().outcome)
    }
}

fn main() -> std::process::ExitCode {
    let args: Vec<String> = std::env::args().collect();
    let demo = args.get(1).map_or("ur10-palletize", String::as_str);
    let number = |index: usize| args.get(index).and_then(|text| text.parse::<u64>().ok());
    let (first, last) = (number(2).unwrap_or(1), number(3).unwrap_or(1));
    // The pallet is built with bins that open up, the columns with bins that open down.
    let (policy, right, flips_when) = match demo {
        "ur10-palletize" => ("table", 1.0, true),
        _ => ("matrix", -1.0, false),
    };
    let mut bad = 0;
    for seed in first..=last {
        let mut series = Series::new(demo, policy, seed);
        while series.outcome() != Some(Outcome::Done) && series.tick() {}
        let at_end: Vec<ObjectState> = series.sim.state().objects().to_vec();
        let done_s = series.sim.state().header.tick as f64 * 1.0e-3;
        for _ in 0..REST_TICKS {
            if !series.tick() {
                break;
            }
        }
        let bins = series.came_upside_down.len();
        let now = series.sim.state().objects();
        let drift = now.iter().zip(&at_end).take(bins).map(|(now, then)| {
            (Vector3::from(now.pose.position) - Vector3::from(then.pose.position)).norm()
        });
        let drift = drift.fold(0.0, f64::max);
        let upright = now.iter().take(bins).all(|bin| up(bin) * right > 0.999);
        let wanted = series
            .came_upside_down
            .iter()
            .filter(|lie| **lie == Some(flips_when))
            .count();
        let decision = series.sim.decision();
        let violations = series.sim.state().arms()[0].limit_violations;
        let good = series.outcome() == Some(Outcome::Done)
            && decision.placed_count as usize == bins
            && upright
            && series.flips == wanted
            && drift < 1.0e-3
            && violations == 0
            && series.fixture_contacts == 0;
        bad += u32::from(!good);
        println!(
            "{} seed {seed}: {:?} at {done_s:.1} s, {} of {bins} placed, right way up {upright}, {} flips of {wanted}, drift {:.4} mm in 10 s, drops {}, {violations} violations, {} ticks with the arm on a fixture",
            if good { "ok " } else { "BAD" },
            series.outcome(),
            decision.placed_count,
            series.flips,
            drift * 1.0e3,
            decision.drops,
            series.fixture_contacts,
        );
    }
    if bad == 0 {
        std::process::ExitCode::SUCCESS
    } else {
        std::process::ExitCode::FAILURE
    }
}
