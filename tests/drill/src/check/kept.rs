//! What a restart keeps.

use ipc_types::WorldState;
use ipc_types::topic::Process;

use super::history::History;
use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::News;
use crate::plan::Fault;

/// A kill takes physics back by at most a second, and its health says at 100 Hz when it would
/// not.
const LOST_TICKS: u64 = 1020;

pub(super) fn all() -> Vec<Box<dyn Check>> {
    vec![
        Box::new(Physics::default()),
        Box::new(Same::default()),
        Box::new(Saved::default()),
        Box::new(Task::default()),
    ]
}

/// A new physics is at most a second behind the last, or says so.
#[derive(Default)]
struct Physics {
    generation: u32,
    tick: u64,
    /// Whether its log has said what was lost.
    said: bool,
    /// Its health has a fault.
    warned: bool,
    /// The disk was full or slow.
    had_disk_fault: bool,
}

impl Check for Physics {
    fn number(&self) -> u32 {
        14
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::News(News::Logged(Process::Physics, line)) => {
                self.said |= line.contains("lost") || line.contains("is not saved");
            }
            Seen::Health(Process::Physics, health) => self.warned |= health.fault().is_some(),
            Seen::Fault(Fault::Full { .. } | Fault::SlowDisk { .. } | Fault::DamageFile { .. }) => {
                self.had_disk_fault = true;
            }
            Seen::State(state) => return self.state(state),
            _ => {}
        }
        Ok(())
    }
}

impl Physics {
    fn state(&mut self, state: &WorldState) -> Verdict {
        let (generation, tick) = (state.header.generation, state.header.tick);
        let is_new = std::mem::replace(&mut self.generation, generation) != generation;
        let last = std::mem::replace(&mut self.tick, tick);
        if !is_new || generation == 1 {
            return Ok(());
        }
        let resumed = state.resumed_tick;
        let is_reported = std::mem::take(&mut self.said) || std::mem::take(&mut self.warned);
        let lost = last.saturating_sub(resumed);
        fail_if(tick != resumed, || {
            format!(
                "physics {generation} began with tick {tick} and says that it resumed {resumed}"
            )
        })?;
        fail_if(lost > LOST_TICKS && !self.had_disk_fault, || {
            format!("physics {generation} lost {lost} ticks, and the disk had no fault")
        })?;
        fail_if(resumed > last, || {
            format!("physics {generation} resumed at {resumed}, after the last tick {last}")
        })?;
        fail_if(lost > LOST_TICKS && !is_reported, || {
            format!("physics {generation} lost {lost} ticks and does not say so")
        })
    }
}

/// The world that was resumed is the one that was saved.
#[derive(Default)]
struct Same {
    generation: u32,
    hashes: History,
}

impl Check for Same {
    fn number(&self) -> u32 {
        15
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let is_new = std::mem::replace(&mut self.generation, generation) != generation;
        let differs = self.hashes.differs(is_new, state, state.state_hash);
        fail_if(differs, || {
            format!("physics {generation} resumed another world at tick {tick}")
        })
    }
}

/// Physics resumes from the newest state that was saved, or from one that was being saved.
#[derive(Default)]
struct Saved {
    generation: u32,
    /// Ticks of the newest state, of the one that was saved, and of the one that was being saved.
    ticks: [u64; 3],
    /// Tick of the newest state, which physics found damaged.
    damaged: Option<u64>,
}

impl Check for Saved {
    fn number(&self) -> u32 {
        16
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        if let Seen::News(News::Meets(Process::Physics, "physics.state", tick)) = moment.seen {
            self.damaged = Some(*tick);
        }
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let generation = state.header.generation;
        let is_new = std::mem::replace(&mut self.generation, generation) != generation;
        let damaged = self.damaged.take_if(|_| is_new);
        let ticks = [state.header.tick, state.saved_tick, state.saving_tick];
        let [tick, saved, saving] = std::mem::replace(&mut self.ticks, ticks);
        let resumed = state.resumed_tick;
        // The next tick may have been saved before it was published.
        let is_saved = [saved, saving, tick + 1].contains(&resumed);
        // Without any whole state the scene begins again.
        fail_if(damaged.is_some_and(|of| of == resumed && of > 0), || {
            format!("physics {generation} resumed from the damaged state of tick {resumed}")
        })?;
        let is_due = is_new && generation > 1 && damaged.is_none();
        fail_if(is_due && !is_saved, || {
            format!(
                "physics {generation} resumed at {resumed}; {saved} was saved, and {saving} was \
                 being saved"
            )
        })
    }
}

/// After a restart of physics the task continues from the checkpoint of the same tick.
#[derive(Default)]
struct Task {
    /// Tick from which the newest physics resumed; 0 with a fresh scene.
    resumed_tick: u64,
    /// A file was damaged, perhaps that of its checkpoints.
    had_damage: bool,
}

impl Check for Task {
    fn number(&self) -> u32 {
        17
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::State(state) => self.resumed_tick = state.resumed_tick,
            Seen::Fault(Fault::DamageFile { .. }) => self.had_damage = true,
            Seen::Trace(line) => {
                let lost = line.text.as_str().starts_with("[task] started without");
                let tick = self.resumed_tick;
                let is_kept = !self.had_damage;
                return fail_if(lost && tick > 0 && is_kept, || {
                    format!("physics resumed at tick {tick}, and the task lost its checkpoint")
                });
            }
            _ => {}
        }
        Ok(())
    }
}
