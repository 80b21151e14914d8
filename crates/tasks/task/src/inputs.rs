//! The inputs of a decision, as its header names them.

use ipc_types::topic::TopicId;
use ipc_types::{ArmStatus, Header, Input, WorldState};

/// A task that decided nothing for longer reconciles with the world (ticks).
// Ten decisions: a scheduling delay of a few is ordinary and must not make a policy
// compare its memory with the world, which may restart a pick-up.
pub const MISSED_TICKS: u64 = 100;

/// Names in `header` what a decision was made from: `state`, and of each arm the
/// status, if there was one.
pub fn name_inputs(header: &mut Header, state: &WorldState, statuses: &[Option<&ArmStatus>]) {
    // The count is reset first: a header that is reused would name inputs of the decision
    // before, and a replay would look for messages that this decision did not have.
    header.input_count = 0;
    header.push_input(Input {
        topic: TopicId::WorldState.code(),
        generation: state.header.generation,
        seq: state.header.seq,
        age_ticks: 0,
    });
    for (arm, status) in (0_u8..).zip(statuses) {
        if let Some(status) = status {
            header.push_input(Input {
                topic: TopicId::ArmStatus(arm).code(),
                generation: status.header.generation,
                seq: status.header.seq,
                // Ages are differences of ticks, not of clocks: a replay computes the same (ADR
                // 0002).
                age_ticks: state.header.tick.saturating_sub(status.header.tick),
            });
        }
    }
}
