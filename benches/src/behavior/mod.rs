//! The cost of behaviours: a tick of a tree, an event of a machine and of a matrix, a
//! checkpoint; and the same work in other libraries, in turns within one run. `robocell bench
//! behavior` starts it.

mod grasps;
mod instructions;
pub mod machines;
mod matrices;
#[path = "../../../crates/core/behavior/examples/pick_place/mod.rs"]
mod pick_place;
mod rounds;
pub(crate) mod subject;
mod tasks;
pub mod trees;

use std::error::Error;
use std::io::stdout;

use cell_rt::priority::{self, CONTROLLER_PRIORITY};

use crate::report::Report;
use subject::Subject;

type Group = fn() -> Result<Vec<Subject>, Box<dyn Error>>;

/// How to get the rows of other libraries.
const MISSING: &str = "other libraries are not measured: `cargo run --release --manifest-path \
                       benches/peers/Cargo.toml behavior` builds a program that has them";

/// The rows in their order, in groups that are set up separately.
const GROUPS: [Group; 4] = [
    trees::subjects,
    machines::subjects,
    matrices::subjects,
    tasks::subjects,
];

/// The same work in other libraries.
pub struct Peers {
    /// Their rows.
    pub rows: fn() -> Vec<Subject>,
    /// Their versions.
    pub note: String,
}

fn subjects(peers: Option<&Peers>) -> Result<Vec<Subject>, Box<dyn Error>> {
    let mut all = Vec::new();
    for group in GROUPS {
        all.extend(group()?);
    }
    all.extend(peers.into_iter().flat_map(|peers| (peers.rows)()));
    Ok(all)
}

// For the instruction counter: one row alone, a given number of times.
pub(crate) fn only(row: &str, times: &str, peers: Option<&Peers>) -> Result<(), Box<dyn Error>> {
    let times: u64 = times.parse()?;
    let mut all = subjects(peers)?;
    let subject = all.iter_mut().find(|it| it.name == row);
    let subject = subject.ok_or_else(|| format!("unknown row '{row}'"))?;
    (subject.work)(times);
    Ok(())
}

pub(crate) fn bench(json: bool, peers: Option<&Peers>) -> Result<(), Box<dyn Error>> {
    let granted = priority::request(CONTROLLER_PRIORITY, Some(0));
    let mut report = Report::new("behavior", granted.fifo, &granted.refused);
    let mut all = subjects(peers)?;
    report.notes.push(format!(
        "each sample is the mean of {} in a row; rows take turns",
        rounds::TIMES
    ));
    let note = peers.map(|peers| peers.note.clone());
    report
        .notes
        .push(note.unwrap_or_else(|| MISSING.to_owned()));
    report.rows.extend(rounds::times(&mut all));
    report.rows.extend(grasps::rows()?);
    report.rows.extend(rounds::allocations(&mut all));
    // Instructions are the same on a loaded machine, but need valgrind.
    match instructions::rows(&all) {
        Ok(rows) => report.rows.extend(rows),
        Err(why) => report
            .notes
            .push(format!("instructions: not measured: {why}")),
    }
    for subject in &all {
        let Some(own) = subject.peer_of else {
            continue;
        };
        for suffix in ["", rounds::ALLOCATIONS, instructions::SUFFIX] {
            report.compare(
                &format!("{own}{suffix}"),
                &format!("{}{suffix}", subject.name),
            );
        }
    }
    report.write(&mut stdout().lock(), json)?;
    Ok(())
}
