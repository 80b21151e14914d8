//! Cells: arms, objects, fixtures, equipment, the task's table, and scripts.

pub mod cell;
mod check_equipment;
mod check_file;
pub mod file;
pub mod replace;
pub mod script;
mod script_check;
mod script_keys;
mod script_line;
mod script_runner;
pub mod setting;
pub mod sweep;
pub mod task_table;
