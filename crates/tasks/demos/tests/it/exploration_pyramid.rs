//! Every situation the pyramid's trees can get into, with few cubes and a coarse
//! world: breadth first over what the arms, the hands, the controllers, the
//! cubes and the operator may do between two decisions, with the task killed in
//! between.
//!
//! Shown in each: a hand never opens around a cube except where it is set down,
//! in a recovery, or after a drop; one arm owns the centre, is alive, and no
//! other is sent there; each cube is one arm's; and the job still gets done once
//! nothing disturbs it.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking, and says how much it saw"
)]

use crate::coarse_pyramid;

use std::collections::{BTreeMap, HashSet, VecDeque};

use coarse_pyramid::{Choice, Setting, Situation};
use ipc_types::decision::Outcome;

/// Undisturbed, a job takes fewer steps.
const PATIENCE: usize = 400;
/// Steps that are shown of a job that does not get done.
const SHOWN: usize = 40;

/// The situations seen so far.
#[derive(Default)]
struct Search {
    seen: HashSet<u64>,
    /// Known to get done.
    goes_on: HashSet<u64>,
    steps: u64,
    /// The broken promises, each with the shortest path to it.
    wrong: BTreeMap<String, String>,
}

/// Explores the situations after up to `disturbances` of those `among` all, at most `most`
/// situations.
fn explore(setting: &Setting, among: fn(Choice) -> bool, disturbances: usize, most: usize) {
    let mut choices = Choice::all(setting.cubes.len());
    choices.retain(|choice| !choice.disturbs() || among(*choice));
    let first = Situation::begin(setting);
    let mut search = Search::default();
    search.seen.insert(first.key());
    let mut now = VecDeque::from([first]);
    let mut later = VecDeque::new();
    // Found by one disturbance more.
    let mut left = 0_u64;
    for disturbed in 0..=disturbances {
        let mut found = 0;
        while let Some(situation) = now.pop_front() {
            found += 1;
            if search.seen.len() >= most {
                continue;
            }
            search.watch_to_the_end(&situation);
            for choice in &choices {
                let Some(next) = situation.after(*choice) else {
                    continue;
                };
                search.steps += 1;
                if search.is_right(&next) && search.seen.insert(next.key()) {
                    if !choice.disturbs() {
                        now.push_back(next);
                    } else if disturbed < disturbances {
                        later.push_back(next);
                    } else {
                        left += 1;
                    }
                }
            }
        }
        let (seen, steps) = (search.seen.len(), search.steps);
        println!("{disturbed} disturbances: {found} looked at, {seen} seen, {steps} steps");
        if later.is_empty() {
            break;
        }
        std::mem::swap(&mut now, &mut later);
    }
    println!("{left} left");
    for (wrong, story) in &search.wrong {
        println!("== {wrong}\n{story}");
    }
    assert!(
        search.wrong.is_empty(),
        "{} kinds of mistakes",
        search.wrong.len()
    );
    assert!(search.seen.len() < most, "more than {most} situations");
}

impl Search {
    fn is_right(&mut self, situation: &Situation) -> bool {
        let Some(wrong) = situation.wrong() else {
            return true;
        };
        self.note(wrong.to_owned(), situation);
        false
    }

    fn note(&mut self, wrong: String, situation: &Situation) {
        let story = || situation.story(80) + &situation.picture();
        self.wrong.entry(wrong).or_insert_with(story);
    }

    /// With nothing in its way, and after another start if it was given up, the
    /// job gets done.
    fn watch_to_the_end(&mut self, situation: &Situation) {
        let mut now = situation.clone();
        let mut way = Vec::new();
        let mut begun = None;
        for step in 0..PATIENCE {
            now = now.freed();
            let key = now.key();
            if now.outcome() == Outcome::Done || self.goes_on.contains(&key) {
                self.goes_on.extend(way);
                return;
            }
            way.push(key);
            if now.outcome() == Outcome::Failed {
                now = now.restarted();
            }
            now = now.after(Choice::Nothing).unwrap();
            if step == SHOWN {
                begun = Some(now.story(SHOWN));
            }
            self.steps += 1;
            if !self.is_right(&now) {
                return;
            }
        }
        let wrong = format!("stuck, {}", now.leaves());
        let (before, then) = (situation.story(80), begun.unwrap_or_default());
        let story = || format!("{before}-- then\n{then}...\n{}", now.picture());
        self.wrong.entry(wrong).or_insert_with(story);
        // The path to this situation is not printed again.
        self.goes_on.extend(way);
    }
}

const TWO: Setting = Setting {
    cubes: &[(1, [0.46, 0.0, 0.075]), (5, [0.46, 0.0, 0.025])],
    required: 1,
};

const THREE: Setting = Setting {
    cubes: &[
        (1, [0.46, 0.0, 0.075]),
        (2, [0.46, -0.027, 0.025]),
        (3, [0.46, 0.027, 0.025]),
    ],
    required: 1,
};

const FOUR: Setting = Setting {
    cubes: &[
        (1, [0.46, 0.0, 0.075]),
        (2, [0.46, -0.027, 0.025]),
        (3, [0.46, 0.027, 0.025]),
        (6, [0.46, 0.081, 0.025]),
    ],
    required: 2,
};

fn all(_: Choice) -> bool {
    true
}

/// Faults of arms and hands.
fn hands(choice: Choice) -> bool {
    use Choice::{HandStuck, Led, Lost, Slippery, Stuck};
    matches!(
        choice,
        Stuck(_) | HandStuck(_) | Slippery(_) | Lost(_) | Led(_)
    )
}

/// Disturbances of the cubes.
fn cubes(choice: Choice) -> bool {
    matches!(
        choice,
        Choice::Moved(_) | Choice::Taken(_) | Choice::Beside(_, _)
    )
}

/// Kills of processes, and the operator's reset.
fn processes(choice: Choice) -> bool {
    use Choice::{Killed, KilledLost, Reset, Silent};
    matches!(choice, Silent(_) | Killed | KilledLost(_) | Reset)
}

#[test]
fn of_two_cubes_one_on_the_other() {
    explore(&TWO, all, 1, 100_000);
}

#[test]
#[ignore = "takes minutes"]
fn of_three_cubes_for_a_stack_of_one_each() {
    explore(&THREE, all, 1, 200_000);
}

#[test]
fn of_four_cubes_for_a_stack_of_two_each() {
    explore(&FOUR, all, 0, 100_000);
}

#[test]
#[ignore = "takes minutes"]
fn of_four_cubes_disturbed() {
    explore(&FOUR, all, 1, 5_000_000);
}

#[test]
#[ignore = "takes minutes"]
fn of_two_cubes_disturbed_twice() {
    explore(&TWO, all, 2, 5_000_000);
}

#[test]
fn of_two_cubes_with_all_that_hands_do() {
    explore(&TWO, hands, usize::MAX, 20_000_000);
}

#[test]
#[ignore = "takes minutes"]
fn of_two_cubes_with_all_that_cubes_do() {
    explore(&TWO, cubes, usize::MAX, 20_000_000);
}

#[test]
#[ignore = "takes minutes"]
fn of_two_cubes_with_all_that_processes_do() {
    explore(&TWO, processes, usize::MAX, 20_000_000);
}
