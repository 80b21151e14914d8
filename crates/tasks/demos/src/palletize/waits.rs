//! What the job waits for while it can neither pick a bin nor set one down, and when it gives up.

use ipc_types::Text;
use robocell_skills::setup::ARM;
use robocell_task::{Job, Output, PolicyTime, TraceEvent};

use super::geometry::{Lie, lie};
use super::memory::Work;
use super::scene::View;
use crate::failure::Failure;

/// Time in which a person can make room, or bring a bin back (s).
const PATIENCE_S: f64 = 20.0;

/// The bin to pick next, if it can be set down. Fails the job if one that is left cannot be, or
/// cannot be gripped.
pub(super) fn next_bin(view: &View<'_>, job: &mut Job, out: &mut Output) -> Option<usize> {
    let next = view.next_bin();
    let free = next.filter(|bin| view.free_slot(*bin).is_ok());
    let left = match free {
        Some(_) => None,
        None => next.or_else(|| view.left_over()),
    };
    let Some(left) = left else {
        note(None, view, job);
        return free;
    };
    let name = view.setup.name(left);
    let leans = view
        .bin(left)
        .is_some_and(|seen| lie(&seen.pose) == Lie::Tilted);
    let (failure, why) = match view.free_slot(left) {
        _ if leans => (Failure::BinCannotBeGripped, "it leans".to_owned()),
        Err(blocked) => (Failure::PlaceTaken, no_place(view, blocked)),
        // It moves, or comes on the belt.
        Ok(_) => return None,
    };
    let since = note(Some(view.now), view, job);
    patience(since, failure, &format!("{name}: {why}"), view, job, out);
    None
}

/// Whether there is a place now for the bin on the cup. Fails the job if there is none for long.
pub(super) fn for_place(work: &Work, view: &View<'_>, job: &mut Job, out: &mut Output) -> bool {
    let Err(blocked) = view.free_slot(work.bin) else {
        return true;
    };
    let name = view.setup.name(work.bin);
    let why = format!("{name}: {}", no_place(view, blocked));
    patience(work.began, Failure::PlaceTaken, &why, view, job, out);
    false
}

fn no_place(view: &View<'_>, blocked: Option<(usize, usize)>) -> String {
    match blocked {
        Some((slot, bin)) => format!("place {} is taken by {}", slot + 1, view.setup.name(bin)),
        None => "all places are full".to_owned(),
    }
}

/// Sets the start of the wait, which the job has; returns it.
fn note(now: Option<PolicyTime>, view: &View<'_>, job: &mut Job) -> PolicyTime {
    let Some(since) = job.unreachable_since.get_mut(ARM) else {
        return view.now;
    };
    *since = now.and(since.or(now));
    since.unwrap_or(view.now)
}

/// Reports a wait, and fails the job after some time.
fn patience(
    since: PolicyTime,
    failure: Failure,
    why: &str,
    view: &View<'_>,
    job: &mut Job,
    out: &mut Output,
) {
    if since == view.now {
        out.log(format_args!("[wait] {why}"));
    }
    if view.now.since(since) >= PolicyTime::from_seconds(PATIENCE_S) {
        fail(failure, format_args!("{why}"), job, out);
    } else {
        out.wait = Text::format(format_args!("{why}"));
    }
}

/// Fails the job; `why` is for the log.
pub(super) fn fail(
    failure: Failure,
    why: std::fmt::Arguments<'_>,
    job: &mut Job,
    out: &mut Output,
) {
    out.event(TraceEvent::Fault, format_args!("[failed] {why}"));
    job.fail(failure.reason());
}
