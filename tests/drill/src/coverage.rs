//! Which states of the cell a run reached: named ones, and combinations by their hash.
//!
//! No support of the compiler is needed: what counts is what messages and lines show.

use std::collections::BTreeSet;

use ipc_types::WorldState;
use ipc_types::arm::StopAction;
use ipc_types::decision::Outcome;
use ipc_types::world::{FLAG_ENDING, FLAG_LOCKSTEP, FLAG_PAUSED};
use supervisor::supervision::Exit;

use crate::check::{Moment, Seen};
use crate::model::News;
use crate::plan::noise;

/// Number of different hashes of a combination.
pub const BITS: u64 = 1 << 16;

/// States that a batch of some thousand plans has to reach.
pub const NAMED: [&str; 23] = [
    "an arm holds for want of decisions",
    "physics brakes for want of commands",
    "drives have no power",
    "paused",
    "lockstep",
    "physics resumed",
    "physics began again at tick 0",
    "the scene was reset",
    "the task was reset",
    "the operator leads",
    "an object is held",
    "an object is placed",
    "the job is done",
    "the job has failed",
    "the task resumed from its checkpoint",
    "the task resumed with physics",
    "a hung process is replaced",
    "starvation is reported",
    "no room is reported",
    "a state is not saved",
    "a process ended with an error",
    "the run is given up",
    "a process starts on a damaged file",
];

/// What a run reached.
#[derive(Clone, Debug, Default)]
pub struct Coverage {
    /// Names of [`NAMED`].
    pub named: BTreeSet<&'static str>,
    /// Hashes of combinations, below [`BITS`].
    pub bits: BTreeSet<u64>,
    /// The present combination, and the one before.
    now: Combination,
    before: (Combination, u64),
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Combination {
    flags: u32,
    arms: u64,
    statuses: u64,
    outcome: u32,
    /// Processes that work, one bit each.
    works: u64,
    /// Kind of the last line of the launcher.
    told: u64,
}

impl Coverage {
    /// Takes note of `moment`.
    pub(crate) fn see(&mut self, moment: &Moment<'_>) {
        match moment.seen {
            Seen::State(state) => self.state(state),
            Seen::Status(arm, status) => {
                if status.stop_action >= StopAction::Hold.code() {
                    self.named.insert(NAMED[0]);
                }
                let of = u64::from(status.stop_action) << 4 | u64::from(status.stop_cause);
                self.now.statuses = replaced(self.now.statuses, arm, of);
            }
            Seen::Decision(decision) => {
                self.now.outcome = decision.outcome;
                self.name(11, decision.placed_count > 0);
                self.name(12, decision.outcome == Outcome::Done.code());
                self.name(13, decision.outcome == Outcome::Failed.code());
            }
            Seen::Trace(line) => {
                let text = line.text.as_str();
                self.name(14, text.contains("resumed from its checkpoint"));
                self.name(15, text.contains("resumed where physics resumed"));
            }
            Seen::News(news) => self.news(news),
            Seen::GaveUp(_) => self.name(21, true),
            _ => return,
        }
        self.combine();
    }

    fn name(&mut self, place: usize, is_reached: bool) {
        if is_reached {
            self.named.insert(NAMED[place]);
        }
    }

    fn state(&mut self, state: &WorldState) {
        let panel = &state.panel;
        self.now.flags = state.flags | panel.task_paused << 8;
        for (arm, of) in state.arms().iter().enumerate() {
            self.name(1, of.stop_action == StopAction::Hold.code());
            self.name(2, of.stop_action >= StopAction::Stop1.code());
            self.name(10, of.gripper.held_object > 0);
            let holds = u64::from(of.gripper.held_object > 0) << 3 | u64::from(of.fault) << 4;
            self.now.arms = replaced(self.now.arms, arm, u64::from(of.stop_action) | holds);
        }
        self.name(3, state.has(FLAG_PAUSED));
        self.name(4, state.has(FLAG_LOCKSTEP) && !state.has(FLAG_ENDING));
        self.name(5, state.resumed_tick > 0);
        self.name(6, state.header.generation > 1 && state.resumed_tick == 0);
        self.name(7, panel.scene_reset > 0);
        self.name(8, panel.task_reset > 0);
        self.name(9, panel.task_paused > 0);
    }

    fn news(&mut self, news: &News) {
        match news {
            News::Began(process, _) => self.now.works |= bit(*process),
            News::Gone(process, _, exit) => {
                self.now.works &= !bit(*process);
                self.name(20, matches!(exit, Exit::Code(code) if *code != 0));
            }
            News::Warned(text) | News::Logged(_, text) => {
                let kinds = [
                    " hangs: ",
                    "too little processor time",
                    "KiB free",
                    "is not saved",
                ];
                let kind = kinds.iter().position(|kind| text.contains(kind));
                if let Some(kind) = kind {
                    self.name(16 + kind, true);
                    self.now.told = 1 + kind as u64;
                }
            }
            News::Meets(..) => self.name(22, true),
            News::Spawned(..) | News::Signalled(..) | News::Stopped(..) | News::Disturbed(_) => {}
        }
    }

    fn combine(&mut self) {
        let (before, before_hash) = self.before;
        let now = &self.now;
        if *now == before {
            return;
        }
        let parts = [
            u64::from(now.flags),
            now.arms,
            now.statuses,
            u64::from(now.outcome),
            now.works,
            now.told,
        ];
        let hash = parts.iter().fold(0, |hash, part| noise(hash, *part, 0));
        self.bits.insert(hash % BITS);
        // How it came there, too.
        self.bits.insert(noise(hash, before_hash, 1) % BITS);
        self.before = (*now, hash);
    }
}

/// `all` with the eight bits of `place` set to `value`.
fn replaced(all: u64, place: usize, value: u64) -> u64 {
    let shift = 8 * (place % 8);
    all & !(0xff << shift) | (value & 0xff) << shift
}

fn bit(process: ipc_types::topic::Process) -> u64 {
    use ipc_types::topic::Process;
    match process {
        Process::Physics => 1,
        Process::Task => 2,
        Process::Monitor => 4,
        Process::Controller(arm) => 8 << (arm % 8),
    }
}
