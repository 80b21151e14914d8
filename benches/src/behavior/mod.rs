//! The cost of behaviours: a tick of a tree, an event of a machine and of a matrix, a
//! checkpoint; and the same work in other libraries, in turns within one run. `robocell bench
//! behavior` starts it.

mod bonsai;
mod instructions;
mod machines;
mod matrices;
#[path = "../../../crates/core/behavior/examples/pick_place/mod.rs"]
mod pick_place;
mod rounds;
mod statig;
mod subject;
mod tasks;
mod trees;

use std::error::Error;
use std::io::stdout;

use cell_rt::priority::{self, CONTROLLER_PRIORITY};

use crate::report::Report;
use crate::versions;
use subject::Subject;

type Group = fn() -> Result<Vec<Subject>, Box<dyn Error>>;

/// The rows in their order, in groups that are set up separately.
const GROUPS: [Group; 6] = [
    trees::subjects,
    || Ok(bonsai::subjects()),
    machines::subjects,
    || Ok(statig::subjects()),
    matrices::subjects,
    tasks::subjects,
];

// For the instruction counter: one row alone, a given number of times.
pub(crate) fn only(row: &str, times: &str) -> Result<(), Box<dyn Error>> {
    let times: u64 = times.parse()?;
    for group in GROUPS {
        if let Some(subject) = group()?.iter_mut().find(|it| it.name == row) {
            (subject.work)(times);
            return Ok(());
        }
    }
    Err(format!("unknown row '{row}'").into())
}

pub(crate) fn bench(json: bool) -> Result<(), Box<dyn Error>> {
    let granted = priority::request(CONTROLLER_PRIORITY, Some(0));
    let mut report = Report::new("behavior", granted.fifo, &granted.refused);
    let mut all = Vec::new();
    for group in GROUPS {
        all.extend(group()?);
    }
    report.notes.push(format!(
        "each sample is the mean of {} in a row; rows take turns",
        rounds::TIMES
    ));
    report.notes.push(versions::note(&["bonsai-bt", "statig"]));
    report.rows.extend(rounds::times(&mut all));
    report.rows.extend(rounds::allocations(&mut all));
    // Instructions are the same on a loaded machine, but need valgrind.
    match instructions::rows(&all) {
        Ok(rows) => report.rows.extend(rows),
        Err(why) => report
            .notes
            .push(format!("instructions: not measured: {why}")),
    }
    for subject in &all {
        let Some(peer) = subject.against else {
            continue;
        };
        for suffix in ["", rounds::ALLOCATIONS, instructions::SUFFIX] {
            let (own, other) = (
                format!("{}{suffix}", subject.name),
                format!("{peer}{suffix}"),
            );
            report.compare(&own, &other);
        }
    }
    report.write(&mut stdout().lock(), json)?;
    Ok(())
}
