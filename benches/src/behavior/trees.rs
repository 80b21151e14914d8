//! Our trees.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use behavior::board::Board;

use super::pick_place::{pick_and_place, run};
use super::subject::Subject;

/// Row of the tree that is like that of the other library.
pub const TICK: &str = "tree, 27 nodes: tick";

/// The tree with empty leaves: a tick of it, and its record.
pub(crate) fn subjects() -> Result<Vec<Subject>, Box<dyn Error>> {
    let mut ticked = pick_and_place()?;
    let mut saved = pick_and_place()?;
    let (mut shared, mut calls) = (Board::new(), 0);
    // In the middle of the job.
    for tick in 0..35 {
        saved.tick(Duration::from_millis(tick), &mut shared, &mut calls);
    }
    let mut record = Vec::new();
    Ok(vec![
        Subject::new(TICK, move |times| {
            black_box(run(&mut ticked, times));
        }),
        Subject::new("tree, 27 nodes: record", move |times| {
            for _ in 0..times {
                record.clear();
                saved.save(&mut record);
                black_box(record.as_slice());
            }
        }),
    ])
}
