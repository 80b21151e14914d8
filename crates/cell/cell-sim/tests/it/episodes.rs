//! Episodes that end badly do not end the others.

use std::sync::{Arc, Mutex};

use cell_model::cells::script;
use cell_model::cells::sweep::Sweep;
use cell_run::spec::RunSpec;
use cell_run::summary::RunOutcome;
use cell_sim::episodes::{self, Episodes};
use cell_sim::run::{self, RunMessage};
use cell_sim::{Program, eval};

use robocell_task::job::Job;
use robocell_task::registry::Kind;
use robocell_task::settings::NoSettings;
use robocell_task::{Observation, Outcome, Output, Policies, Policy, TraceEvent, boxed};

/// Is done at once; with a seed that is a multiple of three it panics, and with one more it
/// never ends.
struct Moody(u64);

impl Policy for Moody {
    type Memory = ();

    fn decide(&self, (): &mut (), _: &Observation<'_>, _: &mut Job, out: &mut Output) {
        match self.0 % 3 {
            0 => panic!("seed {} is a multiple of three", self.0),
            1 => {}
            _ => out.outcome = Outcome::Done,
        }
    }
}

#[test]
fn an_episode_that_panics_or_times_out_is_reported_and_the_others_run() {
    let kind =
        Kind::<NoSettings>::new("reach").policy("follow", |_, cell| Ok(boxed(Moody(cell.seed))));
    let program = Program {
        policies: Policies::new().with(kind),
        ..crate::program()
    };
    let spec = RunSpec {
        time_limit_s: Some(0.1),
        seed: 2,
        ..eval::template("reach", "follow")
    };
    let cases = episodes::cases(&program, &spec, Sweep::default()).unwrap();
    let ended = Arc::new(Mutex::new(Vec::new()));
    let all = Episodes {
        program: &program,
        spec: &spec,
        record: None,
        jobs: 2,
        stop: &|| false,
    };
    all.run((1..=6).map(|seed| cases.case(seed, 0)), &|one| {
        let result = one.result.map(|summary| summary.outcome);
        ended.lock().unwrap().push((one.case.seed, result));
        true
    });
    let mut ended = ended.lock().unwrap().clone();
    ended.sort_by_key(|(seed, _)| *seed);
    let panicked = |seed| Err(format!("panic: seed {seed} is a multiple of three"));
    let (done, timeout) = (Ok(RunOutcome::Done), Ok(RunOutcome::Timeout));
    let expected = [
        (1, timeout.clone()),
        (2, done.clone()),
        (3, panicked(3)),
        (4, timeout),
        (5, done),
        (6, panicked(6)),
    ];
    assert_eq!(ended, expected);
}

/// Gives up in its first decision.
struct GivesUp;

impl Policy for GivesUp {
    type Memory = ();

    fn decide(&self, (): &mut (), _: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let why = format_args!("[fault] job.py:7: in decide: the camera is not calibrated");
        out.event(TraceEvent::Fault, why);
        job.fail("policy_raised");
    }
}

#[test]
fn a_job_that_fails_in_its_first_decision_says_why() {
    let kind = Kind::<NoSettings>::new("reach").policy("follow", |_, _| Ok(boxed(GivesUp)));
    let program = Program {
        policies: Policies::new().with(kind),
        ..crate::program()
    };
    let spec = RunSpec {
        script: script::parse(r#"{"at_s": 0, "do": "kill", "process": "task"}"#, "s").unwrap(),
        ..eval::template("reach", "follow")
    };
    let mut said = Vec::new();
    let summary = run::to_the_end(&program, &spec, |one| {
        if let RunMessage::Line(_, line) = one {
            said.push(line.to_owned());
        }
    });
    let summary = summary.unwrap();
    let why = "job.py:7: in decide: the camera is not calibrated";
    assert!(said.contains(&format!("[fault] {why}")), "{said:?}");
    assert_eq!(summary.message.as_deref(), Some(why), "{summary}");
    assert!(summary.to_string().contains(why), "{summary}");
}

#[test]
fn a_run_that_its_script_paused_says_so() {
    let spec = RunSpec {
        script: script::parse(r#"{"at_s": 0.2, "do": "pause"}"#, "s").unwrap(),
        ..eval::template("reach", "follow")
    };
    let mut warnings = Vec::new();
    let summary = run::to_the_end(&crate::program(), &spec, |one| {
        if let RunMessage::Warning(warning) = one {
            warnings.push(warning.to_owned());
        }
    });
    let message = summary.unwrap().message.unwrap();
    assert!(
        message.contains("the script paused the cell at 0.2"),
        "{message}"
    );
    assert_eq!(warnings, [message]);
}
