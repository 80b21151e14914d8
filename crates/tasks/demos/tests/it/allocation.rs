//! A decision takes no memory once the task is made and its lists have grown.

use crate::common;

use common::{ALL, FakeCell};
use ipc_types::Wire;
use ipc_types::decision::Outcome;

#[test]
fn a_whole_job_is_decided_without_an_allocation() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        let status = Box::new(ipc_types::ArmStatus::zeroed());
        let mut trace = Vec::with_capacity(robocell_task::output::ROOM_FOR_LINES);
        // Lines are collected in a list that grows with the first ones.
        cell.run_until(60.0, |c| c.phase() == "APPROACH");
        let mut taken = 0;
        while cell.outcome() != Outcome::Done {
            let before = cell_rt::alloc::count();
            cell.task.decide(
                &cell.state,
                &[Some(&status)],
                &mut cell.decision,
                &mut trace,
            );
            taken += cell_rt::alloc::count() - before;
            trace.clear();
            cell.move_on();
        }
        assert_eq!(taken, 0, "{policy}");
    }
}
