//! What a robot, a scene, a run and a stop are; no engine, no bus.

pub mod run_spec;
pub mod script;
pub mod stop;
pub mod task_spec;
