//! Random drags of any cube at any time: every job ends with a stack.

use crate::common;

use cell_model::random::Random;
use common::{ALL, FakeCell};
use ipc_types::decision::Outcome;

/// Jobs per policy.
const SEEDS: u64 = 40;
/// Seconds within which cubes are dragged.
const DISTURBED_S: u64 = 60;

fn run(policy: &str, seed: u64) {
    let mut cell = FakeCell::new("franka-stack", policy, seed);
    let mut random = Random::new(seed ^ 0xd15_7a2b);
    let mut next = 100;
    for step in 0..DISTURBED_S * 100 {
        if step == next {
            let cube = usize::try_from(random.bits() % 4).unwrap_or_default();
            let to = [
                0.5 + random.around_zero(0.15),
                random.around_zero(0.45),
                0.025,
            ];
            cell.drag(cube, to);
            next += 20 + random.bits() % 800;
        }
        cell.step();
    }
    cell.run_until(150.0, |c| c.outcome() != Outcome::Running);
    assert_eq!(
        cell.outcome(),
        Outcome::Done,
        "{policy}, seed {seed}: {:#?}",
        cell.lines
    );
    assert_eq!(cell.placed(), [0, 1, 2, 3]);
}

#[test]
fn every_disturbed_job_ends_with_a_stack() {
    for policy in ALL {
        (0..SEEDS).for_each(|seed| run(policy, seed));
    }
}
