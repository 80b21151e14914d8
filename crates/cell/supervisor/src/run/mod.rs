//! One cell from its first process to its end.

mod bus_thread;
mod disturbances;
mod end;
mod faults;
mod half_made;
mod incident;
mod live;
pub mod machine;
pub mod plan;
mod planning;
pub mod policy;
pub mod preflight;
pub mod recording;
pub mod room;
mod standstill;
mod starvation;
pub mod supervisor_loop;
mod watch;
mod wish;

pub use disturbances::Disturbances;
pub use end::End;
pub use live::LiveCell;
pub use watch::{News, Watch};
