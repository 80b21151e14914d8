//! Creep of a held rod out of a grasp, and the time of a step: in this engine and in `MuJoCo`,
//! in turns.

mod scene;

use cell_rt::monotonic_ns;
use ipc_types::{MAX_ARMS, Wire, WorldState};
use physics_proc::engine::settings::TICK_S;
use physics_proc::world::{StepInput, World};

use crate::error::CoreError;
use crate::mujoco::{self, Settings};
use crate::python::PythonStepper;
use crate::report::{Report, Row, Samples};

/// Forces of a finger (N).
// 12 to 60 N: the range in which a kept contact point let a rod creep by 20 um/s (ADR 0028).
const FORCES_N: [u32; 3] = [12, 30, 60];
/// Ticks until the grasp is at rest, and in which its creep is measured.
const SETTLE_TICKS: usize = 500;
const TICKS: usize = 2_000;
/// Ticks of one engine before the turn of the other.
const CHUNK: usize = 100;
/// A sample is the mean of so many ticks: a step of a scene this small takes little more than
/// reading the clock or a call from Python.
const BLOCK: usize = 10;

/// Settings and names of the rows of `MuJoCo`.
const PEERS: [(&str, Settings); 2] = [
    (
        "MuJoCo",
        elliptic("cone=\"elliptic\" impratio=\"10\" jacobian=\"dense\""),
    ),
    (
        "MuJoCo with noslip 10",
        elliptic("cone=\"elliptic\" impratio=\"10\" jacobian=\"dense\" noslip_iterations=\"10\""),
    ),
];

/// The time constant of contacts is the shortest that its documentation allows at the step
/// of that scene. With the default of 20 ms the pads close through the rod at 30 N.
const fn elliptic(option: &'static str) -> Settings {
    Settings {
        option,
        geoms: "solref=\"0.004 1\"",
        coupled: false,
    }
}

/// The engine that holds the rod.
enum Engine {
    Ours(Box<World>),
    MuJoCo(PythonStepper),
}

/// The rod, held by one engine.
struct Held {
    name: String,
    engine: Engine,
    /// Height of the rod at the start of the measurement of its creep (m).
    began_m: f64,
    times: Samples,
}

/// Adds the rows.
pub(crate) fn run(report: &mut Report) -> Result<(), CoreError> {
    for force_n in FORCES_N {
        compare(report, force_n, TICKS)?;
    }
    report.notes.push(format!(
        "rod held: 45 g, radius 4 mm, between two pads that press with that force each, friction \
         0.7 (mujoco issue 3328); creep: how far it moves along the pads in {TICKS} ticks after \
         {SETTLE_TICKS}; step: mean of {BLOCK}"
    ));
    Ok(())
}

fn compare(report: &mut Report, force_n: u32, ticks: usize) -> Result<(), CoreError> {
    let name = format!("rod held with {force_n} N");
    let cell = scene::cell(f64::from(force_n))?;
    let mut all = vec![Held::new(name, Engine::Ours(Box::new(World::new(&cell)?)))];
    for (peer, settings) in PEERS {
        let Some(mut engine) = mujoco::start(&cell, settings) else {
            report.note_once(mujoco::MISSING);
            break;
        };
        report.note_once(&format!(
            "rod held: MuJoCo {}, cone elliptic, impratio 10, solref 0.004 1, dense",
            engine.version()
        ));
        engine.step(1, &scene::CLOSED);
        let name = format!("rod held with {force_n} N, {peer}");
        all.push(Held::new(name, Engine::MuJoCo(engine)));
    }
    // The grasp settles first: contacts sink in, which is not creep.
    in_turns(&mut all, SETTLE_TICKS);
    for held in &mut all {
        (held.began_m, held.times) = (held.height(), Samples::default());
    }
    in_turns(&mut all, ticks);
    let rows: Vec<[Row; 2]> = all.into_iter().map(|held| held.rows(ticks)).collect();
    let names = rows
        .iter()
        .map(|rows| rows.each_ref().map(|row| row.name.clone()));
    let names: Vec<[String; 2]> = names.collect();
    report.rows.extend(rows.into_iter().flatten());
    if let [[creep, step], [their_creep, their_step], ..] = names.as_slice() {
        report.compare(creep, their_creep);
        report.compare(step, their_step);
    }
    Ok(())
}

fn in_turns(all: &mut [Held], ticks: usize) {
    for _ in 0..ticks / CHUNK {
        for held in &mut *all {
            held.chunk();
        }
    }
}

impl Held {
    fn new(name: String, engine: Engine) -> Self {
        Self {
            name,
            engine,
            began_m: 0.0,
            times: Samples::default(),
        }
    }

    fn chunk(&mut self) {
        let blocks = CHUNK / BLOCK;
        let times_ns = match &mut self.engine {
            Engine::Ours(world) => (0..blocks).map(|_| block(world)).collect(),
            Engine::MuJoCo(peer) => peer.blocks(blocks, BLOCK),
        };
        for time_ns in times_ns {
            self.times.record(time_ns / BLOCK as u64);
        }
    }

    /// Height of the rod (m).
    fn height(&mut self) -> f64 {
        match &mut self.engine {
            Engine::Ours(world) => {
                let mut state = WorldState::zeroed();
                world.write_state(&mut state);
                state.objects[0].pose.position[2]
            }
            Engine::MuJoCo(peer) => peer.height(scene::ROD).unwrap_or(f64::NAN),
        }
    }

    /// Creep, and time of a step.
    fn rows(mut self, ticks: usize) -> [Row; 2] {
        let moved_m = (self.height() - self.began_m).abs();
        let rate_um_s = moved_m * 1.0e6 / (ticks as f64 * TICK_S);
        [
            Row::single(&format!("{}: creep", self.name), rate_um_s, "um/s"),
            self.times.into_row(format!("{}: step", self.name)),
        ]
    }
}

/// The time of [`BLOCK`] ticks (ns).
fn block(world: &mut World) -> u64 {
    let tick = world.tick();
    let told: [_; BLOCK] = std::array::from_fn(|index| scene::close(tick + index as u64));
    let began_ns = monotonic_ns();
    for command in &told {
        let mut commands = [None; MAX_ARMS];
        commands[0] = Some(command);
        let decision = None;
        world.step(&StepInput { commands, decision });
    }
    monotonic_ns().saturating_sub(began_ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rod_is_held_with_the_force_and_hardly_creeps() {
        for force_n in FORCES_N {
            let cell = scene::cell(f64::from(force_n)).unwrap();
            let mut world = World::new(&cell).unwrap();
            let mut after = |ticks: usize| {
                (0..ticks / BLOCK).for_each(|_| _ = block(&mut world));
                let mut state = WorldState::zeroed();
                world.write_state(&mut state);
                (state.objects[0].pose.position[2], state.arms[0].gripper)
            };
            let (began_m, _) = after(SETTLE_TICKS);
            let (ended_m, gripper) = after(1_000);
            // A hundredth of MuJoCo's creep without noslip.
            assert!((ended_m - began_m).abs() < 0.3e-6, "{began_m} {ended_m}");
            assert_eq!(gripper.held_object, 1);
            assert!(
                (gripper.grip_force - f64::from(force_n)).abs() < 0.5,
                "{gripper:?}"
            );
        }
    }

    #[test]
    fn each_force_has_its_rows() {
        let mut report = Report::new("physics", false, &[]);
        compare(&mut report, 30, CHUNK).unwrap();
        let names: Vec<_> = report.rows.iter().map(|row| row.name.as_str()).collect();
        let [creep, step, ..] = names.as_slice() else {
            panic!("{names:?}");
        };
        assert_eq!(
            (*creep, *step),
            ("rod held with 30 N: creep", "rod held with 30 N: step")
        );
        let unit = report.rows[0].unit;
        assert_eq!((unit, report.rows[1].unit), ("um/s", "us"));
    }
}
