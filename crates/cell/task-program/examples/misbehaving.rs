//! A task program with one policy per defect, for tests of the reaction of the cell to
//! each of them.

#![allow(clippy::print_stderr, reason = "its last words are one of the defects")]

use std::process::ExitCode;

use robocell_task::{ArmIntent, Job, Observation, Outcome, Output, Policies, Policy, Pose};

/// Until then the policy is without a fault, so that a test sees the arm move first (s).
const BEGINS_S: f64 = 1.0;

const TARGET: Pose = Pose {
    position: [0.4, 0.2, 0.4],
    orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
};

#[derive(Clone, Copy)]
enum Defect {
    Panics,
    Exits(i32),
    Hangs,
    NotANumber,
    OutOfThisWorld,
}

struct Misbehaving(Defect);

impl Policy for Misbehaving {
    type Memory = ();

    #[allow(
        clippy::panic,
        clippy::exit,
        clippy::disallowed_methods,
        clippy::infinite_loop,
        reason = "the defects of this program"
    )]
    fn decide(&self, (): &mut (), cell: &Observation<'_>, _: &mut Job, out: &mut Output) {
        let mut target = TARGET;
        if cell.time().seconds() >= BEGINS_S {
            match self.0 {
                Defect::Panics => panic!("the policy has a defect"),
                Defect::Exits(code) => {
                    eprintln!("the policy ends its process");
                    std::process::exit(code)
                }
                // Never returns: the supervisor has to find a task whose cycles do not advance.
                Defect::Hangs => loop {
                    std::hint::spin_loop();
                },
                // Invalid in every message: the task program has to refuse it, not publish it.
                Defect::NotANumber => target.position[1] = f64::NAN,
                // Finite but outside of the range that messages accept.
                Defect::OutOfThisWorld => target.position[1] = 1.0e9,
            }
        }
        out.arm(0, ArmIntent::pose(1, target));
    }
}

/// Has the name of the circle's policy, but another memory type: a program that was changed
/// and built again while its cell runs.
struct Rebuilt;

impl Policy for Rebuilt {
    type Memory = u64;

    fn decide(&self, count: &mut u64, _: &Observation<'_>, _: &mut Job, out: &mut Output) {
        *count += 1;
        out.arm(0, ArmIntent::pose(1, TARGET));
        if *count > 100 {
            out.outcome = Outcome::Done;
        }
    }
}

fn main() -> ExitCode {
    let policy = |policies: Policies, name: &str, defect| {
        policies.policy(name, move |_| Misbehaving(defect))
    };
    let mut policies = Policies::new();
    policies = policy(policies, "panics", Defect::Panics);
    policies = policy(policies, "exits", Defect::Exits(1));
    policies = policy(policies, "exits_with_0", Defect::Exits(0));
    policies = policy(policies, "exits_with_5", Defect::Exits(5));
    policies = policy(policies, "hangs", Defect::Hangs);
    policies = policy(policies, "not_a_number", Defect::NotANumber);
    policies = policy(policies, "out_of_this_world", Defect::OutOfThisWorld);
    // Its memory is a number where the circle's is empty, so the bytes of a checkpoint of one
    // do not decode for the other.
    policies = policies.policy("circle", |_| Rebuilt);
    robocell_task_program::main(policies)
}
