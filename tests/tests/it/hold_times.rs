//! When an arm holds after the task or its controller fell silent, read from a recording.

use cell_model::stop::{COMMAND_AGE_TICKS, DECISION_AGE_FIFO_TICKS, DECISION_AGE_OTHER_TICKS};
use cell_record::{Channel, Entry, Recording};
use ipc_types::arm::StopAction;
use ipc_types::{ArmStatus, WorldPiece};
use robocell_tests::cell::{TestCell, base};
use robocell_tests::fault::{freeze_and_wait, kill_and_wait};

/// Ages at which the arm moved on (ticks): none may be beyond its limit.
#[derive(Default)]
struct Ages {
    oldest: u64,
    holds: u32,
}

impl Ages {
    fn see(&mut self, age: u64, action: u32) {
        if action >= StopAction::Hold.code() {
            self.holds += 1;
        } else {
            self.oldest = self.oldest.max(age);
        }
    }
}

/// Of decisions as the controller saw them, and of commands as physics did.
fn ages(recording: &Recording) -> [Ages; 2] {
    let (mut decisions, mut commands) = (Ages::default(), Ages::default());
    for entry in recording.messages() {
        let entry: Entry = entry.expect("a message that can be read");
        match entry.channel {
            Channel::Status(0) => {
                let status: ArmStatus = entry.read().expect("a status");
                // Before the first decision there is no age.
                if status.decision_tick > 0 && status.decision_age_ticks < u64::MAX / 2 {
                    decisions.see(status.decision_age_ticks, status.stop_action);
                }
            }
            Channel::World => {
                let piece: WorldPiece = entry.read().expect("a piece of a state");
                let arm = &piece.arms[0];
                if piece.piece == 0 && arm.command_tick > 0 {
                    // A state tells what was done in the tick that led to it.
                    let age = (piece.state.tick - 1).saturating_sub(arm.command_tick);
                    commands.see(age, arm.stop_action);
                }
            }
            _ => {}
        }
    }
    [decisions, commands]
}

#[test]
fn a_silent_task_or_controller_means_hold_within_its_limit() {
    let base = base();
    let file = base.path().join("run.mcap");
    let shown = file.display().to_string();
    let mut cell = TestCell::start_in(base, &["franka-stack", "--headless", "--record", &shown]);
    let status = cell.wait_up();
    let fifo = status["processes"][1]["scheduling"] == "fifo";
    assert_eq!(cell.ask(&["task", "start"]).code, 0);
    freeze_and_wait(&cell, "task");
    kill_and_wait(&cell, "task");
    freeze_and_wait(&cell, "controller-0");
    kill_and_wait(&cell, "controller-0");
    let status = cell.wait_up();
    assert_eq!(status["limit_violations"], 0);
    assert_eq!(cell.ask(&["down"]).code, 0);
    cell.wait_end();
    let [decisions, commands] = ages(&Recording::open(&file).expect("a recording"));
    let limit = if fifo {
        DECISION_AGE_FIFO_TICKS
    } else {
        DECISION_AGE_OTHER_TICKS
    };
    assert!(
        decisions.holds > 0 && commands.holds > 0,
        "both were silent"
    );
    assert!(decisions.oldest <= limit, "{} ticks", decisions.oldest);
    assert!(
        commands.oldest <= COMMAND_AGE_TICKS + 1,
        "{} ticks",
        commands.oldest
    );
}
