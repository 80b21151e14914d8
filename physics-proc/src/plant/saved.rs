//! The state of a plant as bytes, for a successor of its process.

use cell_model::cells::script::{ScriptAction, ScriptProgress};
use cell_run::script_report::ScriptReply;
use cell_run::spec::Speed;
use ipc_types::world::PauseCause;
use serde::{Deserialize, Serialize};

use super::Plant;
use crate::world::WorldError;

/// State that decides the next ticks, besides the world and the run.
#[derive(Serialize, Deserialize)]
struct Saved {
    script: ScriptProgress,
    pause_cause: u32,
    steps_left: Option<u64>,
    waiting: Option<(u32, ScriptAction)>,
    replies: Vec<ScriptReply>,
    speed: Speed,
    accepted: u64,
    break_tick: u64,
}

impl Plant {
    /// The present state as bytes, for a successor of this process; see [`Plant::restore`].
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.save_to(&mut bytes);
        bytes
    }

    /// As [`Plant::save`], appended to `out`.
    pub(crate) fn save_to(&self, out: &mut Vec<u8>) {
        let saved = Saved {
            script: self.script.progress().clone(),
            pause_cause: self.pause_cause(),
            steps_left: self.steps_left,
            waiting: self.waiting.clone(),
            replies: self.replies.clone(),
            speed: self.speed,
            accepted: self.accepted,
            break_tick: self.break_tick,
        };
        // If writing fails the first line is missing, and `restore` refuses the bytes.
        serde_json::to_writer(&mut *out, &saved).ok();
        out.push(b'\n');
        self.world.write_snapshot(out);
    }

    /// Continues from the bytes of [`Plant::save`] in a run of the same cell and script.
    ///
    /// # Errors
    /// [`WorldError::Snapshot`]; the plant is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), WorldError> {
        let damaged = |error: serde_json::Error| WorldError::Snapshot {
            reason: format!("it is damaged ({error})"),
        };
        let line = bytes.iter().position(|byte| *byte == b'\n');
        let (saved, world) = bytes.split_at(line.unwrap_or(0));
        let saved: Saved = serde_json::from_slice(saved).map_err(damaged)?;
        // The world is restored first: it can refuse, and then nothing of the plant has
        // changed.
        self.world.restore(world.get(1..).unwrap_or_default())?;
        self.script.restore(saved.script);
        let cause = PauseCause::from_code(saved.pause_cause);
        self.pause = cause.filter(|cause| *cause != PauseCause::None);
        self.steps_left = saved.steps_left;
        self.waiting = saved.waiting;
        self.replies = saved.replies;
        self.speed = saved.speed;
        self.accepted = saved.accepted;
        // Else the breakpoint that the task reached last would pause the cell again.
        self.break_tick = saved.break_tick;
        self.resumed_tick = self.world.tick();
        Ok(())
    }

    /// Number of the newest request that a successor of this process has to obey, too.
    pub(crate) fn accepted(&self) -> u64 {
        self.accepted
    }

    /// The next request gets the number after `accepted`.
    pub(crate) fn set_accepted(&mut self, accepted: u64) {
        self.accepted = accepted;
    }
}
