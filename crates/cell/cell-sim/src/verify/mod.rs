//! Runs controllers and task a second time on the recorded inputs, and compares every command,
//! status and decision with the recorded one, bit for bit.
//!
//! Every message names the messages that it was computed from, so nothing is guessed: a state
//! that the process skipped is skipped here, and a decision that was late is late here.
//! Computing starts at a state record of a process, ends where an input was not recorded, and
//! starts again at the next record.
//!
//! What can go wrong: a false SAME hides a defect, and a false DIFFERENT makes people distrust
//! the tool. The rules that prevent both:
//!
//! - Nothing is compared whose inputs are not all recorded; it counts as skipped. The verdict
//!   is `Nothing` if all was skipped, never `Same`.
//! - Where a state record differs, computing continues from the recorded one, so that one error
//!   does not make every later message different.
//! - A decision made from a state whose objects are not all recorded is a doubt first. It
//!   becomes a difference only if those objects were at rest (`states`).
//! - Duplicates, which a restarted recorder writes, are ignored; gaps are listed.
//!
//! A change must compare whole messages as bytes: a list of fields would miss a new one.

mod around;
mod controller;
mod difference;
mod inputs;
mod message;
mod message_window;
mod recording;
mod report;
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
    /// The policy was a server.
    #[error(
        "the policy of this recording is a server, whose answers are not recorded; keep them with --keep-answers, and run the scene again with --answers"
    )]
    Server,
    /// The state record of a controller is damaged or of another version.
    #[error(transparent)]
    ControllerCheckpoint(#[from] controller_proc::checkpoint::CheckpointError),
    /// An arm has a client, and this program has no gateway for it.
    #[error(
        "client programs command the arm '{0}', and this task program has no gateway for them; pass \
         robocell_gateways::all() to main_with"
    )]
    NoGateway(String),
    /// The gateway of a client cannot continue from a checkpoint.
    #[error(transparent)]
    Gateway(crate::gateway::GatewayError),
    /// The policy.
    #[error(transparent)]
    Task(#[from] robocell_task::TaskError),
    /// The state record of the task is damaged or of another version.
    #[error(transparent)]
    TaskCheckpoint(#[from] robocell_task::CheckpointError),
}

/// Verifies the recording of a run of `cell` that started with `policy`.
///
/// # Errors
/// Returns [`VerifyError`] if the recording is of another cell or another version. Differences
/// are not errors, and messages that cannot be read are listed in the report.
pub fn verify(
    program: &Program,
    cell: &Cell,
    policy: &str,
    recorded: &(impl Recorded + ?Sized),
) -> Result<Report, VerifyError> {
    // Records first, in a pass of their own: a record is written about once a second and may
    // follow the messages that start from it.
    let records = Checkpoints::of(recorded);
    let arms = 0..u8::try_from(cell.arms.len()).unwrap_or(u8::MAX);
    let mut run = Run {
        inputs: Inputs::default(),
        arms: arms.map(|arm| ArmCheck::new(program, cell, arm)).collect(),
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
    // What still waits for an input is settled now: skipped, not silently dropped.
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
        // A duplicate was compared already.
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
