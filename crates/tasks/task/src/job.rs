//! The part of the checkpoint that all policies of a demo share: a policy of another kind
//! can continue the job from it.

use ipc_types::MAX_ARMS;
use serde::{Deserialize, Serialize};

use crate::reason::Reason;
use crate::time::PolicyTime;

/// Where an object belongs: its centre in the world frame (m) and its yaw (rad).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Centre, world frame (m).
    pub position: [f64; 3],
    /// Turn about the vertical axis (rad).
    pub yaw: f64,
}

/// What happened so far, as the decision reports it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Entries into a phase. The task counts where the name changes, a policy an
    /// entry into the phase it was in already.
    pub phase_entry: u32,
    /// Held objects that were lost.
    pub drops: u32,
    /// Pick-ups that were restarted because the object moved.
    pub resyncs: u32,
    /// Transfers turned back because the stack below was gone.
    pub aborts: u32,
    /// Recoveries of any other kind.
    pub recoveries: u32,
}

/// Upper limit of a counter in a checkpoint that is accepted; a count of one per tick
/// reaches it after twelve days.
// A larger one is damage, and adding to it could overflow.
pub const MOST_COUNTED: u32 = 1 << 30;

/// Failures of one arm with one object, in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Attempts {
    /// Pick-ups that lost it.
    pub pick: u32,
    /// Set-downs it did not stay at.
    pub place: u32,
}

/// Outputs to the cell's equipment. Counters only go up, also over a reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Io {
    /// The belt shall run.
    pub conveyor_running: bool,
    /// Requests to drop parts.
    pub drop_parts: u32,
    /// Requests for a bin.
    pub add_bin: u32,
}

/// The job as all policies of a demo see it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent facts, each true or not"
)]
pub struct Job {
    /// Object in the gripper, by index in the cell file.
    pub held: Option<usize>,
    /// Destination of the held object.
    pub destination: Option<Placement>,
    /// The held object goes back instead of onto the stack.
    pub aborted: bool,
    /// Objects where they belong, by index in the cell file.
    pub placed: Vec<u32>,
    /// By object index, and by arm: what one arm cannot grip another may.
    pub attempts: Vec<[Attempts; MAX_ARMS]>,
    /// What happened so far.
    pub counters: Counters,
    /// Why the job failed, if it did.
    pub failure: Option<Reason>,
    /// All objects were in place at the last decision.
    pub done: bool,
    /// An arm held an object when the job was done.
    pub done_holding: bool,
    /// Since when the next object of an arm is out of its reach.
    pub unreachable_since: [Option<PolicyTime>; MAX_ARMS],
    /// The start event was given, for the demos that wait for one.
    pub started: bool,
    /// Outputs to the equipment.
    pub io: Io,
    /// Key of the newest goal, in a cell with one arm.
    pub newest_key: u64,
}

impl Job {
    /// A job before its start, with room for `objects` objects.
    pub fn new(objects: usize) -> Self {
        Self {
            // The list has its full size from the start: no decision allocates memory for it.
            placed: Vec::with_capacity(ipc_types::decision::MAX_PLACED),
            attempts: vec![Default::default(); objects],
            ..Self::default()
        }
    }

    /// Restarts the job.
    pub(crate) fn reset(&mut self) {
        // Counters of requests continue over a reset: physics acts on their increase, and
        // a counter that fell to zero would lose the next requests (ADR 0001).
        let io = Io {
            conveyor_running: false,
            ..self.io
        };
        *self = Self::new(self.attempts.len());
        self.io = io;
    }

    /// Becomes `other`, keeping the memory of the lists.
    pub(crate) fn take(&mut self, other: Self) {
        // The list keeps its own memory: one from a checkpoint has no spare room, and the next
        // placed object would allocate within a decision.
        let mut placed = std::mem::take(&mut self.placed);
        placed.clear();
        placed.extend_from_slice(&other.placed);
        *self = Self { placed, ..other };
    }

    /// Gives the job up, with the stable name of the reason. The arm holds and
    /// keeps its gripper until the operator starts the task again.
    pub fn fail(&mut self, reason: &str) {
        self.failure = Some(Reason::new(reason));
    }

    /// Clears a failure and its causes, when the operator requests another attempt.
    pub(crate) fn retry(&mut self) {
        self.failure = None;
        self.unreachable_since = Default::default();
        // The attempts too: with a spent budget the first new failure would end the job again.
        self.attempts.fill(Default::default());
    }

    /// The failures of `arm` with an object.
    pub fn attempts(&self, arm: usize, object: usize) -> Attempts {
        let of = self.attempts.get(object).and_then(|arms| arms.get(arm));
        of.copied().unwrap_or_default()
    }

    /// The failures of `arm` with an object, to change.
    pub fn attempts_mut(&mut self, arm: usize, object: usize) -> Option<&mut Attempts> {
        self.attempts.get_mut(object)?.get_mut(arm)
    }

    /// Whether no counter is beyond what a run can reach: they are counted on.
    pub(crate) fn is_sound(&self) -> bool {
        let (counters, io) = (self.counters, self.io);
        // The limit is far below the type's maximum, so additions after a restore cannot wrap.
        let few = |count: u32| count < MOST_COUNTED;
        [counters.phase_entry, counters.drops, counters.resyncs]
            .into_iter()
            .chain([counters.aborts, counters.recoveries])
            .chain([io.drop_parts, io.add_bin])
            .chain(
                self.attempts
                    .iter()
                    .flatten()
                    .flat_map(|a| [a.pick, a.place]),
            )
            .all(few)
            && self.newest_key < u64::from(MOST_COUNTED)
    }

    /// Whether this record can belong to a cell with `objects` objects.
    pub(crate) fn fits(&self, objects: usize) -> bool {
        let in_range = |i: u32| (i as usize) < objects;
        // Indices out of a checkpoint are used without a further check: one of an edited cell
        // with fewer objects would address an object that does not exist.
        self.attempts.len() == objects
            && self.held.is_none_or(|i| i < objects)
            && self.placed.len() <= ipc_types::decision::MAX_PLACED
            && self.placed.iter().all(|i| in_range(*i))
    }
}
