//! Every situation the stacking policies can get into, with two cubes and a
//! coarse world: breadth first over what the arm, the gripper, the cubes and
//! the operator may do between two decisions.
//!
//! Shown for each policy: the gripper never opens around a cube outside
//! RELEASE, a drop, a reset or the operator's command; and from every situation
//! the job still gets done once nobody disturbs it.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test that cannot go on has failed, and one that explores says how far"
)]

mod coarse;

use std::collections::{HashSet, VecDeque};

use coarse::{Choice, Situation};
use ipc_types::decision::Outcome;

/// A policy has fewer situations; a test that loses its bound says so.
const MOST: usize = 60_000;
/// Undisturbed, a job takes fewer steps.
const PATIENCE: usize = 400;

fn explore(policy: &str) {
    let first = Situation::begin(policy);
    let mut seen = HashSet::from([first.key()]);
    let mut open = VecDeque::from([first]);
    let mut steps = 0_u64;
    while let Some(situation) = open.pop_front() {
        assert_gets_done(&situation);
        for choice in Choice::ALL {
            let Some(next) = situation.after(choice) else {
                continue;
            };
            steps += 1;
            if seen.insert(next.key()) {
                assert!(seen.len() < MOST, "{policy}: more than {MOST} situations");
                open.push_back(next);
            }
        }
    }
    println!("{policy}: {} situations, {steps} steps", seen.len());
    assert!(seen.len() > 200, "{policy}: that is hardly everything");
}

/// With nobody in its way, and after another start if it was given up.
#[track_caller]
fn assert_gets_done(situation: &Situation) {
    let mut now = situation.clone().freed();
    for _ in 0..PATIENCE {
        match now.outcome() {
            Outcome::Done => return,
            Outcome::Failed => now = now.restarted(),
            _ => {}
        }
        now = now.after(Choice::Nothing).unwrap();
    }
    panic!(
        "stuck after {:#?}\nfrom {:?}\nin {:?}",
        now.story(),
        situation.key(),
        now.key()
    );
}

#[test]
fn of_the_state_machine() {
    explore("fsm");
}

#[test]
fn of_the_if_else_controller() {
    explore("ifelse");
}

#[test]
fn of_the_tree_in_code() {
    explore("bt");
}
