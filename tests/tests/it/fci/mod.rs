//! The Franka control interface of a cell of four processes, in lockstep: with a client that
//! is not a real-time program. Each test has an address of its own.

mod client;

use std::net::{Ipv4Addr, TcpStream};
use std::path::Path;

use cell_record::{Channel, wire_bytes};
use ipc_types::ClientInput;
use ipc_types::client::ClientEvent;
use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{Said, finish, robocell, wait_for};
use robocell_tests::recording::{rewrite, same, verify};
use serde_json::Value;

use client::{Client, Refused};

fn address(last: u8) -> Ipv4Addr {
    Ipv4Addr::new(127, 0, 13, last)
}

fn words(at: Ipv4Addr) -> Vec<String> {
    let controller = format!("fci@{at}");
    let words = ["reach", "--robot", "fr3", "--controller", &controller];
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// A run until the first client has ended, in lockstep, and what `client` does meanwhile.
fn run(base: &Path, at: Ipv4Addr, client: impl FnOnce() + Send + 'static) -> Said {
    run_with(base, at, &[], client)
}

fn run_with(
    base: &Path,
    at: Ipv4Addr,
    more: &[&str],
    client: impl FnOnce() + Send + 'static,
) -> Said {
    let words = words(at);
    let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
    words.insert(0, "run");
    words.extend(["--headless", "--speed", "max", "--until-done", "--json"]);
    words.extend(more);
    let client = std::thread::spawn(client);
    let said = finish(robocell(base, &words));
    let is_fine = client.join().is_ok();
    assert!(is_fine, "the client failed: {}{}", said.stdout, said.stderr);
    said
}

fn summary(said: &Said) -> Value {
    serde_json::from_str(said.stdout.lines().last().unwrap_or_default()).expect("a summary")
}

#[test]
fn a_client_moves_the_arm_and_the_same_client_gives_the_same_run() {
    let at = address(1);
    let once = || {
        let base = base();
        let said = run(base.path(), at, move || {
            let mut client = Client::connect(at, 10).unwrap();
            assert!(client.model().contains("position_based_velocity_limits"));
            let from = client.state().position;
            assert_eq!((client.turn(500), client.turn(1000)), (0, 0));
            // At rest: the last command of the bell is not exactly 0.
            let state = client.state();
            assert!((state.position - from - 0.2).abs() < 1e-3, "{state:?}");
            assert!(state.velocity.abs() < 1e-6, "{state:?}");
        });
        assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
        summary(&said)
    };
    let (one, other) = (once(), once());
    assert_eq!(one["policy"], "client");
    assert_eq!(one["limit_violations"], 0);
    assert_eq!(
        (&one["ticks"], &one["state_hash"]),
        (&other["ticks"], &other["state_hash"])
    );
    assert!(one["ticks"].as_u64().unwrap() > 1500);
}

#[test]
fn what_a_client_sent_is_recorded_and_computed_again() {
    let (at, base) = (address(8), base());
    let file = base.path().join("client.mcap");
    let name = file.display().to_string();
    let said = run_with(base.path(), at, &["--record", &name], move || {
        let mut client = Client::connect(at, 10).unwrap();
        assert_eq!((client.turn(500), client.turn(1000)), (0, 0));
    });
    assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
    let report = same(&verify(base.path(), &file, &["--json"]));
    assert!(
        report["commands"]["compared"].as_u64() > Some(1500),
        "{report}"
    );
    assert_eq!(report["commands"]["skipped"], 0, "{report}");
    // Once a second its memory.
    assert!(report["records"]["compared"].as_u64() > Some(1), "{report}");
    let (altered, mut tick) = (base.path().join("altered.mcap"), 0);
    rewrite(
        &file,
        &altered,
        |_| {},
        |entry| {
            if let Channel::Client(_) = entry.channel
                && tick == 0
                && entry.tick > 1000
            {
                let mut input: ClientInput = entry.read().expect("an input");
                assert_eq!(input.event, ClientEvent::Command.code());
                // Velocity of joint 7, after the number of the state and the positions.
                input.bytes[8 + 56 + 48] ^= 1;
                entry.bytes = wire_bytes(&input).to_vec();
                tick = entry.tick;
            }
        },
    );
    let said = verify(base.path(), &altered, &["--json"]);
    let said = said.json();
    let first = &said["report"]["first_difference"];
    assert_eq!(said["verdict"], "different", "{said}");
    assert_eq!(first["message"], "command of arm 0", "{said}");
    // The cycle of the state at which it was taken.
    assert_eq!(first["tick"], tick, "{said}");
}

#[test]
fn a_reflex_fails_the_run_and_is_an_incident() {
    let (at, base) = (address(2), base());
    let said = run(base.path(), at, move || {
        let mut client = Client::connect(at, 10).unwrap();
        let mut state = client.start();
        for cycle in 0..100 {
            client.answer(&state, if cycle < 50 { 0.0 } else { 0.5 }, false);
            state = client.state();
            if state.robot_mode == 4 {
                break;
            }
        }
        assert_eq!(state.robot_mode, 4, "a reflex");
        assert_eq!(client.status(), 8);
        client.recover();
        assert_eq!(client.turn(500), 0);
    });
    assert_eq!(said.code, 5, "{}{}", said.stdout, said.stderr);
    let reason = "joint_motion_generator_velocity_discontinuity";
    assert_eq!(summary(&said)["reason"], reason);
    let told = format!("reflex {reason} in cycle 51: joint 7: 500 rad/s², limit 10");
    assert!(said.stderr.contains(&told), "{}", said.stderr);
    assert!(
        said.stderr.contains("robocell incident 1"),
        "{}",
        said.stderr
    );
}

#[test]
fn in_strict_lockstep_a_silent_client_gets_the_error_of_the_robot() {
    let (at, base) = (address(6), base());
    let said = run_with(base.path(), at, &["--strict"], move || {
        let mut client = Client::connect(at, 10).unwrap();
        let mut state = client.start();
        client.answer(&state, 0.0, false);
        while state.robot_mode != 4 {
            state = client.state();
        }
        assert_eq!(client.status(), 8);
    });
    assert_eq!(said.code, 5, "{}{}", said.stdout, said.stderr);
    let reason = "communication_constraints_violation";
    assert_eq!(summary(&said)["reason"], reason);
    assert!(
        said.stderr.contains("limit 20; answers after never x 20"),
        "{}",
        said.stderr
    );
}

#[test]
fn a_task_of_two_arms_does_its_part_without_the_arm_of_a_client() {
    let base = base();
    let controller = format!("left=fci@{}", address(7));
    let words = [
        "run",
        "franka-pyramid",
        "--controller",
        &controller,
        "--headless",
    ];
    let more = [
        "--speed",
        "max",
        "--until-done",
        "--timeout",
        "240",
        "--json",
    ];
    let said = finish(robocell(base.path(), &[&words[..], &more[..]].concat()));
    assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
    let summary = summary(&said);
    let placed = summary["placed"].as_array().map_or(0, Vec::len);
    assert_eq!(placed, 3, "{summary}");
}

#[test]
fn a_client_that_ends_in_motion_stops_the_arm_and_the_next_one_is_served() {
    let at = address(3);
    let words = words(at);
    let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
    words.extend(["--headless", "--speed", "max"]);
    let cell = TestCell::start_in(base(), &words);
    for _ in 0..5 {
        let mut client = Client::connect(at, 10).unwrap();
        let mut state = client.start();
        for cycle in 0..60 {
            client.answer(&state, 0.002 * f64::from(cycle), false);
            state = client.state();
        }
        assert!(state.velocity > 0.1, "{state:?}");
        drop(client);
        let mut next = Client::connect(at, 10).unwrap();
        wait_for("the arm is at rest", || {
            (next.state().velocity.abs() < 1e-6).then_some(())
        });
        assert_eq!(next.turn(500), 0);
    }
    // A reset while time does not pass is no reason to end the next motion.
    assert_eq!(cell.ask(&["reset"]).code, 0);
    let mut client = Client::connect(at, 10).unwrap();
    assert_eq!(client.turn(500), 0);
    let status = cell.status().expect("a status");
    assert_eq!(status["limit_violations"], 0, "{status}");
}

#[test]
fn other_versions_are_refused_by_number_and_idle_sockets_lock_nobody_out() {
    let at = address(4);
    let words = words(at);
    let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
    words.extend(["--headless", "--speed", "max"]);
    let _cell = TestCell::start_in(base(), &words);
    assert_eq!(Client::connect(at, 5).err(), Some(Refused::Version(10)));
    let idle: Vec<_> = (0..110)
        .map(|_| TcpStream::connect((at, 1337)).unwrap())
        .collect();
    let mut client = Client::connect(at, 10).unwrap();
    // A second client, while the first one has the arm.
    assert_eq!(Client::connect(at, 10).err(), Some(Refused::Closed));
    assert_eq!(client.turn(500), 0);
    drop(idle);
}

#[test]
fn the_command_line_says_what_cannot_be() {
    let base = base();
    let refused = |words: &[&str]| {
        let said = finish(robocell(
            base.path(),
            &[&["run"], words, &["--headless"]].concat(),
        ));
        assert_eq!(said.code, 3, "{}{}", said.stdout, said.stderr);
        said.stderr
    };
    let of_ur10 = refused(&["ur10-bin-stack", "--controller", "fci"]);
    assert!(of_ur10.contains("--robot fr3"), "{of_ur10}");
    let open = refused(&["reach", "--robot", "fr3", "--controller", "fci@0.0.0.0"]);
    assert!(open.contains("--fci-from-network"), "{open}");
    let which = refused(&["franka-pyramid", "--controller", "fci"]);
    assert!(which.contains("2 arms"), "{which}");
    let typo = refused(&["reach", "--robot", "fr4"]);
    assert!(typo.contains("did you mean 'fr3'"), "{typo}");
    let _taken = std::net::TcpListener::bind((address(5), 1337)).unwrap();
    let taken = refused(&["reach", "--robot", "fr3", "--controller", "fci@127.0.13.5"]);
    assert!(taken.contains("127.0.13.5:1337"), "{taken}");
    let holder = format!("(process {})", std::process::id());
    assert!(taken.contains(&holder), "{taken}");
}
