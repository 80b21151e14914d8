//! A cell that is restored from a snapshot repeats its run, bit for bit.

use cell_sim::{OneProcess, SimError, eval};

fn cell(demo: &str, policy: &str, seed: u64) -> OneProcess {
    let mut spec = eval::template(demo, policy);
    spec.seed = seed;
    let cell = spec.load_cell_from(&cell_model::Data::checkout()).unwrap();
    OneProcess::new(&demos::policies(), &spec, cell).unwrap()
}

fn run(sim: &mut OneProcess, ticks: usize) -> (u64, u64, Vec<u8>) {
    for _ in 0..ticks {
        sim.tick().unwrap();
    }
    let header = &sim.state().header;
    (header.tick, sim.state().state_hash, sim.task_checkpoint())
}

fn is_holding(sim: &OneProcess) -> bool {
    sim.state().arms[0].gripper.held_object > 0
}

#[test]
fn is_taken_back_by_the_same_cell_and_by_another_of_its_seed() {
    for (demo, policy) in [("franka-stack", "bt"), ("franka-pyramid", "json")] {
        let mut sim = cell(demo, policy, 3);
        while !is_holding(&sim) {
            run(&mut sim, 37);
        }
        let snapshot = sim.snapshot().unwrap();
        let after = run(&mut sim, 1500);
        sim.restore(&snapshot).unwrap();
        assert!(is_holding(&sim), "{demo}: the cube is in the gripper again");
        assert_eq!(run(&mut sim, 1500), after, "{demo}: the same cell");
        let mut other = cell(demo, policy, 3);
        run(&mut other, 11);
        other.restore(&snapshot).unwrap();
        assert_eq!(run(&mut other, 1500), after, "{demo}: another cell");
    }
}

#[test]
fn that_cannot_be_taken_back_changes_nothing() {
    let mut sim = cell("franka-stack", "fsm", 1);
    run(&mut sim, 500);
    let snapshot = sim.snapshot().unwrap();
    let before = (sim.state().state_hash, sim.task_checkpoint());
    let of_two_arms = cell("franka-pyramid", "json", 1).snapshot().unwrap();
    let of_another_version = [&[9, 0, 0, 0], &snapshot[4..]].concat();
    let bad: [(&[u8], &str); 4] = [
        (&[], "cannot be read"),
        (&snapshot[..snapshot.len() / 2], "cannot be read"),
        (&of_another_version, "layout version 9"),
        (&of_two_arms, "2 arms, this cell has 1"),
    ];
    for (bytes, message) in bad {
        let refused: SimError = sim.restore(bytes).unwrap_err();
        assert!(refused.to_string().contains(message), "{refused}");
        assert_eq!((sim.state().state_hash, sim.task_checkpoint()), before);
    }
    let mut other = cell("franka-stack", "fsm", 1);
    let expected = run(&mut other, 1000);
    assert_eq!(run(&mut sim, 500), expected);
}
