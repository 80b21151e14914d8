//! Every situation the stacking policies can get into, with two cubes, two
//! attempts at each and a coarse world: breadth first over what may happen
//! between two decisions, as often and in any order.
//!
//! The arm reaches its target or is stuck past every timeout; the fingers find hold or not,
//! open or not; a held cube falls out; a cube that is not held is put elsewhere within reach or
//! out of reach; the task is reset; it is killed and restored, with and without a loss
//! meanwhile; the operator pauses it, opens the hand, takes the cube out of it and lets it
//! continue. Situations are the same when phase, outcome, reason, the places of the cubes,
//! hand, arm and the counts (drops since the last set-down, misses of each cube's place,
//! decisions in a phase up to three) are the same. Motions, contacts and times between those
//! are not explored, nor are more cubes.
//!
//! Shown for each policy: the gripper never opens around a cube outside
//! RELEASE, a drop, a reset or the operator's command; and from every situation
//! the job still gets done once nothing disturbs it.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking, and one that explores says how far"
)]

use crate::coarse;

use std::collections::{HashSet, VecDeque};

use coarse::{Choice, Key, Situation};
use ipc_types::decision::Outcome;

/// Upper bound of the number of situations of a policy; a test that exceeds it fails.
const MOST: usize = 60_000;
/// Undisturbed, a job takes fewer steps.
const PATIENCE: usize = 400;

fn explore(policy: &str) {
    let first = Situation::begin(policy);
    let mut seen = HashSet::from([first.key()]);
    let mut open = VecDeque::from([first]);
    let mut goes_on = HashSet::new();
    let mut steps = 0_u64;
    while let Some(situation) = open.pop_front() {
        assert_gets_done(&situation, &mut goes_on);
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
    assert!(seen.len() > 5_000, "{policy}: that is hardly everything");
}

/// Without a disturbance, and after another start if the job failed; or it reaches a situation
/// for which that is known.
#[track_caller]
fn assert_gets_done(situation: &Situation, goes_on: &mut HashSet<Key>) {
    let mut now = situation.clone().freed();
    let mut way = Vec::new();
    for _ in 0..PATIENCE {
        let key = now.key();
        if now.outcome() == Outcome::Done || goes_on.contains(&key) {
            goes_on.extend(way);
            return;
        }
        way.push(key);
        if now.outcome() == Outcome::Failed {
            now = now.restarted();
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
#[ignore = "slow: .ci/long"]
fn of_the_state_machine() {
    explore("fsm");
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_if_else_controller() {
    explore("ifelse");
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_tree_in_code() {
    explore("bt");
}
