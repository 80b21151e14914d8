//! The one interface every kind of policy has.

use behavior::{Graph, NodeStatus};
use ipc_types::Text;

use crate::job::Job;
use crate::observation::Observation;
use crate::output::Output;

/// A pure decision maker: what it says depends on the observations since its
/// reset and on nothing else, and all it remembers is in its record.
pub trait Policy: Send {
    /// Name on the command line.
    fn name(&self) -> &'static str;

    /// Begins anew.
    fn reset(&mut self);

    /// One decision, every [`ipc_types::DECISION_TICKS`] ticks. `out` comes
    /// empty: an arm that is not spoken for holds and keeps its gripper.
    fn tick(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output);

    /// What its equipment goes on doing while the operator leads the arm and after
    /// the job was given up: a belt has to stop where a bin waits.
    fn tend(&self, _observation: &Observation<'_>, _job: &mut Job) {}

    /// Name of the phase it is in, empty between transfers.
    fn phase(&self) -> Text<32>;

    /// Its pictures: one per tree, machine or arm, always in this order.
    fn describe(&self) -> Vec<Graph>;

    /// Appends how the nodes of picture `graph` stand, one for each.
    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>);

    /// What it remembers beyond the [`Job`]; see [`Policy::restore`].
    fn save(&self) -> Vec<u8>;

    /// Takes back what [`Policy::save`] gave.
    ///
    /// # Errors
    /// When `record` is not of this policy.
    fn restore(&mut self, record: &[u8]) -> Result<(), bincode::Error>;

    /// Whether the operator's targets are its job: then a pause does not take
    /// the arm from it.
    fn follows_operator(&self) -> bool {
        false
    }

    /// Compares what it believes with what is seen: after missed decisions,
    /// after the operator led the arm, at a start with something in the hand,
    /// and when it takes over a `job` of another kind of policy.
    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output);
}
