//! What a command answers is what became of it.

use robocell_tests::cell::TestCell;

fn number_after(text: &str, word: &str) -> f64 {
    let rest = text
        .split(word)
        .nth(1)
        .unwrap_or_else(|| panic!("no {word:?} in {text}"));
    let rest = rest.trim_start();
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.' && c != '-');
    rest[..end.unwrap_or(rest.len())].parse().expect("a number")
}

#[test]
fn steps_add_up_and_are_done_when_they_are_answered() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--paused"]);
    cell.wait_up();
    let said = std::thread::scope(|scope| {
        let first = scope.spawn(|| cell.ask(&["step", "700"]));
        let second = scope.spawn(|| cell.ask(&["step", "301"]));
        [first, second].map(|asked| asked.join().expect("an answer"))
    });
    let reached = said.each_ref().map(|said| {
        assert_eq!(said.code, 0, "{said:?}");
        number_after(&said.stdout, "stepped to tick")
    });
    assert!(
        reached.iter().any(|tick| (*tick - 1001.0).abs() < 0.1),
        "{said:?}"
    );
    let status = cell.status().expect("a status");
    assert_eq!(status["paused"], true);
    assert!(
        (status["sim_time_s"].as_f64().expect("a time") - 1.001).abs() < 1e-9,
        "{status}"
    );
    let said = cell.ask(&["step"]);
    assert_eq!(said.stdout, "stepped to tick 1002 (1.002 s)\n");
}

#[test]
fn answers_name_the_time_the_place_and_what_is_held() {
    let cell = TestCell::start(&["franka-stack", "--headless"]);
    cell.wait_up();
    cell.wait_status("a cube in the hand", |status| {
        status["phase"] == "TRANSPORT"
    });
    let said = cell.ask(&["restart", "task"]);
    assert_eq!(said.code, 0, "{said:?}");
    for words in [
        "task is back after ",
        " ms, ",
        "cube still held, resumed from its checkpoint",
    ] {
        assert!(
            said.stdout.contains(words),
            "no {words:?} in {}",
            said.stdout
        );
    }
    let said = cell.ask(&["restart", "controller"]);
    assert!(
        said.stdout.contains("controller is back after "),
        "{said:?}"
    );
    let said = cell.ask(&["restart", "physics"]);
    let back_s = number_after(&said.stdout, ", resumed ");
    let resumed_s = number_after(&said.stdout, "s back at ");
    assert!((0.0..=1.0).contains(&back_s) && resumed_s > 0.5, "{said:?}");
    let said = cell.ask(&["task", "start"]);
    assert!(
        said.code == 0 && said.stdout.starts_with("the task runs already, in phase "),
        "{said:?}"
    );
    let said = cell.ask(&["pause"]);
    let paused_s = number_after(&said.stdout, "paused at");
    assert!(paused_s > 0.5, "{said:?}");
    let said = cell.ask(&["drag", "yellow_cube", "--to", "0.5", "-0.2", "0.03"]);
    assert!(
        said.stdout
            .contains("it is pulled when simulated time is resumed"),
        "{said:?}"
    );
    assert_eq!(cell.ask(&["resume"]).code, 0);
    let said = cell.ask(&["drag", "yellow_cube", "--to", "0.5", "-0.2", "0.03"]);
    let x = number_after(&said.stdout, "yellow_cube released at");
    assert!((x - 0.5).abs() < 0.02, "{said:?}");
}

#[test]
fn a_target_is_reached_or_it_is_said_that_it_cannot_be() {
    let cell = TestCell::start(&["reach", "--headless", "--speed", "max"]);
    cell.wait_up();
    let said = cell.ask(&["target", "0.4", "-0.1", "0.3", "180", "0", "0", "--deg"]);
    assert!(
        said.code == 0 && said.stdout.contains("target reached at"),
        "{said:?}"
    );
    let said = cell.ask(&["target", "3", "0", "0.5"]);
    assert!(
        said.code == 3 && said.stderr.contains("not reachable (unreachable): "),
        "{said:?}"
    );
    let said = cell.ask(&["target", "0.4", "-0.1", "0.3", "0", "180", "0"]);
    assert!(said.code == 2 && said.stderr.contains("--deg"), "{said:?}");
    let said = cell.ask(&["target", "0.4", "-0.1", "0.35", "--no-wait"]);
    assert!(
        said.code == 0 && said.stdout.contains("target set at"),
        "{said:?}"
    );
}
