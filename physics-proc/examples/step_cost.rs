//! Cost of one tick of a demo at rest: the step of the world, and writing its
//! state. `cargo run --release -p robocell-physics --features measure --example step_cost [TICKS
//! [DEMO]]`.
#![allow(clippy::print_stdout, reason = "printing is what this program does")]

use std::time::Instant;

use cell_model::{Cell, Data};
use ipc_types::{Wire, WorldState};
use physics_proc::world::{StepInput, World, WorldError};

fn main() -> Result<(), WorldError> {
    let ticks = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(20_000);
    let demo = std::env::args().nth(2);
    let demo = demo.as_deref().unwrap_or("franka-stack");
    let cell = Cell::load(&Data::checkout(), demo, 1, None)?;
    let mut world = World::new(&cell)?;
    let mut state = Box::new(WorldState::zeroed());
    let (mut steps, mut writes) = (Vec::new(), Vec::new());
    for _ in 0..ticks {
        let start = Instant::now();
        world.step(&StepInput::default());
        let middle = Instant::now();
        world.write_state(&mut state);
        steps.push(middle.duration_since(start).as_nanos());
        writes.push(middle.elapsed().as_nanos());
    }
    print("step", &mut steps);
    print("write_state", &mut writes);
    println!("hash {:016x} at tick {}", state.state_hash, world.tick());
    let start = Instant::now();
    let snapshot = world.snapshot();
    let saved = start.elapsed();
    let start = Instant::now();
    world.restore(&snapshot)?;
    println!(
        "snapshot {} bytes, out {saved:?}, in {:?}",
        snapshot.len(),
        start.elapsed()
    );
    Ok(())
}

fn print(name: &str, times: &mut [u128]) {
    times.sort_unstable();
    let at =
        |share: usize| times.get(times.len() * share / 1000).copied().unwrap_or(0) as f64 / 1e3;
    println!(
        "{name}: n {} median {:.1} us, p99 {:.1} us",
        times.len(),
        at(500),
        at(990)
    );
}
