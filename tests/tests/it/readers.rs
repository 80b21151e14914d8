//! Programs that look at a cell need a place each; what changes a cell needs none.

use ipc_types::TraceLine;
use ipc_types::topic::TopicId;
use robocell_tests::cell::{TestCell, generation};

#[test]
fn a_restart_needs_no_place_of_a_reader_and_a_view_says_how_many_there_are() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--paused"]);
    let before = cell.wait_up();
    let bus = cell.join();
    let mut readers = Vec::new();
    let refused = loop {
        match bus.subscriber::<TraceLine>(TopicId::Trace) {
            Ok(reader) => readers.push(reader),
            Err(error) => break error.to_string(),
        }
    };
    assert!(refused.contains("at most 6 readers"), "{refused}");
    let said = cell.ask(&["fsm", "show", "--live", "--once"]);
    assert_eq!(said.code, 3, "{said:?}");
    assert!(said.stderr.contains("at most 6 readers"), "{said:?}");
    // All readers of all states, too.
    let mut states = Vec::new();
    while let Ok(reader) = bus.subscriber::<ipc_types::WorldState>(TopicId::WorldState) {
        states.push(reader);
    }
    let said = cell.ask(&["restart", "task"]);
    assert_eq!(said.code, 0, "{said:?}");
    drop((readers, states));
    let said = cell.wait_status("a new task", |status| {
        generation(status, "task") > generation(&before, "task")
    });
    assert_eq!(generation(&said, "task"), generation(&before, "task") + 1);
}
