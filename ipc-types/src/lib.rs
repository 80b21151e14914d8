//! The contract between the processes of a cell.
//!
//! Plain `repr(C)` data of fixed capacity behind one [`Header`]; no behaviour, no ports. The
//! table of writers and readers is in [`topic`]. Every message can be written and read in place
//! in shared memory: it has no padding, no pointer, and every bit pattern of it is a value, so
//! a reader that [`Validate`]s it needs nothing else to be safe.

pub mod arm;
pub mod client;
pub mod contact;
pub mod decision;
pub mod equipment;
pub mod header;
pub mod health;
pub mod layout;
#[cfg(feature = "iceoryx2")]
pub mod loan;
pub mod operator;
mod panel;
pub mod pose;
pub mod probe;
pub mod tap;
pub mod text;
pub mod topic;
pub mod trace;
pub mod validate;
mod wire;
pub mod world;

pub use arm::{ArmCommand, ArmStatus, GripperCommand};
pub use client::ClientInput;
pub use contact::Contacts;
pub use decision::{ArmGoal, Decision, GripperGoal};
pub use equipment::EquipmentState;
pub use header::{Header, Input};
pub use health::Health;
pub use operator::{OperatorReply, OperatorRequest};
pub use panel::OperatorPanel;
pub use pose::{Pose, Twist};
pub use tap::{Keyframe, WorldPiece};
pub use text::Text;
pub use trace::TraceLine;
pub use validate::{Invalid, Validate};
pub use wire::{Wire, layout_of};
pub use world::{ArmState, GripperState, ObjectState, WorldState};

/// Arms in one cell.
// Each adds to the size of a state, which is copied in every tick.
pub const MAX_ARMS: usize = 2;
/// Controlled joints of one arm.
pub const MAX_JOINTS: usize = 16;
/// Movable objects of one cell: 36 bins and 100 parts fit.
// Objects are 18 of the 20 kB of a state; more would slow down every reader.
pub const MAX_OBJECTS: usize = 160;
/// Breakpoints of one task.
pub const MAX_BREAKS: usize = 8;
/// Inputs a message can name as its cause.
// A state and two arms, twice: no process has more inputs.
pub const MAX_INPUTS: usize = 4;
/// Bytes of the name of a breakpoint.
pub const BREAK_BYTES: usize = 48;
/// Name of a node, state or guard at which the task pauses the cell.
pub type BreakName = Text<BREAK_BYTES>;
/// Length of one simulated tick in nanoseconds (1 ms).
// One cycle integrates exactly this (ADR 0003).
pub const TICK_NS: u64 = 1_000_000;
/// The same in seconds: also the length of one cycle of a controller.
// Also after a missed cycle: a longer step would break limits of the joints (ADR 0003).
pub const TICK_S: f64 = 1.0e-3;
/// The task decides on every tick that is a multiple of this (100 Hz).
// Goals are absolute, and the motion between two decisions is the controller's.
pub const DECISION_TICKS: u64 = 10;
/// Ticks physics may run ahead of the recorder in lockstep: less than any tap holds.
// The tap of states is the tightest: 160 objects are 20 of its 1,024 pieces per tenth tick.
pub const RECORDER_LAG_TICKS: u64 = 150;
