//! Runs controllers and task again on what was recorded, and compares every
//! command, status and decision with what they said then, bit for bit.
//!
//! Every message names the messages it was computed from, so nothing has to be
//! guessed: a state that was skipped then is skipped now, and a decision that
//! came late comes late. Computing begins at a state record of the process and
//! ends where something was not recorded, to begin again at the next one.

mod around;
mod controller;
mod difference;
mod inputs;
mod message;
mod recording;
mod report;
mod shelf;
mod states;
mod task;

use cell_model::Cell;

use crate::Program;

pub use around::Around;
pub use difference::Difference;
pub use message::{Message, Messages, Recorded};
pub use recording::verify_file;
pub use report::{Count, Gap, Report, Verdict, Verified};

use controller::ArmCheck;
use inputs::{Checkpoints, Inputs};
use task::TaskCheck;

/// Why a recording cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The recording.
    #[error(transparent)]
    Recording(#[from] cell_record::RecordError),
    /// A controller does not fit the robot.
    #[error(transparent)]
    Controller(#[from] controller_proc::rmpflow_controller::RmpFlowError),
    /// The state record of a controller.
    #[error(transparent)]
    ControllerCheckpoint(#[from] controller_proc::checkpoint::CheckpointError),
    /// The policy.
    #[error(transparent)]
    Task(#[from] robocell_task::TaskError),
    /// The state record of the task.
    #[error(transparent)]
    TaskCheckpoint(#[from] robocell_task::CheckpointError),
}

/// Verifies what was recorded of a run of `cell` that began with `policy`.
///
/// # Errors
/// [`VerifyError`] where the recording is of another cell or another version;
/// what differs is no error, and what cannot be read is said in the report.
pub fn verify(
    program: &Program,
    cell: &Cell,
    policy: &str,
    recorded: &(impl Recorded + ?Sized),
) -> Result<Report, VerifyError> {
    let records = Checkpoints::of(recorded);
    let arms = 0..u8::try_from(cell.arms.len()).unwrap_or(u8::MAX);
    let mut run = Run {
        inputs: Inputs::default(),
        arms: arms
            .map(|arm| ArmCheck::new(cell, arm, &program.controllers))
            .collect(),
        task: TaskCheck::new(&program.policies, cell, policy),
        records,
        report: Report::default(),
    };
    for message in recorded.messages() {
        match message {
            Ok(message) => run.take(message)?,
            Err(what) => run.report.unreadable(what),
        }
    }
    run.inputs.end();
    run.go_on()?;
    Ok(run.report)
}

struct Run<'a> {
    inputs: Inputs,
    arms: Vec<ArmCheck<'a>>,
    task: TaskCheck<'a>,
    records: Checkpoints,
    report: Report,
}

impl Run<'_> {
    fn take(&mut self, message: Message) -> Result<(), VerifyError> {
        if !self.inputs.put(&message, &mut self.report) {
            return Ok(());
        }
        match message {
            Message::Command(arm, command) => {
                if let Some(check) = self.arms.get_mut(usize::from(arm)) {
                    check.offer(command);
                }
            }
            Message::Decision(decision) => self.task.offer(decision),
            _ => {}
        }
        self.go_on()
    }

    fn go_on(&mut self) -> Result<(), VerifyError> {
        let (inputs, records, report) = (&self.inputs, &self.records, &mut self.report);
        for arm in &mut self.arms {
            arm.go_on(inputs, records, report)?;
        }
        self.task.go_on(inputs, records, report)
    }
}
