//! Fewer triangles for the same shape: edges are collapsed, the one that moves
//! the surface least first. Open borders stay where they are.

mod quadric;
mod surface;

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use crate::mesh::{ColourMesh, Vec3, add, length, scale, sub};
use surface::Surface;

/// Makes long edges a little dearer, so that flat areas get even triangles.
/// Times length to the fourth, the unit of the error.
const LENGTH_PRICE: f64 = 1e-7;

/// Reduces a welded mesh to about `share` (0 to 1) of its triangles, and to no
/// fewer than `least`. The same input gives the same output, bit for bit. Where
/// the shape allows no further collapse the result has more triangles.
pub fn decimate(mesh: &ColourMesh, share: f64, least: usize) -> ColourMesh {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a count"
    )]
    let target = (mesh.triangles.len() as f64 * share.clamp(0.0, 1.0)) as usize;
    let target = target.max(least);
    let mut surface = Surface::new(mesh);
    let mut heap: BinaryHeap<Reverse<Collapse>> = BinaryHeap::new();
    for (a, b) in surface.edges() {
        heap.push(Reverse(Collapse::plan(&surface, a, b)));
    }
    while surface.triangle_count() > target {
        let Some(Reverse(collapse)) = heap.pop() else {
            break;
        };
        let Collapse { a, b, at, .. } = collapse;
        // The heap cannot change an entry: each edge of a moved point is pushed again, and the ages
        // of the points mark the older entries.
        if collapse.is_stale(&surface) || !surface.allows(a, b, at) {
            continue;
        }
        surface.collapse(a, b, at);
        for other in surface.neighbours(a) {
            heap.push(Reverse(Collapse::plan(
                &surface,
                a.min(other),
                a.max(other),
            )));
        }
    }
    surface.into_mesh(mesh.colour)
}

/// One edge that could go.
#[derive(Debug, Clone, Copy)]
struct Collapse {
    cost: f64,
    a: u32,
    b: u32,
    /// Where the merged point would be.
    at: Vec3,
    /// Ages of both points when this was planned.
    ages: [u32; 2],
}

impl Collapse {
    fn plan(surface: &Surface, a: u32, b: u32) -> Self {
        let (pa, pb) = (surface.position(a), surface.position(b));
        let error = surface.quadric(a).plus(surface.quadric(b));
        let span = length(sub(pa, pb));
        let middle = scale(add(pa, pb), 0.5);
        let candidates = match (surface.is_border(a), surface.is_border(b)) {
            (true, false) => [Some(pa), None, None, None],
            (false, true) => [Some(pb), None, None, None],
            _ => {
                // A minimum far off the edge is one of a nearly flat form.
                let best = error.minimum().filter(|p| length(sub(*p, middle)) <= span);
                [best, Some(middle), Some(pa), Some(pb)]
            }
        };
        let (at, cost) = candidates
            .into_iter()
            .flatten()
            .map(|p| (p, error.at(p)))
            .min_by(|x, y| x.1.total_cmp(&y.1))
            .unwrap_or((middle, f64::INFINITY));
        let square = span * span;
        Self {
            cost: cost + LENGTH_PRICE * square * square,
            a,
            b,
            at,
            ages: [surface.age(a), surface.age(b)],
        }
    }

    fn is_stale(&self, surface: &Surface) -> bool {
        self.ages != [surface.age(self.a), surface.age(self.b)]
    }
}

impl PartialEq for Collapse {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Collapse {}

impl PartialOrd for Collapse {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Collapse {
    /// By cost; by place where costs are equal, so that no chance decides.
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |c: &Self| (c.a, c.b, c.ages);
        self.cost
            .total_cmp(&other.cost)
            .then_with(|| place(self).cmp(&place(other)))
    }
}

#[cfg(test)]
mod tests;
