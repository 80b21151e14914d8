//! Shorter paths: corners are cut where the straight line is free.

use crate::check::{Checker, distance};
use crate::halton;

/// Cuts corners of `path`: first whole waypoints, then `rounds` times between two points
/// anywhere on it.
pub(crate) fn shorten(path: &mut Vec<Vec<f64>>, checker: &mut Checker<'_>, rounds: u64, seed: u64) {
    // Whole waypoints first: it costs few checks, and a path of two waypoints needs no more.
    leave_out(path, checker);
    for round in 0..rounds {
        // A straight path cannot get shorter.
        if path.len() < 3 {
            return;
        }
        let (one, other) = (
            halton::value(seed.wrapping_add(round + 1), 0),
            halton::value(seed.wrapping_add(round + 1), 1),
        );
        cut(path, checker, one.min(other), one.max(other));
    }
}

/// From each waypoint straight to the last one that can be reached.
fn leave_out(path: &mut Vec<Vec<f64>>, checker: &mut Checker<'_>) {
    let mut from = 0;
    while from + 2 < path.len() {
        let mut to = path.len() - 1;
        while to > from + 1 && !checker.is_edge_free(&path[from], &path[to]) {
            to -= 1;
        }
        path.drain(from + 1..to);
        from += 1;
    }
}

/// Straight from the point at `one` of the path's length to that at `other`.
fn cut(path: &mut Vec<Vec<f64>>, checker: &mut Checker<'_>, one: f64, other: f64) {
    let total = length(path);
    let ((first, from), (last, to)) = (point(path, one * total), point(path, other * total));
    if last > first && checker.is_edge_free(&from, &to) {
        path.splice(first + 1..=last, [from, to]);
    }
}

/// The point after `along` of the path, and the waypoint before it.
fn point(path: &[Vec<f64>], mut along: f64) -> (usize, Vec<f64>) {
    let last = path.len() - 2;
    for (index, pair) in path.windows(2).enumerate() {
        let edge = distance(&pair[0], &pair[1]);
        if along <= edge || index == last {
            let part = (along / edge.max(f64::MIN_POSITIVE)).min(1.0);
            let joints = pair[0].iter().zip(&pair[1]);
            return (index, joints.map(|(a, b)| a + part * (b - a)).collect());
        }
        along -= edge;
    }
    (0, path[0].clone())
}

/// Length in joint space (rad and m alike).
pub(crate) fn length(path: &[Vec<f64>]) -> f64 {
    let edges = path.windows(2);
    edges.map(|pair| distance(&pair[0], &pair[1])).sum()
}
