//! What can be changed about a cell while it runs: breakpoints, speed, joint targets.

use robocell_tests::cell::TestCell;

#[test]
fn a_breakpoint_pauses_and_speed_and_joints_can_be_set() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--speed", "max", "--paused"]);
    cell.wait_up();
    let said = cell.ask(&["break", "LIFT"]);
    assert_eq!(said.code, 0, "{said:?}");
    let said = cell.ask(&["break", "LIFTX"]);
    assert!(
        said.code == 3 && said.stderr.contains("did you mean `LIFT`?"),
        "{said:?}"
    );
    assert_eq!(cell.ask(&["break"]).stdout, "LIFT\n");
    assert_eq!(cell.ask(&["resume"]).code, 0);
    let paused = |status: &serde_json::Value| status["paused"] == true && status["phase"] == "LIFT";
    cell.wait_status("a pause at LIFT", paused);
    let at_break = cell.status().expect("a status");
    assert_eq!(at_break["arms"][0]["holds"], "red_cube", "{at_break}");
    let why = (&at_break["pause_cause"], &at_break["breakpoint"]);
    assert_eq!(why, (&"breakpoint".into(), &"LIFT".into()), "{at_break}");
    let said = cell.ask(&["status"]);
    assert!(
        said.stdout.contains(", paused by breakpoint LIFT;"),
        "{said:?}"
    );

    // The next time it is reached is for the next cube.
    assert_eq!(cell.ask(&["resume"]).code, 0);
    let later = |status: &serde_json::Value| paused(status) && status["tick"] != at_break["tick"];
    cell.wait_status("a pause at the next LIFT", later);
    assert_eq!(cell.ask(&["break", "--remove", "LIFT"]).code, 0);
    let said = cell.ask(&["break", "--remove", "LIFT"]);
    assert!(said.stderr.contains("no breakpoint is named"), "{said:?}");

    // From lockstep to real time, to slow motion and back, with the cube in the hand.
    for speed in ["1", "0.5", "max"] {
        assert_eq!(cell.ask(&["speed", speed]).code, 0, "{speed}");
        assert_eq!(cell.ask(&["resume"]).code, 0);
        let before = cell.status().expect("a status")["tick"]
            .as_u64()
            .expect("a tick");
        cell.wait_status("more ticks", |status| {
            status["tick"].as_u64() > Some(before + 100)
        });
    }
    let said = cell.ask(&["speed", "0"]);
    assert!(
        said.code == 2 && said.stderr.contains("max, or a factor"),
        "{said:?}"
    );

    assert_eq!(cell.ask(&["task", "pause"]).code, 0);
    let joints = ["0.1", "-0.5", "0", "-2", "0", "1.5", "0.7"];
    let said = cell.ask(&[&["joints"], &joints[..]].concat());
    assert!(said.stdout.contains("joint target reached"), "{said:?}");
    let said = cell.ask(&["joints", "0", "0", "9", "0", "0", "0", "0"]);
    assert!(
        said.code == 3 && said.stderr.contains("joint 3 is 9.0000; allowed are"),
        "{said:?}"
    );
    let status = cell.status().expect("a status");
    assert_eq!(status["limit_violations"], 0, "{status}");
}
