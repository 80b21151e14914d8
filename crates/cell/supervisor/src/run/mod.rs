//! One cell from its first process to its end.

mod bus_thread;
mod end;
mod faults;
pub mod files;
mod live;
pub mod machine;
pub mod plan;
mod planning;
pub mod policy;
pub mod supervisor_loop;
mod watch;
mod wish;

pub use end::End;
pub use faults::disturbances::Disturbances;
pub use live::LiveCell;
pub use watch::{News, Watch};
