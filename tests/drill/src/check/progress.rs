//! A task does not forget, and does not remember what has not happened.

use std::collections::VecDeque;

use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, WorldState};

use super::history::undo;
use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::News;
use crate::plan::{Fault, Plan};
use crate::scene::TaskPlan;

/// Ticks between two decisions.
const DECISION_TICKS: u64 = 10;
/// Decisions to which a physics may go back.
const KEPT: usize = 400;

pub(super) fn all(plan: &Plan) -> Vec<Box<dyn Check>> {
    let task = plan.scene.as_ref().map(|scene| &scene.task);
    match task {
        Some(TaskPlan::Stub { .. }) => vec![Box::new(Progress::default())],
        _ => Vec::new(),
    }
}

/// The stub task counts its decisions. After a restart it continues from the count of its last
/// decision; after a restart of physics from that of the tick from which physics resumed.
#[derive(Default)]
struct Progress {
    /// Generation of the newest physics, and the tick from which it resumed.
    physics: (u32, u64),
    /// Numbers of the resets of task and scene.
    resets: (u32, u32),
    /// Tick of the newest of them: a decision of before may be sent again.
    reset_tick: u64,
    /// Physics of the last decision.
    answered: u32,
    /// Tick, count and physics of the decisions, the newest last.
    counts: VecDeque<(u64, u64, u32)>,
    /// A file was damaged, perhaps that of its checkpoints.
    had_damage: bool,
}

impl Progress {
    fn state(&mut self, state: &WorldState) {
        self.physics = (state.header.generation, state.resumed_tick);
        let resets = (state.panel.task_reset, state.panel.scene_reset);
        if std::mem::replace(&mut self.resets, resets) != resets {
            self.counts.clear();
            self.reset_tick = state.header.tick;
        }
    }

    fn decision(&mut self, decision: &Decision) -> Verdict {
        let mut inputs = decision.header.inputs().iter();
        let state = inputs.find(|input| input.topic == TopicId::WorldState.code());
        let (Some(state), (physics, resumed_tick)) = (state, self.physics) else {
            return Ok(());
        };
        // An answer to a physics that is gone, or of before a reset.
        if state.generation != physics || decision.header.tick <= self.reset_tick {
            return Ok(());
        }
        // A checkpoint for a state does not have the decision on that state.
        if std::mem::replace(&mut self.answered, physics) != physics {
            undo(&mut self.counts, |(tick, ..)| *tick >= resumed_tick);
            if self.had_damage {
                self.counts.clear();
            }
        }
        let (tick, count) = (decision.header.tick, u64::from(decision.resyncs));
        let before = self.counts.back().copied();
        self.counts.push_back((tick, count, physics));
        if self.counts.len() > KEPT {
            self.counts.pop_front();
        }
        let Some((before_tick, before, of)) = before else {
            return Ok(());
        };
        // In a pause it decides once for each start of physics.
        let starts = u64::from(physics.saturating_sub(of));
        let most = before + tick.saturating_sub(before_tick) / DECISION_TICKS + 1 + starts;
        fail_if(!(before..=most).contains(&count), || {
            format!(
                "at tick {tick} the task has decided {count} times, after {before} at tick \
                 {before_tick}"
            )
        })
    }
}

impl Check for Progress {
    fn number(&self) -> u32 {
        18
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::State(state) => self.state(state),
            Seen::Decision(decision) => return self.decision(decision),
            // That is another invariant.
            Seen::Trace(line) if line.text.as_str().contains("started without") => {
                self.counts.clear();
            }
            Seen::Fault(Fault::DamageFile { .. }) => self.had_damage = true,
            // It decides from what is left.
            Seen::News(News::Meets(Process::Task, ..)) => self.counts.clear(),
            _ => {}
        }
        Ok(())
    }
}
