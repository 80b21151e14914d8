//! What lockstep promises: all processes work with the same messages, run for run.

use ipc_types::Decision;
use ipc_types::topic::TopicId;
use robocell_tests::cell::TestCell;
use robocell_tests::program::wait_for;
use serde_json::Value;

/// Decisions to look at; physics waits for each, so few are missed.
const ENOUGH: usize = 300;

#[test]
fn every_decision_uses_the_status_of_the_tick_before_and_the_state_of_its_own() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--speed", "max", "--paused"]);
    cell.wait_up();
    let bus = cell.join();
    let mut decisions = bus
        .subscriber::<Decision>(TopicId::Decision)
        .expect("the topic");
    assert_eq!(cell.ask(&["resume"]).code, 0);
    let mut seen = 0;
    wait_for("decisions", || {
        if let Some(decision) = decisions.take().filter(|d| d.header.tick > 0) {
            let age = |topic: TopicId| {
                let inputs = decision.header.inputs().iter();
                inputs
                    .filter(|i| i.topic == topic.code())
                    .map(|i| i.age_ticks)
                    .next()
            };
            assert_eq!(age(TopicId::WorldState), Some(0), "{:?}", decision.header);
            assert_eq!(age(TopicId::ArmStatus(0)), Some(1), "{:?}", decision.header);
            seen += 1;
        }
        (seen >= ENOUGH).then_some(())
    });
}

#[test]
fn steps_that_end_on_a_decision_are_answered_and_the_cell_goes_on() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--speed", "max", "--paused"]);
    cell.wait_up();
    let time = |status: &Value| status["sim_time_s"].as_f64().unwrap_or(-1.0);
    for (steps, end_s) in [("10", 0.01), ("20", 0.03), ("1", 0.031), ("9", 0.04)] {
        assert_eq!(cell.ask(&["step", steps]).code, 0);
        cell.wait_status("the end of the steps", |status| {
            status["paused"] == true && (time(status) - end_s).abs() < 1.0e-6
        });
    }
    assert_eq!(cell.ask(&["resume"]).code, 0);
    cell.wait_status("a cell that continues", |status| time(status) > 1.0);
}
