//! Conditions under which a controller requests a path.

use ipc_types::decision::PLANNED;

use crate::support::{Bench, down};

const FAR: [f64; 3] = [-0.4, 0.6, 0.4];
const ELSEWHERE: [f64; 3] = [0.4, 0.6, 0.4];

fn asked(bench: &mut Bench, selector: u32, target: [f64; 3]) -> Option<u64> {
    bench.decision.goals[0].selector = selector;
    bench.goal(target, down(0.0));
    bench.run(15);
    bench.cycle.plan_asked().map(|asked| asked.id)
}

#[test]
fn only_a_goal_that_wants_a_path_asks_for_one() {
    let mut bench = Bench::new();
    assert_eq!(asked(&mut bench, 0, FAR), None);
    assert_eq!(asked(&mut bench, PLANNED, FAR), Some(1));
}

#[test]
fn a_goal_that_was_planned_before_is_planned_again_after_one_that_was_not() {
    let mut bench = Bench::new();
    let first = asked(&mut bench, PLANNED, FAR);
    assert_eq!(asked(&mut bench, 0, ELSEWHERE), None);
    let second = asked(&mut bench, PLANNED, FAR);
    assert!(first.is_some() && second > first, "{first:?} {second:?}");
}
