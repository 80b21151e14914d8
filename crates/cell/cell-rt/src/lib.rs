//! The operating-system interface of the programs of a cell: a clock, a periodic grid,
//! scheduling, limits and locked memory, a mapped slot file, the ring of the last cycles,
//! signals, parent death and standard output.
//!
//! Together with `ipc-types` this is the only crate with `unsafe` code: every
//! block is a call into the C library or an access to mapped memory, with its
//! reason beside it.

#![deny(unsafe_op_in_unsafe_fn)]

pub mod alloc;
pub mod black_box;
pub mod clock;
mod effects;
pub mod histogram;
pub mod hole;
pub mod limits;
pub mod lock;
pub mod memory;
mod memory_dir;
pub mod overrun;
pub mod periodic;
pub mod priority;
pub mod process;
pub mod readable;
pub mod record_file;
pub mod seqlock;
pub mod shared;
pub mod signal;
pub mod slot;
pub mod stdout;
pub mod user_dir;

pub use black_box::{BlackBox, BoxedCycle};
pub use clock::{Clock, Monotonic, monotonic_ns, sleep_until};
pub use effects::Effects;
pub use histogram::Histogram;
pub use lock::Lock;
pub use memory_dir::MemoryDir;
pub use periodic::{Grid, Wake};
pub use readable::is_readable;
pub use record_file::RecordFile;
pub use slot::{Flipped, MemoryFile, SlotFile};
pub use user_dir::user_dir;
