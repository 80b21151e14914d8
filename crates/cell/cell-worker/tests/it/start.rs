//! The exit code tells the launcher whether another start can help.

use std::fmt;
use std::process::ExitCode;

use cell_worker::RunError;

use crate::run::Run;

/// Exit codes for the launcher: nothing can be done by another start, or it can.
const CONFIGURATION: u8 = 3;
const FAILED: u8 = 1;

#[derive(Debug)]
struct Ends {
    lasting: bool,
}

impl fmt::Display for Ends {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("it ends")
    }
}

impl RunError for Ends {
    fn is_lasting(&self) -> bool {
        self.lasting
    }
}

#[track_caller]
fn assert_code(code: ExitCode, expected: u8) {
    // `ExitCode` has no other comparison.
    assert_eq!(
        format!("{code:?}"),
        format!("{:?}", ExitCode::from(expected))
    );
}

#[test]
fn a_process_gets_its_run_its_cell_and_its_number() {
    let run = Run::new("gets");
    let code = run.main(|start| {
        assert_eq!((start.spec.run, start.spec.seed), (run.spec.run, 3));
        assert_eq!((start.generation, start.arm), (2, 1));
        assert_eq!((start.cell.name.as_str(), start.cell.seed), ("reach", 3));
        // Neither was asked for, so no class is changed.
        assert!(!start.real_time(50, 0) && !start.real_time_priority(50));
        Ok::<(), Ends>(())
    });
    assert_code(code, 0);
}

#[test]
fn an_error_that_may_pass_asks_for_another_start_and_a_lasting_one_does_not() {
    let run = Run::new("ends");
    assert_code(run.main(|_| Err(Ends { lasting: false })), FAILED);
    assert_code(run.main(|_| Err(Ends { lasting: true })), CONFIGURATION);
}

#[test]
fn wrong_arguments_and_files_are_not_tried_again() {
    let never = |_: &cell_worker::Start| -> Result<(), Ends> { panic!("it runs") };
    let start = |words: &[&str]| {
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        cell_worker::main_of("test-proc", &words, never)
    };
    assert_code(start(&[]), CONFIGURATION);
    assert_code(
        start(&["--spec", "/nowhere/run.json", "--generation", "1"]),
        CONFIGURATION,
    );
    // A launcher of another build, and a cell that is not there.
    let mut other = Run::new("other");
    other.spec.contract = "0.0.1 (messages 0)".to_owned();
    other.save();
    assert_code(other.main(never), CONFIGURATION);
    let mut missing = Run::new("missing");
    missing.spec.demo = "reech".to_owned();
    missing.save();
    assert_code(missing.main(never), CONFIGURATION);
}
