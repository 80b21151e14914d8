//! Communication between the processes of a cell: iceoryx2 ports with the rules of the cell.
//!
//! The launcher's [`Keeper`] creates every service of a run; processes [`Bus::join`] and open
//! the topics that the table in [`ipc_types::topic`] gives them. A [`Publisher`] writes a
//! message in place and never blocks. A [`Subscriber`] takes the newest message, drops and
//! counts those of an older start of the writer and invalid ones, and keeps the last good one.
//! A [`Gate`] keeps a message back until the tick from which it may be used.
//!
//! A model of a cell has the same ports in one thread, without processes: [`Bus::in_memory`].
//!
//! A bus and its ports stay on the thread that made them; another thread joins
//! for itself.

#![forbid(unsafe_code)]

mod bell;
mod bus;
mod cleanup;
mod error;
mod factory;
mod fence;
mod gate;
mod hidden;
mod identity;
mod keeper;
mod memory;
mod message;
mod operator;
mod ports;
mod publisher;
mod qos;
mod reader;
mod shared;
mod site;
mod subscriber;
mod writer;

pub use bell::{Doorbell, Sleeper};
pub use bus::Bus;
pub use cleanup::{HalfMade, preflight, remove_half_made, segments, wipe};
pub use error::{BusError, PublishError, RequestError};
pub use fence::Counts;
pub use gate::Gate;
pub use keeper::Keeper;
pub use memory::{Disturbance, Kept, MemorySite};
pub use message::TopicMessage;
pub use operator::{Answered, OperatorClient, OperatorServer, PendingReply};
pub use publisher::Publisher;
pub use qos::needed_bytes;
pub use site::RunSite;
pub use subscriber::{Latest, Subscriber};
