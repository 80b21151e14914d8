//! Keys that are written and never read, or read and never written.

use crate::board::{Access, Board};
use crate::finding::Finding;

pub(super) fn check(local: &Board, shared: &Board, findings: &mut Vec<Finding>) {
    board(local, "local", findings);
    board(shared, "shared", findings);
}

fn board(board: &Board, scope: &str, findings: &mut Vec<Finding>) {
    for (index, key) in board.keys().enumerate() {
        let mut readers = board.users(index).filter(|u| u.1 == Access::Read);
        let mut writers = board.users(index).filter(|u| u.1 != Access::Read);
        let place = format!("{scope}.{}", key.name);
        // A key for people and other programs has its readers outside of the tree.
        if key.observed {
            continue;
        }
        match (readers.next(), writers.next()) {
            (Some((reader, _)), None) if key.default.is_none() => findings.push(Finding {
                rule: "read_never_written",
                place,
                message: format!(
                    "'{reader}' reads it, but no node writes it and it has no default; give it one"
                ),
            }),
            // A shared key may be read by another tree; of several writers one may write in
            // order to read, since `Write` includes reading.
            (None, Some((writer, _))) if scope == "local" && writers.next().is_none() => findings
                .push(Finding {
                    rule: "written_never_read",
                    place,
                    message: format!(
                        "'{writer}' writes it, but no other node reads it; take it out"
                    ),
                }),
            _ => {}
        }
    }
}
