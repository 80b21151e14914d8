//! Put the cube on the mark, as one if/else: everything is in one place.

use std::sync::Arc;

use robocell_skills::{Close, Condition, MoveTo, Open, Progress, Setup, Skill, Status, World};
use robocell_task::{Job, Observation, Output, Policy};
use serde::{Deserialize, Serialize};

/// The controller.
pub(crate) struct IfElse {
    pub(crate) setup: Arc<Setup>,
    pub(crate) cube: usize,
    pub(crate) mark: usize,
}

/// The number of the step, and how far it is.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Memory {
    step: u8,
    progress: Progress,
}

impl Policy for IfElse {
    type Memory = Memory;

    fn decide(
        &self,
        memory: &mut Memory,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let (cube, mark) = (self.cube, self.mark);
        let mut arm = World::new(&self.setup, observation, job, out, 0);
        let on_mark = Condition::At {
            object: cube,
            place: mark,
            tolerance_m: 0.02,
        };
        let mut step = memory.step;
        if on_mark.holds(&arm) {
            if step < 7 {
                step = 7;
            }
        } else if Condition::Holding(Some(cube)).holds(&arm) {
            if !(3..=6).contains(&step) {
                step = 3;
            }
        } else if step > 2 {
            step = 0;
        }
        if step != memory.step {
            memory.step = step;
            memory.progress.reset();
        }
        let progress = &mut memory.progress;
        let status = match step {
            1 => MoveTo::object(cube, 0.0).step(progress, &mut arm),
            2 => Close { object: Some(cube) }.step(progress, &mut arm),
            3 => MoveTo::up(0.1).holding(cube).step(progress, &mut arm),
            4 => MoveTo::place(cube, mark, 0.1).step(progress, &mut arm),
            5 => MoveTo::place(cube, mark, 0.0).step(progress, &mut arm),
            6 | 7 => Open.step(progress, &mut arm),
            // 0 and 8.
            _ => MoveTo::object(cube, 0.1).step(progress, &mut arm),
        };
        let done = step == 8 && status == Status::Success;
        if status == Status::Success && !done {
            memory.step += 1;
            memory.progress.reset();
        } else if status == Status::Failure {
            memory.step = 0;
            memory.progress.reset();
        }
        arm.finish();
        arm.report(done);
    }

    fn phase(&self, memory: &Memory) -> &str {
        self.phases().get(usize::from(memory.step)).unwrap_or(&"")
    }

    fn phases(&self) -> &[&str] {
        &[
            "above", "down", "grasp", "lift", "carry", "lower", "release", "let go", "retract",
        ]
    }

    /// The conditions above look at the cell themselves.
    fn reconcile(&self, memory: &mut Memory, _: &Observation<'_>, _: &mut Job, _: &mut Output) {
        memory.progress.reset();
    }
}
