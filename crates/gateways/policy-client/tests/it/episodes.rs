//! Whole episodes of a cell whose policy is a server.

use std::sync::atomic::Ordering;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};

use cell_model::runs::policy_server::PolicyServer;
use cell_model::{Cell, Data};
use cell_run::spec::RunSpec;
use cell_run::summary::{RunOutcome, RunSummary};
use cell_sim::action::action_of;
use cell_sim::eval::template;
use cell_sim::gateway::Gateway as _;
use cell_sim::{OneProcess, Program, run};
use controller_proc::Controllers;
use policy_client::PolicyServers;
use rmpv::Value;

use crate::server::{Reply, numbers, openpi, rows, vla_eval};

pub(crate) fn program() -> Program {
    Program {
        policies: PolicyServers.policies(demos::policies()),
        controllers: Controllers::default(),
        gateways: Vec::new(),
        data: Data::checkout(),
    }
}

fn spec(demo: &str, address: &str, server: PolicyServer) -> RunSpec {
    RunSpec {
        policy_server: Some(server),
        seed: 3,
        ..template(demo, address)
    }
}

/// An episode of `cube`, of at most `limit_s`.
pub(crate) fn cube(address: &str, server: PolicyServer, limit_s: f64) -> RunSummary {
    let spec = RunSpec {
        time_limit_s: Some(limit_s),
        ..spec("cube", address, server)
    };
    run::to_the_end(&program(), &spec, |_| {}).unwrap()
}

/// Height above the cube and the mark to which the arm is sent first (m).
const HIGH_M: f32 = 0.12;
/// Farthest target from the TCP, for each step (m).
const STEP_M: f32 = 0.03;

/// What a person would write: above the cube, down, close, up, above the mark, down, open.
pub(crate) fn put_it_on_the_mark(seen: &Value) -> Vec<Vec<f32>> {
    let [pos, world] = ["agent_pos", "environment_state"].map(|name| numbers(seen, name));
    let tcp = [pos[0], pos[1], pos[2]];
    let (cube, mark) = (
        [world[0], world[1], world[2]],
        [world[3], world[4], world[5]],
    );
    let plane = |one: [f32; 3], other: [f32; 3]| (one[0] - other[0]).hypot(one[1] - other[1]);
    let above = |at: [f32; 3]| [at[0], at[1], at[2] + HIGH_M];
    let (aim, close) = if plane(cube, mark) < 0.02 && cube[2] < mark[2] + 0.004 {
        ([tcp[0], tcp[1], 0.2], 0.0)
    } else if pos[7] > 0.5 {
        match plane(tcp, mark) {
            side if side < 0.02 => (mark, if tcp[2] < mark[2] + 0.006 { 0.0 } else { 1.0 }),
            _ if tcp[2] > 0.08 => (above(mark), 1.0),
            _ => ([tcp[0], tcp[1], HIGH_M + STEP_M], 1.0),
        }
    } else {
        match plane(tcp, cube) {
            side if side < 0.008 => (cube, if tcp[2] < cube[2] + 0.008 { 1.0 } else { 0.0 }),
            side if side > 0.05 || tcp[2] > 0.08 => (above(cube), 0.0),
            _ => (cube, 0.0),
        }
    };
    // From where it was sent, unless that is far away: an answer is older than its action.
    let sent = [pos[3], pos[4], pos[5]];
    let off = [0, 1, 2].map(|axis| sent[axis] - tcp[axis]);
    let far = off.iter().map(|part| part * part).sum::<f32>().sqrt();
    let mut at = if far < 0.08 { sent } else { tcp };
    let row = |_| {
        let off = [0, 1, 2].map(|axis| aim[axis] - at[axis]);
        let far = off.iter().map(|part| part * part).sum::<f32>().sqrt();
        let share = (STEP_M / far.max(1.0e-6)).min(1.0);
        at = [0, 1, 2].map(|axis| at[axis] + off[axis] * share);
        vec![at[0], at[1], at[2], close]
    };
    (0..8).map(row).collect()
}

#[test]
fn a_server_does_the_job_with_and_without_latency_and_repeats() {
    let server = openpi(|_, seen| Reply::Bytes(rows(&put_it_on_the_mark(seen))));
    let mut times = Vec::new();
    for latency_ms in [0, 200] {
        let with = || PolicyServer {
            latency_ms,
            ..PolicyServer::default()
        };
        let one = cube(&server.address, with(), 60.0);
        assert_eq!(one.outcome, RunOutcome::Done, "{one:?}");
        assert_eq!(one.placed, ["cube"]);
        assert_eq!(one.policy, server.address);
        let other = cube(&server.address, with(), 60.0);
        let facts = |run: &RunSummary| (run.state_hash.clone(), run.policy_server.clone().unwrap());
        assert_eq!(facts(&one), facts(&other));
        times.push((one.sim_time_s, facts(&one).1.stale_steps));
    }
    assert_eq!(times[0].1, 0);
    assert!(times[0] < times[1], "{times:?}");
}

#[test]
fn a_server_of_vla_eval_is_asked_in_its_own_way() {
    let (kinds, told) = channel();
    let act = |payload: &Value| {
        let entries = payload.as_map().unwrap().iter();
        let keys: Vec<&str> = entries.map(|(key, _)| key.as_str().unwrap()).collect();
        assert_eq!(
            keys,
            ["states", "environment_state", "images", "task_description"]
        );
        // Stays where it is.
        let seen = numbers(payload, "states");
        vec![vec![seen[0], seen[1], seen[2], 0.0]]
    };
    let server = vla_eval(act, kinds);
    let run = cube(&server.address, PolicyServer::default(), 0.5);
    assert_eq!(run.outcome, RunOutcome::Timeout, "{run:?}");
    let told: Vec<String> = told.iter().take(4).collect();
    assert_eq!(
        told,
        ["hello", "episode_start", "observation", "observation"]
    );
}

type Answer = Box<dyn Fn() -> Reply + Send + Sync>;

#[test]
fn what_a_server_does_wrong_ends_the_episode_with_a_reason() {
    let action = |width: usize, value: f32| Reply::Bytes(rows(&[vec![value; width]]));
    let cases: Vec<(Answer, &str, &str)> = vec![
        (
            Box::new(|| Reply::Close),
            "policy_connection_lost",
            "has ended",
        ),
        (
            Box::new(|| Reply::Text("Traceback: no GPU".into())),
            "policy_error",
            "no GPU",
        ),
        (
            Box::new(|| Reply::Bytes(vec![0x93, 1])),
            "policy_answer_invalid",
            "not MessagePack",
        ),
        (
            Box::new(move || action(4, f32::NAN)),
            "policy_answer_invalid",
            "finite",
        ),
        (
            Box::new(move || action(5, 0.0)),
            "policy_answer_invalid",
            "has 5 numbers; 4",
        ),
        (
            Box::new(move || action(8, 0.3)),
            "policy_answer_invalid",
            "the length",
        ),
        (
            Box::new(move || action(4, 1.0e6)),
            "policy_answer_invalid",
            "beyond 100 m",
        ),
        (
            Box::new(|| Reply::Bytes(vec![0; policy_client::MAX_MESSAGE_BYTES + 1])),
            "policy_answer_invalid",
            "too large",
        ),
    ];
    for (answer, reason, words) in cases {
        let server = openpi(move |_, _| answer());
        let run = cube(&server.address, PolicyServer::default(), 5.0);
        assert_eq!(run.outcome, RunOutcome::Failed);
        assert_eq!(run.reason.as_deref(), Some(reason), "{run:?}");
        let message = run.message.unwrap();
        assert!(message.contains(words), "{message}");
    }
    let run = cube("ws://127.0.0.1:9", PolicyServer::default(), 5.0);
    assert_eq!(run.reason.as_deref(), Some("policy_unreachable"));
}

#[test]
fn the_actions_of_a_data_set_give_its_states_again() {
    let (demo, ticks) = ("franka-stack", 6000);
    let cell = Cell::load(&Data::checkout(), demo, 3, None).unwrap();
    let recorded = RunSpec {
        action_hz: Some(20),
        frame_hash: Vec::new(),
        policy_server: None,
        seed: 3,
        ..template(demo, &cell.default_policy)
    };
    let mut teacher = OneProcess::new(&demos::policies(), &recorded, cell).unwrap();
    let mut actions: Vec<Vec<f32>> = Vec::new();
    while teacher.state().header.tick < ticks {
        if teacher.state().header.tick.is_multiple_of(50) {
            actions.push(action_of(&teacher.decision().goals[0]).unwrap().to_vec());
        }
        teacher.tick().unwrap();
    }
    let server = openpi(move |number, _| {
        let next = actions.get(usize::try_from(number).unwrap());
        next.map_or(Reply::Close, |row| {
            Reply::Bytes(rows(std::slice::from_ref(row)))
        })
    });
    let names = [("agent_pos".to_owned(), "observation/state".to_owned())];
    let with = PolicyServer {
        names: names.into(),
        ..PolicyServer::default()
    };
    let spec = spec(demo, &server.address, with);
    let cell = spec.load_cell_of(&Data::checkout()).unwrap();
    let mut student = OneProcess::new(&program().policies, &spec, cell).unwrap();
    while student.state().header.tick < ticks {
        student.tick().unwrap();
    }
    assert_eq!(student.state().state_hash, teacher.state().state_hash);
}

/// Keys of a request, and the first number of its state.
type Seen = (Vec<String>, f32);

#[test]
fn observations_have_the_names_of_the_file_and_their_faults() {
    let seen: Arc<Mutex<Vec<Seen>>> = Arc::default();
    let see = seen.clone();
    let server = openpi(move |number, request| {
        let keys = request.as_map().unwrap().iter();
        let keys = keys
            .map(|(key, _)| key.as_str().unwrap().to_owned())
            .collect();
        let state = numbers(request, "observation/state");
        see.lock().unwrap().push((keys, state[0]));
        // To the side, so that each observation differs.
        let x = 0.4 + 0.01 * number as f32;
        Reply::Bytes(rows(&[vec![x, 0.0, 0.4, 0.0]]))
    });
    let with = |fault: Option<&str>| PolicyServer {
        names: [("agent_pos", "observation/state"), ("prompt", "prompt")]
            .map(|(ours, theirs)| (ours.to_owned(), theirs.to_owned()))
            .into(),
        fault: fault.map(|fault| fault.parse().unwrap()),
        ..PolicyServer::default()
    };
    let run = |fault| {
        seen.lock().unwrap().clear();
        cube(&server.address, with(fault), 1.0);
        seen.lock().unwrap().clone()
    };
    let well = run(None);
    assert_eq!(well[3].0, ["observation/state", "prompt"]);
    assert!(well.windows(2).all(|pair| pair[0].1 != pair[1].1));
    let dropped = run(Some("drop@300..450"));
    // Steps 6 to 8 get the observation of step 5.
    let values: Vec<f32> = dropped.iter().map(|(_, value)| *value).collect();
    assert_eq!(
        values[..6],
        well[..6].iter().map(|(_, v)| *v).collect::<Vec<_>>()
    );
    assert!(
        values[6..9].iter().all(|value| *value == values[5]),
        "{values:?}"
    );
    assert_ne!(values[9], values[8]);
    let late = run(Some("late:100@200..10000"));
    assert_eq!(late[4].1, well[2].1);
}

#[test]
fn wrong_names_and_addresses_are_refused_before_anything_runs() {
    let refusal = |demo: &str, address: &str, server: PolicyServer| {
        let spec = spec(demo, address, server);
        let cell = spec.load_cell_of(&Data::checkout()).unwrap();
        program()
            .policies
            .task(&cell, address)
            .err()
            .unwrap()
            .to_string()
    };
    let names = [("pixels/side".to_owned(), "image".to_owned())];
    let with = PolicyServer {
        names: names.into(),
        ..PolicyServer::default()
    };
    let error = refusal("cube", "ws://localhost:1", with);
    assert!(error.contains("'pixels/side' is no observation"), "{error}");
    let error = refusal("cube", "wss://localhost:1", PolicyServer::default());
    assert!(error.contains("starts with ws://"), "{error}");
    let error = refusal(
        "ur10-palletize",
        "ws://localhost:1",
        PolicyServer::default(),
    );
    assert!(error.contains("the kind 'palletize' has none"), "{error}");
    let with = PolicyServer {
        fault: Some("move:side:0,0,1@0..5".parse().unwrap()),
        ..PolicyServer::default()
    };
    let error = refusal("cube", "ws://localhost:1", with);
    assert!(error.contains("no camera 'side'"), "{error}");
}

#[test]
fn a_task_that_is_restarted_asks_again_and_goes_on_with_its_chunk() {
    let server = openpi(|_, seen| Reply::Bytes(rows(&put_it_on_the_mark(seen))));
    let spec = spec("cube", &server.address, PolicyServer::default());
    let cell = spec.load_cell_of(&Data::checkout()).unwrap();
    let mut sim = OneProcess::new(&program().policies, &spec, cell).unwrap();
    let mut restarts = 0;
    while sim.tick().unwrap() && sim.state().header.tick < 20_000 {
        if sim.state().header.tick.is_multiple_of(970) {
            sim.restart_task().unwrap();
            restarts += 1;
        }
        if sim.decision().placed_count == 1 && sim.task_restarts() > 3 {
            break;
        }
    }
    assert_eq!(sim.decision().placed_count, 1);
    assert!(restarts > 3);
    let asked = server.requests.load(Ordering::Relaxed);
    assert!(asked > 10, "{asked}");
}
