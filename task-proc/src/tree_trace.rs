//! What a tree did in a tick, as trace lines.

use behavior::tree::{EventKind, Host, Tree};

use crate::output::Output;

/// Adds the events of the last tick of `tree`, which is picture `graph` of the
/// policy.
pub fn events<H: Host>(tree: &Tree<H>, graph: usize, out: &mut Output) {
    for event in tree.events() {
        let place = (graph, event.node);
        match event.kind {
            EventKind::Status { from, to, reason } => {
                let reason = reason.map_or("", behavior::ResetReason::name);
                out.status(place, from, to, reason);
            }
            EventKind::Guard { holds } => out.guard(place, "guard", holds),
            EventKind::Fault(fault) => {
                out.log(format_args!("[fault] node {}: {fault}", event.node));
            }
            EventKind::Overflow => {
                out.log(format_args!(
                    "[fault] more happened in one tick than is kept"
                ));
            }
        }
    }
}
