//! Episodes that end badly do not end the others.

use std::sync::{Arc, Mutex};

use cell_model::cells::sweep::Sweep;
use cell_model::runs::spec::RunSpec;
use cell_model::runs::summary::RunOutcome;
use cell_sim::episodes::{self, Episodes};
use cell_sim::{Program, eval};

use robocell_task::job::Job;
use robocell_task::registry::Kind;
use robocell_task::settings::NoSettings;
use robocell_task::{Observation, Outcome, Output, Policies, Policy, boxed};

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
