//! How the job stands, and what a checkpoint believes compared with what is seen.

use behavior::Value;
use behavior::board::Board;
use ipc_types::decision::Outcome;
use robocell_task::TraceEvent;

use super::Json;
use crate::pyramid::cubes::is_at;
use crate::pyramid::host::World;
use crate::pyramid::keys;
use robocell_task::job::{Counters, Job};
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::policy::AnyPolicy as _;

impl Json {
    /// Says how the job stands.
    pub(super) fn report(
        &mut self,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        if self.memory.shown.advance() {
            job.counters.phase_entry += 1;
        }
        out.phase = self.phase();
        job.done = self.memory.finished.iter().all(|finished| *finished);
        out.outcome = if job.done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        job.placed.clear();
        for arm in 0..self.robots.len() {
            self.list_placed(arm, observation, &mut job.placed, out);
        }
        job.placed.sort_unstable();
    }

    /// Adds the objects that stand in the stack of `arm` as it believes.
    fn list_placed(
        &self,
        arm: usize,
        observation: &Observation<'_>,
        placed: &mut Vec<u32>,
        out: &mut Output,
    ) {
        let (Some(spec), Some(robot)) = (self.setup.arms.get(arm), self.robots.get(arm)) else {
            return;
        };
        let Some((_, board)) = self.boards.get(robot.board) else {
            return;
        };
        let is_mine = |key: &str| key.strip_prefix(keys::PLACED) == Some(spec.name.as_str());
        let key = board.keys().position(|key| is_mine(&key.name));
        let Some(Value::Set(set)) = key.and_then(|key| board.value(key)) else {
            return;
        };
        let mut unused = (0, Counters::default());
        let world = World {
            observation,
            setup: &self.setup,
            arm,
            last_key: &mut unused.0,
            counters: &mut unused.1,
            out,
        };
        for cube in set.items() {
            let stands = (0..set.len())
                .any(|layer| is_at(&world, cube as usize, self.setup.goal(spec, layer)));
            let object = self.setup.cubes.get(cube as usize).map(|c| c.object);
            if let Some(object) = object.filter(|_| stands) {
                placed.push(u32::try_from(object).unwrap_or(u32::MAX));
            }
        }
    }

    /// What was carried and is not in the hand any more was lost in the
    /// meantime. Everything else is seen by the nodes themselves: a cube in the
    /// hand is gone on with, a cube that moved is picked up anew.
    pub(super) fn reconcile_arm(
        &mut self,
        arm: usize,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let (Some(spec), Some(robot)) = (self.setup.arms.get(arm), self.robots.get(arm)) else {
            return;
        };
        let Some((_, board)) = self.boards.get_mut(robot.board) else {
            return;
        };
        let mut unused = 0;
        let world = World {
            observation,
            setup: &self.setup,
            arm,
            last_key: &mut unused,
            counters: &mut job.counters,
            out,
        };
        let carries = format!("carried:{}", spec.name);
        let mut cubes = 0..self.setup.cubes.len();
        let carried =
            cubes.find(|cube| says(board, self.setup.cube_name(*cube).as_str(), &carries));
        let held = world.cube_in_hand();
        if let Some(held) = held {
            let name = self.setup.cube_name(held);
            world.out.event(
                TraceEvent::Recover,
                format_args!("[resume] {}: {name} is in the hand", spec.name),
            );
        }
        let flag = board.index(&keys::recovery_requested(spec.name.as_str()));
        if let (Some(lost), Some(flag)) = (carried.filter(|_| carried != held), flag) {
            let name = self.setup.cube_name(lost);
            world.out.event(
                TraceEvent::Recover,
                format_args!("[resume] {}: {name} is not in the hand any more", spec.name),
            );
            world.counters.recoveries += 1;
            board.set(flag, Value::Bool(true));
        }
    }
}

/// Whether `board` says `word` of a cube.
fn says(board: &Board, cube: &str, word: &str) -> bool {
    let key = board.index(&keys::cube_state(cube));
    matches!(key.and_then(|key| board.value(key)), Some(Value::Text(text)) if text.as_str() == word)
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot go on has failed"
)]
mod tests {
    use behavior::Str;
    use cell_model::{Cell, Data};
    use ipc_types::{Wire as _, WorldState};

    use super::*;
    use crate::pyramid::numbers::PyramidTask;
    use robocell_task::time::PolicyTime;

    /// Recoveries that are asked for when the checkpoint says that the left arm
    /// carries the first cube and the hand holds object `held`, from 1.
    fn recoveries(held: u32) -> u32 {
        let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
        let task: PyramidTask = cell.task.read().unwrap();
        let mut policy = Json::new(&task, &cell).unwrap();
        let (_, board) = &mut policy.boards[0];
        let key = board.index("cube_state:cube_1").unwrap();
        board.set(key, Value::Text(Str::new("carried:left").unwrap()));
        let mut state = Box::new(WorldState::zeroed());
        (state.arm_count, state.object_count) = (2, 6);
        for object in &mut state.objects[..6] {
            object.flags = ipc_types::world::OBJECT_ENABLED;
        }
        state.arms[0].gripper.held_object = held;
        let observation = Observation::new(&state, &[], PolicyTime::from_ticks(0));
        let mut job = Job::new(6);
        policy.reconcile(&observation, &mut job, &mut Output::default());
        let board = policy.board("shared").unwrap();
        let flag = board.value(board.index("recovery_requested:left").unwrap());
        assert_eq!(flag == Some(Value::Bool(true)), job.counters.recoveries > 0);
        job.counters.recoveries
    }

    #[test]
    fn a_cube_that_is_not_in_the_hand_any_more_is_recovered() {
        assert_eq!(recoveries(1), 0);
        assert_eq!(recoveries(0), 1, "lost");
        assert_eq!(recoveries(2), 1, "another one is there");
    }
}
